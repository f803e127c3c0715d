#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace pliant {

/// Rows for some of the slots of a mesh, found by slot: what a vector by slot would be, if most
/// slots had no row. In order of insertion, so that a loop over them does not depend on hashing.
template <class Row>
class SlotRows {
 public:
  using Entry = std::pair<std::int32_t, Row>;

  /// The row of a slot, or null. Valid until the next insertion. @par Cost O(1)
  [[nodiscard]] Row* Find(std::int32_t slot) {
    if (entries_.empty()) return nullptr;
    for (std::size_t at = Home(slot);; at = (at + 1) & (table_.size() - 1)) {
      if (table_[at] < 0) return nullptr;
      Entry& entry = entries_[static_cast<std::size_t>(table_[at])];
      if (entry.first == slot) return &entry.second;
    }
  }

  /// Gives a slot a row. @pre it has none
  Row& Insert(std::int32_t slot, const Row& row) {
    if (2 * (entries_.size() + 1) > table_.size()) {
      Rehash(table_.empty() ? kLeastSize : 2 * table_.size());
    }
    entries_.emplace_back(slot, row);
    Place(entries_.size() - 1);
    return entries_.back().second;
  }

  /// Makes room for so many rows at once.
  void Reserve(std::size_t count) {
    entries_.reserve(count);
    if (2 * count > table_.size()) Rehash(std::max(kLeastSize, std::bit_ceil(2 * count)));
  }

  /// Forgets all rows.
  void Clear() {
    entries_.clear();
    table_.clear();
  }

  [[nodiscard]] const std::vector<Entry>& entries() const { return entries_; }

 private:
  static constexpr std::size_t kLeastSize = 64;

  /// The upper bits of a product with 2^64 over the golden ratio: neighbouring slots spread evenly.
  /// [Knuth1998, sec. 6.4]
  [[nodiscard]] std::size_t Home(std::int32_t slot) const {
    const auto product = static_cast<std::uint64_t>(slot) * 0x9E3779B97F4A7C15U;
    return static_cast<std::size_t>(product >> (64 - std::bit_width(table_.size() - 1)));
  }
  void Place(std::size_t index) {
    std::size_t at = Home(entries_[index].first);
    while (table_[at] >= 0) at = (at + 1) & (table_.size() - 1);
    table_[at] = static_cast<std::int32_t>(index);
  }
  void Rehash(std::size_t size) {
    table_.assign(size, -1);
    for (std::size_t i = 0; i < entries_.size(); ++i) Place(i);
  }

  std::vector<Entry> entries_;
  std::vector<std::int32_t> table_;  ///< Indices into entries_, or -1; a power of two, half empty.
};

}  // namespace pliant
