#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "core/base/ids.h"
#include "core/base/rng.h"

namespace pliant {

/// The active nodes, in the order in which they became active. Entries of nodes that died or were
/// visited meanwhile stay until their turn; the taker skips them.
class NodeQueue {
 public:
  void Push(VertexId node) { nodes_.push_back(node); }

  /// The oldest entry: keeps neighbours together, and so memory access local. @pre !empty()
  VertexId PopFirst() {
    const VertexId node = nodes_[head_++];
    if (head_ == nodes_.size()) {
      nodes_.clear();  // So that a copy of an empty queue costs nothing.
      head_ = 0;
    } else if (head_ >= kCompactFrom && 2 * head_ >= nodes_.size()) {
      nodes_.erase(nodes_.begin(), nodes_.begin() + static_cast<std::ptrdiff_t>(head_));
      head_ = 0;
    }
    return node;
  }

  /// A random entry, as the paper picks. @pre !empty()
  VertexId PopRandom(Rng& rng) {
    const std::size_t index = head_ + static_cast<std::size_t>(rng.Below(size()));
    const VertexId node = nodes_[index];
    nodes_[index] = nodes_.back();
    nodes_.pop_back();
    return node;
  }

  /// All entries in order; none are left.
  std::vector<VertexId> TakeAll() {
    nodes_.erase(nodes_.begin(), nodes_.begin() + static_cast<std::ptrdiff_t>(head_));
    head_ = 0;
    return std::exchange(nodes_, {});
  }

  /// The entry that PopFirst gives after `count` others; none if there are fewer.
  [[nodiscard]] VertexId Ahead(std::size_t count) const {
    return head_ + count < nodes_.size() ? nodes_[head_ + count] : VertexId();
  }

  [[nodiscard]] bool empty() const { return head_ == nodes_.size(); }
  [[nodiscard]] std::size_t size() const { return nodes_.size() - head_; }

  /// Entries in order.
  [[nodiscard]] std::span<const VertexId> entries() const {
    return std::span(nodes_).subspan(head_);
  }

  /// Entries in order; for renumbering.
  template <class Function>
  void Transform(Function&& function) {
    for (std::size_t i = head_; i < nodes_.size(); ++i) nodes_[i] = function(nodes_[i]);
  }

 private:
  static constexpr std::size_t kCompactFrom = 1 << 16;

  std::vector<VertexId> nodes_;
  std::size_t head_ = 0;
};

}  // namespace pliant
