#pragma once

#include <atomic>

#include "core/base/executor.h"
#include "core/base/stop_signal.h"

namespace pliant {

/// Passes tasks on to another executor until a signal asks it to stop: from then on it skips them.
/// Who made something in several Runs asks stopped() at the end, and then throws it away.
///
/// *Invariants*: once a task was skipped, no task of a later Run is carried out, so that none reads
/// what an earlier one was to write.
class StoppableExecutor final : public Executor {
 public:
  /// @param executor, signal  not owned; a null signal never asks.
  StoppableExecutor(Executor& executor, const StopSignal* signal)
      : executor_(executor), signal_(signal) {}

  void Run(std::int32_t count, const Task& task) override {
    if (signal_ == nullptr) {
      executor_.Run(count, task);
      return;
    }
    executor_.Run(count, [&](std::int32_t index) {
      if (!stopped_.load(std::memory_order_relaxed) && !signal_->asked()) {
        task(index);
      } else {
        stopped_.store(true, std::memory_order_relaxed);
      }
    });
  }

  [[nodiscard]] bool stopped() const override { return stopped_.load(std::memory_order_relaxed); }

 private:
  Executor& executor_;
  const StopSignal* signal_;
  std::atomic<bool> stopped_ = false;
};

}  // namespace pliant
