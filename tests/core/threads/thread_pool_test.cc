#include "core/threads/thread_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace pliant {
namespace {

// Goal: each task runs once and what it wrote is there afterwards, for any numbers of threads and
// tasks, call after call.
TEST(ThreadPool, RunsEachTaskOnce) {
  for (const int thread_count : {1, 2, 3, 8}) {
    ThreadPool pool(thread_count);
    EXPECT_EQ(pool.thread_count(), thread_count);
    for (const std::int32_t count : {0, 1, 2, 7, 100, 1000}) {
      std::vector<int> runs(static_cast<std::size_t>(count), 0);
      pool.Run(count, [&](std::int32_t index) { ++runs[static_cast<std::size_t>(index)]; });
      EXPECT_EQ(runs, std::vector<int>(static_cast<std::size_t>(count), 1));
    }
  }
}

// Goal: tasks do run at the same time. Method: each of two waits for the other, which no executor
// on one thread gets through.
TEST(ThreadPool, RunsTasksAtTheSameTime) {
  ThreadPool pool(2);
  std::atomic<int> arrived = 0;
  pool.Run(2, [&](std::int32_t /*index*/) {
    ++arrived;
    while (arrived < 2) std::this_thread::yield();
  });
  EXPECT_EQ(arrived, 2);
}

// Goal: a failure reaches the caller, the lowest of several; the pool goes on after it.
TEST(ThreadPool, ThrowsTheExceptionOfTheLowestTask) {
  ThreadPool pool(3);
  for (int call = 0; call < 20; ++call) {
    try {
      pool.Run(50, [](std::int32_t index) {
        if (index % 10 == 7) throw std::runtime_error(std::to_string(index));
      });
      FAIL() << "nothing was thrown";
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "7");
    }
  }
  std::atomic<int> sum = 0;
  pool.Run(10, [&](std::int32_t index) { sum += index; });
  EXPECT_EQ(sum, 45);
}

// Goal: callers on several threads are all served, the pool's threads helping one at a time.
TEST(ThreadPool, ServesSeveralCallers) {
  ThreadPool pool(2);
  std::atomic<int> sum = 0;
  std::atomic<int> inside = 0;
  std::vector<std::thread> callers;
  for (int caller = 0; caller < 4; ++caller) {
    callers.emplace_back([&] {
      for (int call = 0; call < 50; ++call) {
        pool.Run(3, [&](std::int32_t index) {
          EXPECT_LE(++inside, 5);  // Four callers and one thread of the pool.
          sum += index;
          --inside;
        });
      }
    });
  }
  for (std::thread& caller : callers) caller.join();
  EXPECT_EQ(sum, 4 * 50 * 3);
}

// Goal: a call that finds the threads busy does not wait for them.
// Method: a second call is made and ends while a task of the first waits for that.
TEST(ThreadPool, DoesNotWaitForAnothersWork) {
  ThreadPool pool(2);
  std::atomic<bool> second_is_done = false;
  std::atomic<bool> first_runs = false;
  std::thread first([&] {
    pool.Run(2, [&](std::int32_t /*index*/) {
      first_runs = true;
      while (!second_is_done) std::this_thread::yield();
    });
  });
  while (!first_runs) std::this_thread::yield();
  int sum = 0;  // Not atomic: the tasks run on this thread.
  pool.Run(10, [&](std::int32_t index) { sum += index; });
  second_is_done = true;
  first.join();
  EXPECT_EQ(sum, 45);
}

}  // namespace
}  // namespace pliant
