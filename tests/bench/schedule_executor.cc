#include "tests/bench/schedule_executor.h"

#include <time.h>

#include <algorithm>
#include <numeric>

namespace pliant::bench {
namespace {

double ThreadSeconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

}  // namespace

void ScheduleExecutor::Run(std::int32_t count, const Task& task) {
  std::vector<double> durations;
  durations.reserve(static_cast<std::size_t>(count));
  double last = ThreadSeconds();
  for (std::int32_t index = 0; index < count; ++index) {
    task(index);
    const double now = ThreadSeconds();
    durations.push_back(now - last);
    last = now;
  }
  const double sum = std::accumulate(durations.begin(), durations.end(), 0.0);
  for (auto& [thread_count, saved] : saved_s_) saved += sum - Makespan(durations, thread_count);
}

double Makespan(const std::vector<double>& durations, int thread_count) {
  std::vector<double> free_at(static_cast<std::size_t>(thread_count), 0.0);
  for (const double duration : durations) *std::ranges::min_element(free_at) += duration;
  return std::ranges::max(free_at);
}

}  // namespace pliant::bench
