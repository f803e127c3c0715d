#pragma once

#include <atomic>
#include <utility>

namespace pliant {

/// A value that is made at the first question for it, by whoever asks first; others wait.
///
/// *Threads*: Get from as many as you like.
template <class T>
class Lazy {
 public:
  /// True if the value is there.
  [[nodiscard]] bool made() const { return state_.load(std::memory_order_acquire) == kMade; }

  /// @param make  returns the value; called once, or again if it threw.
  template <class Make>
  const T& Get(Make&& make) {
    int state = state_.load(std::memory_order_acquire);
    while (state != kMade) {
      if (state == kNone && state_.compare_exchange_weak(state, kBeingMade)) {
        MakeNow(std::forward<Make>(make));
        break;
      }
      if (state == kBeingMade) state_.wait(kBeingMade);
      state = state_.load(std::memory_order_acquire);
    }
    return value_;
  }

 private:
  static constexpr int kNone = 0;
  static constexpr int kBeingMade = 1;
  static constexpr int kMade = 2;

  template <class Make>
  void MakeNow(Make&& make) {
    try {
      value_ = std::forward<Make>(make)();
    } catch (...) {
      state_.store(kNone, std::memory_order_release);
      state_.notify_all();
      throw;
    }
    state_.store(kMade, std::memory_order_release);
    state_.notify_all();
  }

  std::atomic<int> state_ = kNone;
  T value_;
};

}  // namespace pliant
