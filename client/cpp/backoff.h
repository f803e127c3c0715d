#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <random>

#include "core/base/rng.h"

namespace pliant::client {

/// Pauses between tries to connect again: doubled each time and spread at random, so that clients
/// that lost one server do not come back all at once.
class Backoff {
 public:
  explicit Backoff(std::uint64_t seed) : rng_(seed) {}

  /// Back to the first pause.
  void Restart() { pause_ms_ = kFirstMs; }

  /// From half to all of 20 ms at first, of 2 s in the end.
  [[nodiscard]] std::chrono::milliseconds Next() {
    const auto pause = std::chrono::milliseconds(static_cast<std::int64_t>(pause_ms_));
    const double share = rng_.Uniform(0.5, 1);
    pause_ms_ = std::min(2 * pause_ms_, 2000.0);
    return std::chrono::milliseconds(
        static_cast<std::int64_t>(static_cast<double>(pause.count()) * share));
  }

 private:
  static constexpr double kFirstMs = 20;

  Rng rng_;
  double pause_ms_ = kFirstMs;
};

/// When to try again after a connection was lost, and when to give up: `bound` after the first
/// failure.
class Outage {
 public:
  using Clock = std::chrono::steady_clock;

  explicit Outage(std::chrono::milliseconds bound)
      : bound_(bound), backoff_(std::random_device{}()) {}

  /// After a failure: how long to wait before the next try; nothing: give up.
  [[nodiscard]] std::optional<std::chrono::milliseconds> NextPause() {
    const Clock::time_point now = Clock::now();
    if (!end_) end_ = now + bound_;
    const std::chrono::milliseconds pause = backoff_.Next();
    if (now + pause > *end_) return std::nullopt;
    return pause;
  }

  /// When to give up. @pre NextPause was called
  [[nodiscard]] Clock::time_point end() const { return *end_; }
  [[nodiscard]] std::chrono::milliseconds bound() const { return bound_; }

  /// What was lost is back: the next failure is the first of another outage.
  void End() {
    end_.reset();
    backoff_.Restart();
  }

 private:
  std::chrono::milliseconds bound_;
  Backoff backoff_;
  std::optional<Clock::time_point> end_;
};

}  // namespace pliant::client
