#include "server/scheduler.h"

#include <algorithm>
#include <utility>

#include "server/limits.h"

namespace pliant::server {

Scheduler::Scheduler(int worker_count, const Clock& clock)
    : clock_(clock), worker_count_(static_cast<std::size_t>(worker_count)) {
  if (worker_count_ == 0) return;
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < worker_count_; ++i) workers_.emplace_back([this] { Work(); });
  watcher_ = std::thread([this] { Watch(); });
}

Scheduler::~Scheduler() { Stop(); }

void Scheduler::Wake(const std::shared_ptr<Task>& task) {
  const std::lock_guard lock(mutex_);
  if (stopping_) return;
  switch (task->state_) {
    case Task::State::kIdle:
      task->state_ = Task::State::kQueued;
      queue_.push_back(task);
      if (slices_.size() - replaced_count_ < worker_count_) wake_.notify_one();
      CallWatch();
      return;
    case Task::State::kRunning:
      task->state_ = Task::State::kRunningAndWoken;
      return;
    case Task::State::kQueued:
    case Task::State::kRunningAndWoken:
      return;
  }
}

bool Scheduler::RunOne() {
  std::unique_lock lock(mutex_);
  if (queue_.empty()) return false;
  RunFront(lock);
  return true;
}

void Scheduler::Stop() {
  std::thread watcher;
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    queue_.clear();
    watcher = std::move(watcher_);
  }
  wake_.notify_all();
  watch_.notify_all();
  if (watcher.joinable()) watcher.join();
  for (std::thread& worker : workers_) worker.join();  // Nobody makes any more.
  workers_.clear();
}

void Scheduler::Work() {
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [this] {
      return stopping_ || (!queue_.empty() && slices_.size() - replaced_count_ < worker_count_);
    });
    if (stopping_) return;
    RunFront(lock);
  }
}

void Scheduler::RunFront(std::unique_lock<std::mutex>& lock) {
  const std::shared_ptr<Task> task = std::move(queue_.front());
  queue_.pop_front();
  task->state_ = Task::State::kRunning;
  const Task::Outcome outcome = RunUnlocked(lock, *task, clock_.Now());
  const bool again =
      outcome == Task::Outcome::kMore || task->state_ == Task::State::kRunningAndWoken;
  if (!again || stopping_) {
    task->state_ = Task::State::kIdle;
    return;
  }
  // Nobody is woken for it: the worker that has run it takes the front of the queue next, or those
  // do that have its place. A task that is alone so stays on its thread and in that thread's cache.
  task->state_ = Task::State::kQueued;
  queue_.push_back(task);
}

Task::Outcome Scheduler::RunUnlocked(std::unique_lock<std::mutex>& lock, Task& task,
                                     Clock::Time begin) {
  Slice slice{begin};
  slices_.push_back(&slice);
  CallWatch();
  lock.unlock();
  const Task::Outcome outcome = task.RunSlice(begin + std::chrono::milliseconds(kSliceMs));
  lock.lock();
  std::erase(slices_, &slice);
  if (slice.replaced) --replaced_count_;
  CallWatch();
  return outcome;
}

/// Only while somebody waits and nobody is free; else there is nothing to watch for, and a server
/// that keeps up is not woken for it.
bool Scheduler::MayHandOff() const {
  return !queue_.empty() && slices_.size() - replaced_count_ >= worker_count_ &&
         replaced_count_ < kSpareWorkersMax;
}

void Scheduler::CallWatch() {
  if (watch_sleeps_ && MayHandOff()) watch_.notify_one();
}

/// Hands the places of overdue slices to other threads.
void Scheduler::Watch() {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    if (!MayHandOff()) {
      watch_sleeps_ = true;
      watch_.wait(lock);
      watch_sleeps_ = false;
      continue;
    }
    Slice* oldest = nullptr;
    for (Slice* slice : slices_) {
      if (!slice->replaced && (oldest == nullptr || slice->begin < oldest->begin)) oldest = slice;
    }
    const Clock::Time due = oldest->begin + std::chrono::milliseconds(kHandOffMs);
    const Clock::Time now = clock_.Now();
    if (now < due) {
      watch_.wait_for(lock, due - now);
    } else {
      HandOff(*oldest);
    }
  }
}

void Scheduler::HandOff(Slice& slice) {
  slice.replaced = true;
  ++replaced_count_;
  if (workers_.size() < worker_count_ + replaced_count_) {
    workers_.emplace_back([this] { Work(); });
  } else {
    wake_.notify_one();
  }
}

}  // namespace pliant::server
