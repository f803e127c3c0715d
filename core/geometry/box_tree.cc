#include "core/geometry/box_tree.h"

#include <algorithm>
#include <tuple>

namespace pliant {
namespace {}  // namespace

BoxTree::BoxTree(std::span<const BoundingBox> boxes) {
  items_.reserve(boxes.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    items_.push_back({boxes[i], static_cast<std::int32_t>(i)});
  }
  if (!items_.empty()) Build();
}

void BoxTree::Build() {
  struct Task {
    std::int32_t first;
    std::int32_t count;
    std::int32_t parent;  // Whose second child this is; -1 for a first child and the root.
  };
  std::vector<Task> tasks = {{0, static_cast<std::int32_t>(items_.size()), -1}};
  while (!tasks.empty()) {
    const Task task = tasks.back();
    tasks.pop_back();
    const auto at = static_cast<std::int32_t>(nodes_.size());
    if (task.parent >= 0) nodes_[static_cast<std::size_t>(task.parent)].second = at;
    Node node{.box = items_[static_cast<std::size_t>(task.first)].box,
              .first = task.first,
              .count = task.count};
    for (std::int32_t i = 1; i < task.count; ++i) {
      Extend(node.box, items_[static_cast<std::size_t>(task.first + i)].box);
    }
    nodes_.push_back(node);
    if (task.count <= kLeafSize) continue;
    SplitAtMedian(node);
    const std::int32_t half = task.count / 2;
    tasks.push_back({task.first + half, task.count - half, at});
    tasks.push_back({task.first, half, -1});
  }
}

void BoxTree::SplitAtMedian(const Node& node) {
  // Halves before the sum: the sum of two large coordinates could overflow.
  const bool along_x =
      0.5 * node.box.high.x - 0.5 * node.box.low.x >= 0.5 * node.box.high.y - 0.5 * node.box.low.y;
  const auto center = [along_x](const Item& item) {
    return along_x ? 0.5 * item.box.low.x + 0.5 * item.box.high.x
                   : 0.5 * item.box.low.y + 0.5 * item.box.high.y;
  };
  const auto first = items_.begin() + node.first;
  std::nth_element(first, first + node.count / 2, first + node.count,
                   [&center](const Item& a, const Item& b) {
                     return std::tuple(center(a), a.index) < std::tuple(center(b), b.index);
                   });
}

}  // namespace pliant
