#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <utility>
#include <vector>

namespace pliant::server {

/// What waits for the thread that writes, bounded by bytes: who puts something in waits while it is
/// full. An item of any size enters an empty queue.
///
/// *Threads*: Put from any, Take from one.
template <class Item>
class WriteQueue {
 public:
  explicit WriteQueue(std::size_t bytes_max) : bytes_max_(bytes_max) {}

  void Put(Item item, std::size_t bytes) {
    std::unique_lock lock(mutex_);
    room_.wait(lock, [&] { return items_.empty() || bytes_ + bytes <= bytes_max_; });
    items_.emplace_back(std::move(item), bytes);
    bytes_ += bytes;
    filled_.notify_one();
  }

  /// Everything that waits, up to `count_max` items, oldest first; waits for the first of them.
  /// Empty after Close, when nothing is left.
  std::vector<Item> Take(std::size_t count_max) {
    std::unique_lock lock(mutex_);
    filled_.wait(lock, [&] { return closed_ || !items_.empty(); });
    std::vector<Item> taken;
    while (!items_.empty() && taken.size() < count_max) {
      bytes_ -= items_.front().second;
      taken.push_back(std::move(items_.front().first));
      items_.pop_front();
    }
    room_.notify_all();
    return taken;
  }

  [[nodiscard]] bool empty() const {
    const std::lock_guard lock(mutex_);
    return items_.empty();
  }
  void Close() {
    const std::lock_guard lock(mutex_);
    closed_ = true;
    filled_.notify_all();
  }

 private:
  const std::size_t bytes_max_;
  mutable std::mutex mutex_;  // Guards all below; a leaf lock.
  std::condition_variable filled_;
  std::condition_variable room_;
  std::deque<std::pair<Item, std::size_t>> items_;
  std::size_t bytes_ = 0;
  bool closed_ = false;
};

}  // namespace pliant::server
