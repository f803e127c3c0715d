#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

#include "core/base/check.h"

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
    PLIANT_CHECK(!free_.empty() || size_ != kNoGrowth);
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

  /// Gives `count` slots, the lowest free ones and then new ones, to an allocator of their own, for
  /// a writer that works beside others. It counts only what it takes and frees itself, and does not
  /// grow. ReturnFrom and EndLoans take everything back. @par Cost O(free slots), O(f log f) after
  /// other calls
  [[nodiscard]] SlotAllocator Lend(std::int32_t count) {
    SlotAllocator lent;
    lent.size_ = kNoGrowth;
    if (!std::is_sorted(free_.begin(), free_.end())) std::sort(free_.begin(), free_.end());
    const auto reused = std::min(static_cast<std::ptrdiff_t>(count), std::ssize(free_));
    lent.free_.reserve(static_cast<std::size_t>(count));
    lent.free_.assign(free_.begin(), free_.begin() + reused);  // What is sorted is a heap.
    free_.erase(free_.begin(), free_.begin() + reused);
    while (std::ssize(lent.free_) < count) lent.free_.push_back(size_++);
    return lent;
  }

  /// Counts what `lent` has taken and freed since it was last asked, here instead of there.
  void CountFrom(SlotAllocator& lent) { live_count_ += std::exchange(lent.live_count_, 0); }

  /// Ends a loan: the free slots of `lent`, those of elements it freed included, come back. After
  /// the last loan, EndLoans must follow before anything is taken.
  void ReturnFrom(SlotAllocator&& lent) {
    CountFrom(lent);
    free_.insert(free_.end(), lent.free_.begin(), lent.free_.end());
    lent.free_.clear();
  }
  void EndLoans() { std::make_heap(free_.begin(), free_.end(), std::greater<>()); }

  /// Slots that can be taken without growth.
  [[nodiscard]] std::size_t free_count() const { return free_.size(); }

  /// Takes these free slots. @param slots  ascending @par Cost O(free slots) if there is any
  void TakeThese(std::span<const std::int32_t> slots) {
    if (slots.empty()) return;
    live_count_ += static_cast<std::int32_t>(slots.size());
    std::erase_if(free_, [slots](std::int32_t slot) {
      return std::binary_search(slots.begin(), slots.end(), slot);
    });
    std::make_heap(free_.begin(), free_.end(), std::greater<>());
  }

  /// More slots, which are free, or fewer. @pre nothing is parked; slots from `size` on are free
  /// @par Cost that of the slots that come, or O(free slots)
  void Resize(std::int32_t size) {
    if (size < size_) Rollback(size);
    while (size_ < size) PushFree(size_++);
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
  /// As size_: the slots are lent, there are no more than those.
  static constexpr std::int32_t kNoGrowth = -1;

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
