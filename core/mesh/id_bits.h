#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace pliant {

/// A set of ids below a bound, a bit for each: what a sorted list is for few of them, this is for
/// a good part of a mesh.
///
/// *Threads*: as a standard container.
template <class IdType>
class IdBits {
 public:
  /// @par Cost O(slot_count / 64)
  explicit IdBits(std::int32_t slot_count)
      : words_((static_cast<std::size_t>(slot_count) + 63) / 64) {}

  /// @pre 0 <= id < slot_count
  void Add(IdType id) { words_[id.index() / 64] |= std::uint64_t{1} << (id.index() % 64); }

  /// False also for ids that are none.
  [[nodiscard]] bool Has(IdType id) const {
    return id.valid() && id.index() / 64 < words_.size() &&
           ((words_[id.index() / 64] >> (id.index() % 64)) & 1) != 0;
  }

  /// All of them, in order. @par Cost O(slot_count / 64 + ids)
  [[nodiscard]] std::vector<IdType> Ascending() const {
    std::size_t count = 0;
    for (const std::uint64_t word : words_) count += static_cast<std::size_t>(std::popcount(word));
    std::vector<IdType> ids;
    ids.reserve(count);
    for (std::size_t i = 0; i < words_.size(); ++i) {
      for (std::uint64_t rest = words_[i]; rest != 0; rest &= rest - 1) {
        ids.push_back(IdType(static_cast<std::int32_t>(64 * i) + std::countr_zero(rest)));
      }
    }
    return ids;
  }

 private:
  std::vector<std::uint64_t> words_;
};

}  // namespace pliant
