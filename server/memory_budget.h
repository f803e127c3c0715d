#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

namespace pliant::server {

/// How much memory the sessions of a server hold, roughly, and how much they may.
///
/// *Threads*: all functions from any thread.
class MemoryBudget {
 public:
  /// @param limit    in bytes; 0: none
  /// @param on_over  called, without any lock, when a session grows while the limit is exceeded
  MemoryBudget(std::int64_t limit, std::function<void()> on_over)
      : limit_(limit), on_over_(std::move(on_over)) {}

  /// A session holds so much more, or less.
  void Add(std::int64_t bytes) {
    const std::int64_t used = used_ += bytes;
    if (bytes > 0 && limit_ > 0 && used > limit_) on_over_();
  }
  [[nodiscard]] std::int64_t used() const { return used_; }
  /// Beyond the limit, in bytes; at most 0 if there is none.
  [[nodiscard]] std::int64_t excess() const { return limit_ > 0 ? used_ - limit_ : 0; }

 private:
  const std::int64_t limit_;
  const std::function<void()> on_over_;
  std::atomic<std::int64_t> used_ = 0;
};

}  // namespace pliant::server
