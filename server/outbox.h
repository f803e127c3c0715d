#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <utility>

namespace pliant::server {

/// Messages that wait for a slow reader, in order.
///
/// An answer must never be lost, so Push always takes it; instead, whoever makes answers looks at
/// has_room() first and makes none without. So at most the bound and the answer to one command are
/// held. What may be lost (progress) is dropped by its maker when there is no room.
///
/// *Threads*: none of its own; the owner's mutex guards it.
template <class T>
class Outbox {
 public:
  explicit Outbox(std::size_t bytes_max) : bytes_max_(bytes_max) {}

  [[nodiscard]] bool has_room() const { return bytes_ < bytes_max_; }
  [[nodiscard]] bool empty() const { return items_.empty(); }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }

  void Push(T item, std::size_t item_bytes) {
    bytes_ += item_bytes;
    items_.emplace_back(std::move(item), item_bytes);
  }

  /// The oldest message; nothing if empty.
  [[nodiscard]] std::optional<T> Pop() {
    if (items_.empty()) return std::nullopt;
    std::optional<T> item(std::move(items_.front().first));
    bytes_ -= items_.front().second;
    items_.pop_front();
    return item;
  }

 private:
  std::size_t bytes_max_;
  std::deque<std::pair<T, std::size_t>> items_;
  std::size_t bytes_ = 0;
};

}  // namespace pliant::server
