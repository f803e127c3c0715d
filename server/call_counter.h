#pragma once

#include <condition_variable>
#include <mutex>

#include "server/clock.h"

namespace pliant::server {

/// Counts the calls that are being served, so that a shutdown can wait for them and not for idle
/// connections, whose clients may not even look.
///
/// *Threads*: all functions from any thread.
class CallCounter {
 public:
  void Begin() {
    const std::lock_guard lock(mutex_);
    ++count_;
  }
  void End() {
    const std::lock_guard lock(mutex_);
    if (--count_ == 0) none_.notify_all();
  }
  /// Waits until no call is being served, at most this long.
  void WaitForNone(Clock::Duration time_max) {
    std::unique_lock lock(mutex_);
    none_.wait_for(lock, time_max, [this] { return count_ == 0; });
  }

 private:
  std::mutex mutex_;  // Guards count_.
  std::condition_variable none_;
  int count_ = 0;
};

}  // namespace pliant::server
