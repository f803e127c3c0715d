#pragma once

#include <atomic>
#include <cstdint>

#include "core/base/stop_signal.h"

namespace pliant::testing {

/// Says yes when it is asked for the n-th time, and from then on.
class StopAfter final : public StopSignal {
 public:
  explicit StopAfter(std::int64_t count) : count_(count) {}
  [[nodiscard]] bool asked() const override { return ++asked_count_ >= count_; }
  [[nodiscard]] std::int64_t asked_count() const { return asked_count_; }

 private:
  const std::int64_t count_;
  mutable std::atomic<std::int64_t> asked_count_ = 0;
};

}  // namespace pliant::testing
