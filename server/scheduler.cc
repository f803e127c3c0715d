#include "server/scheduler.h"

#include <algorithm>
#include <utility>

#include "server/limits.h"

namespace pliant::server {

Scheduler::Scheduler(int worker_count, const Clock& clock)
    : clock_(clock), worker_count_(static_cast<std::size_t>(worker_count)) {
  if (worker_count_ == 0) return;
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < worker_count_; ++i) AddWorker();
  watcher_ = std::thread([this] { Watch(); });
}

Scheduler::~Scheduler() { Stop(); }

void Scheduler::Wake(const std::shared_ptr<Task>& task) {
  std::unique_lock lock(mutex_);
  if (stopping_) return;
  switch (task->state_) {
    case Task::State::kIdle:
      task->state_ = Task::State::kQueued;
      queue_.push_back(task);
      CallWatch();
      if (Worker* const worker = CallWorker()) {
        // Without the lock, for which the worker would have to wait at once.
        lock.unlock();
        worker->wake.notify_one();
      }
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
  watch_.notify_all();
  if (watcher.joinable()) watcher.join();
  // Nobody makes any more; they stay, because a Wake may be about to notify one.
  for (const auto& worker : workers_) worker->wake.notify_one();
  for (const auto& worker : workers_) {
    if (worker->thread.joinable()) worker->thread.join();
  }
}

void Scheduler::AddWorker() {
  Worker& worker = *workers_.emplace_back(std::make_unique<Worker>());
  worker.thread = std::thread([this, &worker] { Work(worker); });
}

/// Who is to be woken, if there is a place for another slice: the caller does it.
Scheduler::Worker* Scheduler::CallWorker() {
  if (idle_.empty() || !MayRun()) return nullptr;
  Worker* const worker = idle_.back();
  idle_.pop_back();
  worker->called = true;
  return worker;
}

void Scheduler::Work(Worker& self) {
  std::unique_lock lock(mutex_);
  while (!stopping_) {
    if (MayRun()) {
      RunFront(lock);
      continue;
    }
    self.called = false;
    idle_.push_back(&self);
    self.wake.wait(lock, [&] { return stopping_ || self.called; });
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
    AddWorker();
  } else if (Worker* const worker = CallWorker()) {
    worker->wake.notify_one();
  }
}

}  // namespace pliant::server
