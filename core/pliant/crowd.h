#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/mesh/star.h"

namespace pliant {

/// What a node makes of given vertices around it that stand closer together than the metric asks
/// for, such as the points of a finely drawn curve: the loop can neither move nor delete them.
///
/// Each would push the node away as if it stood for a whole edge, and count as one more neighbour
/// among which the node has room; so the first nodes beside such a curve stood 1.4 to 1.75 lengths
/// away from it, and too few of them. Together they count as what their edges are long: a vertex
/// pushes with half the lengths of its two edges of the ring between given vertices, a ring has as
/// many neighbours as these edges are long. Edges of length 1 and more change nothing.
/// *Threads*: one caller at a time.
class Crowd {
 public:
  /// Looks at the ring of a star.
  /// @par Cost nearly nothing where no two given vertices are neighbours on the ring
  void Measure(const Mesh& mesh, const Star& star) {
    is_any_ = HasGivenPair(mesh, star) && MeasureLinks(mesh, star);
  }
  /// True if given vertices are crowded there.
  [[nodiscard]] bool is_any() const { return is_any_; }

  /// The share of its force with which each ring vertex pushes; empty: all with all of it.
  [[nodiscard]] std::span<const double> weights() const {
    return is_any_ ? std::span<const double>(weights_) : std::span<const double>();
  }
  /// As how many neighbours a closed ring of so many counts; 3 at least where any are crowded.
  [[nodiscard]] double NeighborCount(std::size_t ring_count) const {
    return is_any_ ? neighbor_count_ : static_cast<double>(ring_count);
  }

 private:
  [[nodiscard]] static bool HasGivenPair(const Mesh& mesh, const Star& star) {
    bool is_given = star.closed() && mesh.vertex(star.ring().back()).fixed;
    for (const VertexId vertex : star.ring()) {
      const bool was_given = is_given;
      is_given = mesh.vertex(vertex).fixed;
      if (was_given && is_given) return true;
    }
    return false;
  }
  bool MeasureLinks(const Mesh& mesh, const Star& star);

  bool is_any_ = false;
  double neighbor_count_ = 0;
  std::vector<double> weights_;
};

}  // namespace pliant
