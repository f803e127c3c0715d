#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "core/geometry/bounding_box.h"
#include "core/geometry/vec2.h"

namespace pliant {

/// A balanced tree of bounding boxes over a fixed set of boxes, numbered as they are given.
///
/// *Invariants*: the tree is cut at medians (equal centres by number), so that its shape depends on
/// the boxes only and its depth is at most log2 of their count.
/// *Threads*: immutable once built.
class BoxTree {
 public:
  BoxTree() = default;
  explicit BoxTree(std::span<const BoundingBox> boxes);

  [[nodiscard]] bool empty() const { return nodes_.empty(); }

  /// Calls visit(index) for every box that has a point in common with `box`, borders included,
  /// until visit says false. A box may be a single point.
  template <class Visit>
  void ForEachMeeting(const BoundingBox& box, Visit visit) const;

  /// Calls visit(index) for boxes that may hold something nearer than what is known.
  ///
  /// @param visit  returns the smallest squared distance known so far, infinity at first; boxes
  ///               farther than that are left out. Boxes exactly as far are not.
  template <class Visit>
  void ForEachNear(Vec2 p, Visit visit) const;

 private:
  static constexpr std::int32_t kLeafSize = 4;
  /// Room for the pending siblings of a path: one a level, and there are at most 32 levels.
  static constexpr std::size_t kStackSize = 64;

  struct Node {
    BoundingBox box;
    std::int32_t first = 0;  ///< Range in items_.
    std::int32_t count = 0;
    std::int32_t second = 0;  ///< Second child; the first one is the next node. 0 for a leaf.
  };
  struct Item {
    BoundingBox box;
    std::int32_t index = 0;
  };

  void Build();
  void SplitAtMedian(const Node& node);

  std::vector<Node> nodes_;
  std::vector<Item> items_;
};

template <class Visit>
void BoxTree::ForEachMeeting(const BoundingBox& box, Visit visit) const {
  if (empty()) return;
  std::array<std::int32_t, kStackSize> stack;
  std::size_t depth = 0;
  stack[depth++] = 0;
  while (depth > 0) {
    const auto at = static_cast<std::size_t>(stack[--depth]);
    const Node& node = nodes_[at];
    if (!Meet(node.box, box)) continue;
    if (node.second != 0) {
      stack[depth++] = node.second;
      stack[depth++] = static_cast<std::int32_t>(at + 1);
      continue;
    }
    for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
      const Item& item = items_[static_cast<std::size_t>(i)];
      if (Meet(item.box, box) && !visit(item.index)) return;
    }
  }
}

template <class Visit>
void BoxTree::ForEachNear(Vec2 p, Visit visit) const {
  if (empty()) return;
  struct Pending {
    std::int32_t node;
    double distance;
  };
  std::array<Pending, kStackSize> stack;
  std::size_t depth = 0;
  const auto push = [&](std::size_t node) {
    stack[depth++] = {static_cast<std::int32_t>(node), SquaredDistance(nodes_[node].box, p)};
  };
  double nearest = std::numeric_limits<double>::infinity();
  push(0);
  while (depth > 0) {
    const Pending pending = stack[--depth];
    if (pending.distance > nearest) continue;
    const auto at = static_cast<std::size_t>(pending.node);
    const Node& node = nodes_[at];
    if (node.second == 0) {
      for (std::int32_t i = node.first; i < node.first + node.count; ++i) {
        const Item& item = items_[static_cast<std::size_t>(i)];
        if (SquaredDistance(item.box, p) <= nearest) nearest = visit(item.index);
      }
      continue;
    }
    push(at + 1);
    push(static_cast<std::size_t>(node.second));
    // The nearer child is taken first.
    if (stack[depth - 2].distance < stack[depth - 1].distance) {
      std::swap(stack[depth - 2], stack[depth - 1]);
    }
  }
}

}  // namespace pliant
