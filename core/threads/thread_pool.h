#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "core/base/executor.h"

namespace pliant {

/// An executor with threads of its own, which sleep between calls.
///
/// The one file of core that knows threads, in a library of its own: the core computes, and server,
/// command line and benchmarks, which all need this, may include core but not each other.
///
/// *Invariants*: no task runs outside a call of Run.
/// *Threads*: Run from any number of threads. One call at a time has the pool's threads; a call
/// that finds them busy does its tasks alone, so that no session waits for another's work.
class ThreadPool final : public Executor {
 public:
  /// @param thread_count  threads that work on a call, the calling one included; 1 makes no thread.
  explicit ThreadPool(int thread_count);
  ~ThreadPool() override;
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  /// The threads that work on a call.
  [[nodiscard]] int thread_count() const { return static_cast<int>(threads_.size()) + 1; }

  /// Tasks are handed out by ascending index. @par Cost of an empty call: some 10 us
  void Run(std::int32_t count, const Task& task) override;

 private:
  /// One call of Run.
  struct Job {
    const Task* task = nullptr;
    std::int32_t count = 0;
    std::atomic<std::int32_t> next = 0;
    // Guarded by mutex_:
    std::int32_t failed_index = 0;
    std::exception_ptr failure;
  };

  void RunTogether(Job& job);
  void Work(Job& job);
  void Serve();

  std::mutex run_mutex_;  // Held while a call of Run has the threads; taken before mutex_.
  std::mutex mutex_;      // Guards what follows.
  std::condition_variable wake_;
  std::condition_variable idle_;
  Job* job_ = nullptr;      // What is to be done; null between calls.
  std::uint64_t call_ = 0;  // Counts calls, so that a thread joins each once.
  int busy_count_ = 0;      // Threads, the caller apart, that look at *job_.
  bool ends_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace pliant
