#pragma once

#include <atomic>
#include <cstdint>
#include <functional>

namespace pliant::server {

/// How much memory a server holds, and how much it may: what its sessions say that they hold,
/// roughly, and what was measured besides.
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
    if (bytes > 0 && limit_ > 0 && used + besides_ > limit_) on_over_();
  }
  /// The process was measured and holds so much more than its sessions say.
  void SetBesides(std::int64_t bytes) { besides_ = bytes; }
  /// What sessions say that they hold.
  [[nodiscard]] std::int64_t used() const { return used_; }
  /// Beyond the limit, in bytes; at most 0 if there is none.
  [[nodiscard]] std::int64_t excess() const { return limit_ > 0 ? used_ + besides_ - limit_ : 0; }

 private:
  const std::int64_t limit_;
  const std::function<void()> on_over_;
  std::atomic<std::int64_t> used_ = 0;
  std::atomic<std::int64_t> besides_ = 0;
};

}  // namespace pliant::server
