#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "core/base/rng.h"

namespace pliant::client {

/// Pauses between tries to connect again: doubled each time and spread at random, so that clients
/// that lost one server do not come back all at once.
class Backoff {
 public:
  explicit Backoff(std::uint64_t seed) : rng_(seed) {}

  /// From half to all of 20 ms at first, of 2 s in the end.
  [[nodiscard]] std::chrono::milliseconds Next() {
    const auto pause = std::chrono::milliseconds(static_cast<std::int64_t>(pause_ms_));
    const double share = rng_.Uniform(0.5, 1);
    pause_ms_ = std::min(2 * pause_ms_, 2000.0);
    return std::chrono::milliseconds(
        static_cast<std::int64_t>(static_cast<double>(pause.count()) * share));
  }

 private:
  Rng rng_;
  double pause_ms_ = 20;
};

}  // namespace pliant::client
