#pragma once

#include <cstdint>

#include "core/base/executor.h"

namespace pliant::testing {

/// From the last task to the first, which no result may show.
class BackwardExecutor final : public Executor {
 public:
  void Run(std::int32_t count, const Task& task) override {
    while (count > 0) task(--count);
  }
};

}  // namespace pliant::testing
