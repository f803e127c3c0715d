#include "core/threads/thread_pool.h"

namespace pliant {

ThreadPool::ThreadPool(int thread_count) {
  for (int i = 1; i < thread_count; ++i) threads_.emplace_back([this] { Serve(); });
}

ThreadPool::~ThreadPool() {
  {
    const std::scoped_lock lock(mutex_);
    ends_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void ThreadPool::Run(std::int32_t count, const Task& task) {
  Job job;
  job.task = &task;
  job.count = count;
  const bool wants_threads = !threads_.empty() && count > 1;
  const std::unique_lock run(run_mutex_, std::try_to_lock);
  if (wants_threads && run.owns_lock()) {
    RunTogether(job);
  } else {
    Work(job);
  }
  if (job.failure) std::rethrow_exception(job.failure);
}

void ThreadPool::RunTogether(Job& job) {
  {
    const std::scoped_lock lock(mutex_);
    job_ = &job;
    ++call_;
  }
  wake_.notify_all();
  Work(job);
  std::unique_lock lock(mutex_);
  job_ = nullptr;  // Threads that have not woken by now need not come.
  idle_.wait(lock, [this] { return busy_count_ == 0; });
}

void ThreadPool::Work(Job& job) {
  for (;;) {
    const std::int32_t index = job.next.fetch_add(1, std::memory_order_relaxed);
    if (index >= job.count) return;
    try {
      (*job.task)(index);
    } catch (...) {
      const std::scoped_lock lock(mutex_);
      if (!job.failure || index < job.failed_index) {
        job.failure = std::current_exception();
        job.failed_index = index;
      }
    }
  }
}

void ThreadPool::Serve() {
  std::uint64_t served = 0;
  std::unique_lock lock(mutex_);
  for (;;) {
    wake_.wait(lock, [&] { return ends_ || (job_ != nullptr && call_ != served); });
    if (ends_) return;
    served = call_;
    Job& job = *job_;
    ++busy_count_;
    lock.unlock();
    Work(job);
    lock.lock();
    if (--busy_count_ == 0) idle_.notify_all();
  }
}

}  // namespace pliant
