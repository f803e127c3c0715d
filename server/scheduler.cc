#include "server/scheduler.h"

#include <utility>

#include "server/limits.h"

namespace pliant::server {

Scheduler::Scheduler(int worker_count, const Clock& clock) : clock_(clock) {
  workers_.reserve(static_cast<std::size_t>(worker_count));
  for (int i = 0; i < worker_count; ++i) workers_.emplace_back([this] { Work(); });
}

Scheduler::~Scheduler() { Stop(); }

void Scheduler::Wake(const std::shared_ptr<Task>& task) {
  const std::lock_guard lock(mutex_);
  if (stopping_) return;
  switch (task->state_) {
    case Task::State::kIdle:
      task->state_ = Task::State::kQueued;
      queue_.push_back(task);
      wake_.notify_one();
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
  std::shared_ptr<Task> task;
  {
    const std::lock_guard lock(mutex_);
    if (queue_.empty()) return false;
    task = std::move(queue_.front());
    queue_.pop_front();
    task->state_ = Task::State::kRunning;
  }
  RunSliceOf(task);
  wake_.notify_one();  // For what it left in the queue, of which the caller need not take care.
  return true;
}

void Scheduler::Stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    queue_.clear();
  }
  wake_.notify_all();
  for (std::thread& worker : workers_) worker.join();
  workers_.clear();
}

void Scheduler::Work() {
  for (;;) {
    std::shared_ptr<Task> task;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return stopping_ || !queue_.empty(); });
      if (stopping_) return;
      task = std::move(queue_.front());
      queue_.pop_front();
      task->state_ = Task::State::kRunning;
    }
    RunSliceOf(task);
  }
}

void Scheduler::RunSliceOf(const std::shared_ptr<Task>& task) {
  const Task::Outcome outcome = task->RunSlice(clock_.Now() + std::chrono::milliseconds(kSliceMs));
  const std::lock_guard lock(mutex_);
  const bool again =
      outcome == Task::Outcome::kMore || task->state_ == Task::State::kRunningAndWoken;
  if (!again || stopping_) {
    task->state_ = Task::State::kIdle;
    return;
  }
  // Nobody is woken for it: the worker that has run it takes the front of the queue next. A task
  // that is alone so stays on its thread and in that thread's cache.
  task->state_ = Task::State::kQueued;
  queue_.push_back(task);
}

}  // namespace pliant::server
