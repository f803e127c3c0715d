#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "core/base/executor.h"

namespace pliant::bench {

/// Runs tasks one after the other, takes each one's CPU time, and works out how long several
/// threads would have taken: the next task always goes to the thread that is free first, as in
/// ThreadPool. On a busy machine this says more than wall time, and for more threads than cores; it
/// knows nothing of memory that threads share, nor of waking them.
class ScheduleExecutor final : public Executor {
 public:
  void Run(std::int32_t count, const Task& task) override;

  /// CPU seconds that so many threads would save of what one takes; for 2, 4, 8 and 16.
  [[nodiscard]] const std::map<int, double>& saved_s() const { return saved_s_; }

 private:
  std::map<int, double> saved_s_{{2, 0}, {4, 0}, {8, 0}, {16, 0}};
};

/// When the last of the tasks ends on so many threads, each task begun in order by the first that
/// is free.
[[nodiscard]] double Makespan(const std::vector<double>& durations, int thread_count);

}  // namespace pliant::bench
