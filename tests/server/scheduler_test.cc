#include "server/scheduler.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <latch>
#include <memory>
#include <thread>
#include <utility>
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

// Is in one stretch until it is let go.
class BlockingTask final : public Task {
 public:
  explicit BlockingTask(std::shared_ptr<std::latch> release) : release_(std::move(release)) {}
  Outcome RunSlice(Clock::Time) override {
    begun.count_down();
    release_->wait();
    return Outcome::kIdle;
  }
  std::latch begun{1};

 private:
  std::shared_ptr<std::latch> release_;  // Shared: who waits outlives who lets go.
};

class CountingTask final : public Task {
 public:
  Outcome RunSlice(Clock::Time) override {
    ++slice_count;
    done.count_down();
    return Outcome::kIdle;
  }
  std::atomic<int> slice_count = 0;
  std::latch done{1};
};

// Goal: no task waits for another's stretch that cannot be cut, also where all workers are in one.
// Method: the stretches end only after the others had their slices, so this ends only if the
// workers were replaced. Twice, for the spare workers of the first time serve again.
TEST(Scheduler, ReplacesWorkersThatDoNotComeBack) {
  const SystemClock clock;
  Scheduler scheduler(2, clock);
  for (int round = 0; round < 2; ++round) {
    const auto release = std::make_shared<std::latch>(1);
    std::vector<std::shared_ptr<BlockingTask>> stretches;
    for (int i = 0; i < 3; ++i) {
      stretches.push_back(std::make_shared<BlockingTask>(release));
      scheduler.Wake(stretches.back());
    }
    const auto small = std::make_shared<CountingTask>();
    scheduler.Wake(small);
    small->done.wait();
    for (const auto& stretch : stretches) stretch->begun.wait();
    release->count_down();
  }
}

// Goal: the number of spare workers is bounded; what is beyond the bound waits and is not lost.
// Method: as many stretches as may run at once, all of which begin, and one more task. It cannot
// have had a slice before one of them has ended, whenever one looks; then it gets one.
TEST(Scheduler, HasNoMoreSparesThanItsBound) {
  const SystemClock clock;
  Scheduler scheduler(1, clock);
  const auto release = std::make_shared<std::latch>(1);
  std::vector<std::shared_ptr<BlockingTask>> stretches;
  for (std::size_t i = 0; i < 1 + kSpareWorkersMax; ++i) {
    stretches.push_back(std::make_shared<BlockingTask>(release));
    scheduler.Wake(stretches.back());
  }
  for (const auto& stretch : stretches) stretch->begun.wait();
  const auto beyond = std::make_shared<CountingTask>();
  scheduler.Wake(beyond);
  const auto until = clock.Now() + milliseconds(3 * kHandOffMs);
  while (clock.Now() < until) std::this_thread::yield();
  EXPECT_EQ(beyond->slice_count, 0);
  release->count_down();
  beyond->done.wait();
}

// Goal: a slice that is merely long takes nobody's place while nobody waits, and no more than
// worker_count slices run that are not overdue.
// Method: tasks that are never overdue, for the clock stands still, on two workers.
TEST(Scheduler, RunsNoMoreSlicesAtOnceThanWorkersWhileNoneIsOverdue) {
  class Crowd final : public Task {
   public:
    Crowd(std::atomic<int>* inside, std::atomic<int>* most) : inside_(inside), most_(most) {}
    Outcome RunSlice(Clock::Time) override {
      const int now = ++*inside_;
      int known = *most_;
      while (known < now && !most_->compare_exchange_weak(known, now)) {
      }
      for (int i = 0; i < 100; ++i) std::this_thread::yield();
      --*inside_;
      done = ++slice_count_ == 50;
      return done ? Outcome::kIdle : Outcome::kMore;
    }
    std::atomic<bool> done = false;

   private:
    std::atomic<int>* inside_;
    std::atomic<int>* most_;
    int slice_count_ = 0;
  };
  const ManualClock clock;
  Scheduler scheduler(2, clock);
  std::atomic<int> inside = 0;
  std::atomic<int> most = 0;
  std::vector<std::shared_ptr<Crowd>> crowd;
  for (int i = 0; i < 8; ++i) {
    crowd.push_back(std::make_shared<Crowd>(&inside, &most));
    scheduler.Wake(crowd.back());
  }
  for (const auto& task : crowd) {
    while (!task->done) std::this_thread::yield();
  }
  EXPECT_LE(most, 2);
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
