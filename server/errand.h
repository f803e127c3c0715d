#pragma once

#include <functional>
#include <utility>

#include "server/scheduler.h"

namespace pliant::server {

/// Work that is done once, on a worker, because it is too long for the thread that wants it.
class Errand final : public Task {
 public:
  /// @param work  must not throw.
  explicit Errand(std::function<void()> work) : work_(std::move(work)) {}

  Outcome RunSlice(Clock::Time /*slice_end*/) override {
    if (const auto work = std::exchange(work_, nullptr)) work();
    return Outcome::kIdle;
  }

 private:
  std::function<void()> work_;
};

}  // namespace pliant::server
