#pragma once

#include <atomic>
#include <cstdint>

#include "core/base/result.h"

namespace pliant {

/// Somebody who may want long work to end before it is done: a cancel, a deadline. Whoever works
/// asks every few thousand elements, so that the answer takes effect within milliseconds.
///
/// *Threads*: asked() from any thread. Once it has said yes it goes on to, until the work has
/// ended.
class StopSignal {
 public:
  virtual ~StopSignal() = default;
  [[nodiscard]] virtual bool asked() const = 0;
};

/// A signal that is a flag.
class StopFlag final : public StopSignal {
 public:
  explicit StopFlag(bool value = false) : value_(value) {}
  void Set(bool value) { value_.store(value, std::memory_order_relaxed); }
  [[nodiscard]] bool asked() const override { return value_.load(std::memory_order_relaxed); }

 private:
  std::atomic<bool> value_;
};

/// Asks a signal once every kPeriod calls; for loops whose rounds take well under a microsecond.
class StopPoll {
 public:
  static constexpr std::int64_t kPeriod = 4096;

  /// @param signal  not owned; null: nobody wants work to end.
  explicit StopPoll(const StopSignal* signal) : signal_(signal) {}

  /// True if the signal was asked and said yes, now or before. The first call asks it.
  [[nodiscard]] bool operator()() {
    if (signal_ != nullptr && !asked_ && count_++ % kPeriod == 0) asked_ = signal_->asked();
    return asked_;
  }

 private:
  const StopSignal* signal_;
  std::int64_t count_ = 0;
  bool asked_ = false;
};

/// What a call returns that was stopped and has changed nothing.
[[nodiscard]] inline Error Stopped() {
  return {.code = ErrorCode::kCancelled,
          .message = "the update was cancelled before it was taken over; everything is as it was"};
}

}  // namespace pliant
