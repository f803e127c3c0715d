#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pliant {

/// A map from slots to indices, for some of many slots: what an array over all slots would be, at
/// the price of the few that are named. Its order is never seen, so that it decides nothing.
///
/// *Invariants*: at most half full. *Threads*: one writer or any number of readers.
class SlotMap {
 public:
  /// @param count  how many slots are expected; more are fine.
  explicit SlotMap(std::size_t count = 0) { entries_.resize(std::bit_ceil(2 * count + 16)); }

  /// The index of a slot; -1 for none.
  [[nodiscard]] std::int32_t Find(std::int32_t slot) const {
    for (std::size_t at = Home(slot);; at = (at + 1) & (entries_.size() - 1)) {
      if (entries_[at].slot == slot) return entries_[at].index;
      if (entries_[at].slot < 0) return -1;
    }
  }

  /// Gives a slot that has none the index `count so far`. @return the slot's index
  std::int32_t Add(std::int32_t slot) {
    if (2 * (static_cast<std::size_t>(count_) + 1) > entries_.size()) Grow();
    std::size_t at = Home(slot);
    while (entries_[at].slot >= 0 && entries_[at].slot != slot) {
      at = (at + 1) & (entries_.size() - 1);
    }
    if (entries_[at].slot < 0) entries_[at] = {slot, count_++};
    return entries_[at].index;
  }

  [[nodiscard]] std::int32_t count() const { return count_; }

 private:
  struct Entry {
    std::int32_t slot = -1;
    std::int32_t index = -1;
  };

  /// Fibonacci hashing: neighbouring slots, which are asked for together, land far apart.
  [[nodiscard]] std::size_t Home(std::int32_t slot) const {
    const std::uint64_t mixed = static_cast<std::uint64_t>(slot) * 0x9e3779b97f4a7c15U;
    return static_cast<std::size_t>(mixed >> 32) & (entries_.size() - 1);
  }

  void Grow() {
    std::vector<Entry> old(2 * entries_.size());
    old.swap(entries_);
    for (const Entry& entry : old) {
      if (entry.slot < 0) continue;
      std::size_t at = Home(entry.slot);
      while (entries_[at].slot >= 0) at = (at + 1) & (entries_.size() - 1);
      entries_[at] = entry;
    }
  }

  std::vector<Entry> entries_;
  std::int32_t count_ = 0;
};

}  // namespace pliant
