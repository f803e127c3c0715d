#include "core/base/stoppable_executor.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/threads/thread_pool.h"
#include "tests/support/stop_after.h"

namespace pliant {
namespace {

TEST(StoppableExecutor, RunsEverythingUntilItIsAskedToStop) {
  InlineExecutor alone;
  const testing::StopAfter signal(4);
  StoppableExecutor executor(alone, &signal);
  std::vector<int> done;
  executor.Run(3, [&](std::int32_t index) { done.push_back(index); });
  EXPECT_FALSE(executor.stopped());
  executor.Run(3, [&](std::int32_t index) { done.push_back(10 + index); });
  EXPECT_TRUE(executor.stopped());
  EXPECT_EQ(done, (std::vector{0, 1, 2}));
}

TEST(StoppableExecutor, IsTheOtherExecutorWithoutASignal) {
  InlineExecutor alone;
  StoppableExecutor executor(alone, nullptr);
  int count = 0;
  executor.Run(5, [&](std::int32_t) { ++count; });
  EXPECT_EQ(count, 5);
  EXPECT_FALSE(executor.stopped());
}

// Goal: no task reads what a skipped one was to write. Method: on threads, each task of a second
// Run needs all of the first; the signal says yes at every place in turn.
TEST(StoppableExecutor, CarriesOutNoTaskAfterARunThatSkippedOne) {
  ThreadPool pool(2);
  for (int place = 1; place < 40; ++place) {
    const testing::StopAfter signal(place);
    StoppableExecutor executor(pool, &signal);
    std::vector<int> made(16, 0);
    executor.Run(16, [&](std::int32_t index) { made[static_cast<std::size_t>(index)] = 1; });
    executor.Run(16, [&](std::int32_t index) {
      for (const int one : made) ASSERT_EQ(one, 1) << "task " << index << ", stop at " << place;
    });
    EXPECT_EQ(executor.stopped(), place <= 32);
  }
}

}  // namespace
}  // namespace pliant
