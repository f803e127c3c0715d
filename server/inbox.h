#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <utility>

namespace pliant::server {

/// How much may wait.
struct QueueBounds {
  std::size_t count_max = 0;
  std::size_t bytes_max = 0;
};

/// Commands that wait for their session, first in, first out, bounded by count and bytes.
///
/// The bound on bytes stops what comes after the item that reached it, so that one item of any
/// allowed size always fits into an empty inbox.
///
/// *Invariants*: count() <= count_max; bytes() < bytes_max + the size of one item.
/// *Threads*: none of its own; the owner's mutex guards it.
template <class T>
class Inbox {
 public:
  explicit Inbox(QueueBounds bounds) : bounds_(bounds) {}

  /// True while Push takes nothing more.
  [[nodiscard]] bool full() const {
    return items_.size() >= bounds_.count_max || bytes_ >= bounds_.bytes_max;
  }
  [[nodiscard]] bool empty() const { return items_.empty(); }
  [[nodiscard]] std::size_t count() const { return items_.size(); }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

  /// Takes an item, unless full(): then it comes back.
  [[nodiscard]] std::optional<T> Push(T item, std::size_t item_bytes) {
    if (full()) return item;
    bytes_ += item_bytes;
    items_.emplace_back(std::move(item), item_bytes);
    return std::nullopt;
  }

  /// Shows the items, oldest first, until `look` says false.
  template <class Look>
  void LookThrough(const Look& look) const {
    for (const auto& [item, bytes] : items_) {
      if (!look(item)) return;
    }
  }

  /// The oldest item; nothing if empty.
  [[nodiscard]] std::optional<T> Pop() {
    if (items_.empty()) return std::nullopt;
    std::optional<T> item(std::move(items_.front().first));
    bytes_ -= items_.front().second;
    items_.pop_front();
    return item;
  }

 private:
  QueueBounds bounds_;
  std::deque<std::pair<T, std::size_t>> items_;
  std::size_t bytes_ = 0;
};

}  // namespace pliant::server
