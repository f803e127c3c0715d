#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>

namespace pliant {

/// Runs independent tasks, perhaps several at a time. The core has no threads of its own: whoever
/// has some lends them as an executor (core/threads has one).
///
/// What the tasks of one call do must not depend on the order in which they run; then a result is
/// the same with any executor.
class Executor {
 public:
  using Task = std::function<void(std::int32_t index)>;

  virtual ~Executor() = default;

  /// Calls task(0) to task(count - 1), each once, in any order and on any threads, and returns when
  /// all have ended. What the tasks wrote is then visible to the caller. If tasks throw, the
  /// exception of the one with the lowest index is thrown again at the end; whether tasks of higher
  /// index still ran is open. @pre not called from a task
  virtual void Run(std::int32_t count, const Task& task) = 0;

  /// True if tasks were skipped because somebody wanted the work to end (StoppableExecutor): what
  /// they were to make is not there.
  [[nodiscard]] virtual bool stopped() const { return false; }
};

/// One task after the other, on the calling thread: the executor of those who have no threads.
class InlineExecutor final : public Executor {
 public:
  void Run(std::int32_t count, const Task& task) override {
    for (std::int32_t index = 0; index < count; ++index) task(index);
  }
};

/// A range of items cut into chunks of a fixed length, so that what is computed by chunk is the
/// same for any number of threads.
class Chunks {
 public:
  /// Long enough that handing out a chunk costs nothing, short enough to keep threads evenly busy.
  static constexpr std::int64_t kLength = 16384;

  explicit Chunks(std::int64_t item_count) : item_count_(item_count) {}

  [[nodiscard]] std::int32_t count() const {
    return static_cast<std::int32_t>((item_count_ + kLength - 1) / kLength);
  }
  [[nodiscard]] std::int64_t begin(std::int32_t chunk) const { return chunk * kLength; }
  [[nodiscard]] std::int64_t end(std::int32_t chunk) const {
    return std::min(item_count_, begin(chunk) + kLength);
  }

  /// Calls function(item) for every item; items of one chunk in order.
  template <class Function>
  void ForEach(Executor& executor, Function&& function) const {
    executor.Run(count(), [&](std::int32_t chunk) {
      for (std::int64_t item = begin(chunk); item < end(chunk); ++item) {
        function(static_cast<std::int32_t>(item));
      }
    });
  }

 private:
  std::int64_t item_count_;
};

}  // namespace pliant
