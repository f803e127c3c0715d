#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <vector>

namespace pliant {

/// Hands out slot numbers, lowest first, so that the arrays of a long session stay dense.
///
/// A slot that a committed revision shows to the outside is not used again before the next commit:
/// within one diff an id means one element. A slot that was taken and freed within the same
/// revision was never seen by anyone and is free at once. Which slot comes next depends only on the
/// set of free slots, not on the order in which they became free.
///
/// *Invariants*: every slot below size() is live, free or parked, and only one of them.
class SlotAllocator {
 public:
  /// The lowest free slot, or a new one at the end.
  std::int32_t Take() {
    ++live_count_;
    if (free_.empty()) return size_++;
    std::pop_heap(free_.begin(), free_.end(), std::greater<>());
    const std::int32_t slot = free_.back();
    free_.pop_back();
    return slot;
  }

  /// Frees a slot that no commit has shown: it may be taken again at once.
  void Free(std::int32_t slot) {
    --live_count_;
    PushFree(slot);
  }

  /// Frees a slot that the last commit showed: it may be taken again after the next commit.
  void Park(std::int32_t slot) {
    --live_count_;
    parked_.push_back(slot);
  }

  /// At a commit: parked slots become free. @par Cost O(p log n) for p parked slots
  void ReleaseParked() {
    for (const std::int32_t slot : parked_) PushFree(slot);
    parked_.clear();
  }

  /// At a rollback: parked slots live again and slots from `size` on never existed. The caller has
  /// freed every slot that was taken since the commit.
  void Rollback(std::int32_t size) {
    live_count_ += static_cast<std::int32_t>(parked_.size());
    parked_.clear();
    size_ = size;
    std::erase_if(free_, [size](std::int32_t slot) { return slot >= size; });
    std::make_heap(free_.begin(), free_.end(), std::greater<>());
  }

  /// Starts over with `count` live slots 0..count-1.
  void Reset(std::int32_t count) {
    size_ = count;
    live_count_ = count;
    free_.clear();
    parked_.clear();
  }

  /// One past the highest slot ever handed out.
  [[nodiscard]] std::int32_t size() const { return size_; }
  [[nodiscard]] std::int32_t live_count() const { return live_count_; }

 private:
  void PushFree(std::int32_t slot) {
    free_.push_back(slot);
    std::push_heap(free_.begin(), free_.end(), std::greater<>());
  }

  std::int32_t size_ = 0;
  std::int32_t live_count_ = 0;
  std::vector<std::int32_t> free_;  // A min-heap.
  std::vector<std::int32_t> parked_;
};

}  // namespace pliant
