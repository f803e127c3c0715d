#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/vec2.h"

namespace pliant {

/// The plane cut into parts by straight lines along the axes: each cut halves one part, across its
/// longer side, so that every part gets its share of some sample points.
///
/// *Invariants*: depends on the points as a set, not on their order. *Threads*: immutable.
class PlanePartition {
 public:
  /// @param points      finite, at least one; copied and rearranged.
  /// @param part_count  >= 1; a part may get no point if points coincide.
  /// @param low_share   in (0, 1): the share of the parts, rounded down, that goes to the lower
  /// side
  ///                    of each cut. Different shares put the borders elsewhere, but for a long
  ///                    strip, where every cut goes across.
  /// @par Cost O(n log(part_count))
  PlanePartition(std::vector<Vec2> points, std::int32_t part_count, double low_share);

  /// The part of any point, from 0 on. @par Cost O(log(part_count))
  [[nodiscard]] std::int32_t PartOf(Vec2 p) const {
    std::int32_t node = 0;
    while (nodes_[static_cast<std::size_t>(node)].part < 0) {
      const Node& cut = nodes_[static_cast<std::size_t>(node)];
      node = (cut.by_x ? p.x : p.y) < cut.at ? node + 1 : cut.high;
    }
    return nodes_[static_cast<std::size_t>(node)].part;
  }

 private:
  struct Node {
    double at = 0;           ///< What is below lies in the node that follows, the rest in `high`.
    std::int32_t high = 0;   ///< Index of a node.
    std::int32_t part = -1;  ///< Of a leaf; a cut has -1.
    bool by_x = false;
  };

  void Cut(std::span<Vec2> points, std::int32_t first_part, std::int32_t part_count);

  double low_share_;
  std::vector<Node> nodes_;
};

}  // namespace pliant
