#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "server/clock.h"

namespace pliant::server {

/// Something that computes in slices: a session.
class Task {
 public:
  enum class Outcome {
    kIdle,  ///< Nothing to do until the next Wake.
    kMore,  ///< Wants another slice.
  };
  virtual ~Task() = default;

  /// Works until about `slice_end`. Called by one worker at a time. Must not throw.
  virtual Outcome RunSlice(Clock::Time slice_end) = 0;

 private:
  friend class Scheduler;
  enum class State { kIdle, kQueued, kRunning, kRunningAndWoken };
  State state_ = State::kIdle;  // Guarded by the scheduler's mutex.
};

/// Gives tasks time slices on a pool of workers, each in its turn: whoever wakes up or used
/// up a slice goes to the end of one queue. So with b busy tasks and w workers a task that wakes
/// waits for at most ceil(b / w) slices, however much the busy ones have left to do.
///
/// Of the workers that have nothing to do the one that was busy last runs the next slice: its core
/// still holds the task that it ran, and most often it is that one's turn again.
///
/// A slice that does not end, because its task is in work that cannot be cut, keeps nobody waiting
/// for longer than kHandOffMs: then another thread takes the worker's place in the queue until it
/// is back, and the operating system shares the cores among them.
///
/// *Invariants*: a task is in the queue at most once, and run by at most one worker; a Wake during
/// a slice leads to another one. At most worker_count slices run that are not overdue, and at most
/// kSpareWorkersMax that are.
/// *Threads*: all functions from any thread; `mutex_` is a leaf lock: no task runs under it.
class Scheduler {
 public:
  /// @param worker_count  0: no worker; tests run slices themselves with RunOne.
  /// @param clock         not owned.
  Scheduler(int worker_count, const Clock& clock);
  /// As Stop.
  ~Scheduler();
  Scheduler(const Scheduler&) = delete;
  Scheduler& operator=(const Scheduler&) = delete;

  /// Makes sure that the task gets a slice that starts after this call. Nothing after Stop.
  void Wake(const std::shared_ptr<Task>& task);

  /// Runs one slice of the first task in the queue on this thread; false if the queue is empty.
  bool RunOne();

  /// Lets running slices end, drops the queue and joins the workers.
  void Stop();

 private:
  // A slice that runs; lives on its worker's stack.
  struct Slice {
    Clock::Time begin;
    bool replaced = false;  // Another thread has the worker's place.
  };

  // A thread and what wakes it while it has nothing to do.
  struct Worker {
    std::condition_variable wake;
    bool called = false;
    std::thread thread;
  };

  void AddWorker();
  void Work(Worker& self);
  [[nodiscard]] bool MayRun() const {
    return !queue_.empty() && slices_.size() - replaced_count_ < worker_count_;
  }
  [[nodiscard]] Worker* CallWorker();
  // Both are called with the lock, and let go of it while the task runs.
  void RunFront(std::unique_lock<std::mutex>& lock);
  Task::Outcome RunUnlocked(std::unique_lock<std::mutex>& lock, Task& task, Clock::Time begin);
  void Watch();
  [[nodiscard]] bool MayHandOff() const;
  void HandOff(Slice& slice);
  void CallWatch();

  const Clock& clock_;
  const std::size_t worker_count_;
  std::mutex mutex_;  // Guards all that follows and every Task::state_.
  std::condition_variable watch_;
  std::deque<std::shared_ptr<Task>> queue_;
  std::vector<Slice*> slices_;
  std::size_t replaced_count_ = 0;  // Of `slices_`; the others hold a worker's place.
  bool watch_sleeps_ = false;
  bool stopping_ = false;
  std::vector<std::unique_ptr<Worker>> workers_;  // The spare ones too, made when one is needed.
  std::vector<Worker*> idle_;                     // Those that wait; the last one came last.
  std::thread watcher_;
};

}  // namespace pliant::server
