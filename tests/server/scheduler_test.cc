#include "server/scheduler.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "server/limits.h"
#include "tests/support/fake_server_parts.h"

namespace pliant::server {
namespace {

using std::chrono::milliseconds;

// Needs some virtual time in all and uses up every slice it gets.
class BusyTask final : public Task {
 public:
  BusyTask(ManualClock* clock, Clock::Duration work) : clock_(clock), work_(work) {}

  Outcome RunSlice(Clock::Time slice_end) override {
    ++slice_count;
    const Clock::Duration slice = std::min(slice_end - clock_->Now(), work_);
    clock_->Advance(slice);
    work_ -= slice;
    if (work_ > Clock::Duration(0)) return Outcome::kMore;
    end = clock_->Now();
    return Outcome::kIdle;
  }

  int slice_count = 0;
  Clock::Time end{};

 private:
  ManualClock* clock_;
  Clock::Duration work_;
};

// Goal: a task that wakes waits for one slice of each task that is busy, however much they have to
// do: a huge session does not starve a small one.
// Method: one worker by hand, a clock that only tasks move.
TEST(Scheduler, GivesASmallTaskItsTurnWithinOneRound) {
  ManualClock clock;
  Scheduler scheduler(/*worker_count=*/0, clock);
  std::vector<std::shared_ptr<BusyTask>> huge;
  for (int i = 0; i < 3; ++i) {
    huge.push_back(std::make_shared<BusyTask>(&clock, std::chrono::hours(1)));
    scheduler.Wake(huge.back());
  }
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(scheduler.RunOne());

  const auto small = std::make_shared<BusyTask>(&clock, milliseconds(1));
  const Clock::Time begin = clock.Now();
  scheduler.Wake(small);
  while (small->slice_count == 0) ASSERT_TRUE(scheduler.RunOne());
  EXPECT_LE(small->end - begin, milliseconds(3 * kSliceMs + 1));
}

TEST(Scheduler, SharesTimeEquallyAmongBusyTasks) {
  ManualClock clock;
  Scheduler scheduler(0, clock);
  std::vector<std::shared_ptr<BusyTask>> tasks;
  for (int i = 0; i < 4; ++i) {
    tasks.push_back(std::make_shared<BusyTask>(&clock, std::chrono::hours(1)));
    scheduler.Wake(tasks.back());
  }
  for (int i = 0; i < 400; ++i) ASSERT_TRUE(scheduler.RunOne());
  for (const auto& task : tasks) EXPECT_EQ(task->slice_count, 100);
}

TEST(Scheduler, QueuesATaskOnceHoweverOftenItIsWoken) {
  ManualClock clock;
  Scheduler scheduler(0, clock);
  const auto task = std::make_shared<BusyTask>(&clock, Clock::Duration(1));
  for (int i = 0; i < 5; ++i) scheduler.Wake(task);
  EXPECT_TRUE(scheduler.RunOne());
  EXPECT_FALSE(scheduler.RunOne());
  EXPECT_EQ(task->slice_count, 1);
}

// Wakes itself while it runs, once.
class SelfWakingTask final : public Task, public std::enable_shared_from_this<SelfWakingTask> {
 public:
  explicit SelfWakingTask(Scheduler* scheduler) : scheduler_(scheduler) {}
  Outcome RunSlice(Clock::Time) override {
    if (++slice_count == 1) scheduler_->Wake(shared_from_this());
    return Outcome::kIdle;
  }
  int slice_count = 0;

 private:
  Scheduler* scheduler_;
};

// Goal: nothing that arrives during a slice is forgotten.
TEST(Scheduler, RunsATaskAgainThatWasWokenDuringItsSlice) {
  ManualClock clock;
  Scheduler scheduler(0, clock);
  const auto task = std::make_shared<SelfWakingTask>(&scheduler);
  scheduler.Wake(task);
  while (scheduler.RunOne()) {
  }
  EXPECT_EQ(task->slice_count, 2);
}

// Counts overlapping slices.
class ExclusiveTask final : public Task {
 public:
  Outcome RunSlice(Clock::Time) override {
    if (inside_.exchange(true)) overlapped = true;
    ++slice_count;
    inside_ = false;
    return Outcome::kIdle;
  }
  std::atomic<int> slice_count = 0;
  std::atomic<bool> overlapped = false;

 private:
  std::atomic<bool> inside_ = false;
};

// Goal: one worker at a time owns a task, and no wake is lost, with real threads.
TEST(Scheduler, NeverRunsATaskOnTwoWorkers) {
  const SystemClock clock;
  Scheduler scheduler(4, clock);
  const auto task = std::make_shared<ExclusiveTask>();
  std::vector<std::thread> wakers;
  for (int i = 0; i < 4; ++i) {
    wakers.emplace_back([&] {
      for (int k = 0; k < 1000; ++k) scheduler.Wake(task);
    });
  }
  for (std::thread& waker : wakers) waker.join();
  const int before = task->slice_count;
  scheduler.Wake(task);
  while (task->slice_count <= before) std::this_thread::yield();
  scheduler.Stop();
  EXPECT_FALSE(task->overlapped);
}

TEST(Scheduler, ForgetsWhatIsQueuedWhenItStops) {
  ManualClock clock;
  Scheduler scheduler(0, clock);
  const auto task = std::make_shared<BusyTask>(&clock, Clock::Duration(1));
  scheduler.Wake(task);
  scheduler.Stop();
  scheduler.Wake(task);
  EXPECT_FALSE(scheduler.RunOne());
  EXPECT_EQ(task->slice_count, 0);
}

}  // namespace
}  // namespace pliant::server
