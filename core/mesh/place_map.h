#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/ids.h"

namespace pliant {

/// Where a vertex stands in a list, for a few vertices of a large mesh: a hash table with open
/// addressing, several times as fast as std::unordered_map, that only grows. Once it has a good
/// share of the mesh's vertices it becomes a plain array over the slots, faster again.
///
/// Nothing iterates over it, so that the order in its memory reaches no mesh.
class PlaceMap {
 public:
  static constexpr std::int32_t kNone = -1;

  PlaceMap() = default;
  /// @param slot_count  Mesh::vertex_slots() of a mesh whose slots stay as many.
  explicit PlaceMap(std::int32_t slot_count) : slot_count_(static_cast<std::size_t>(slot_count)) {}

  /// Makes room for `count` vertices.
  void Reserve(std::size_t count) {
    if (!by_slot_.empty() || 2 * count <= table_.size()) return;
    if (kDenseShare * count >= slot_count_ && slot_count_ > 0) {
      by_slot_.assign(slot_count_, kNone);
      for (const Entry& entry : table_) {
        if (entry.slot >= 0) by_slot_[static_cast<std::size_t>(entry.slot)] = entry.place;
      }
      table_.clear();
      return;
    }
    std::vector<Entry> old(std::bit_ceil(2 * count + 16));
    std::swap(old, table_);
    for (const Entry& entry : old) {
      if (entry.slot >= 0) *Find(entry.slot) = entry;
    }
  }

  /// Sets the place of a vertex that has none yet. @return false, and nothing, if it has one
  bool Add(VertexId vertex, std::int32_t place) {
    Reserve(count_ + 1);
    if (!by_slot_.empty()) {
      std::int32_t& known = by_slot_[vertex.index()];
      if (known != kNone) return false;
      known = place;
      return true;
    }
    Entry* const entry = Find(vertex.value());
    if (entry->slot >= 0) return false;
    *entry = {vertex.value(), place};
    ++count_;
    return true;
  }

  /// The place of a vertex, or kNone.
  [[nodiscard]] std::int32_t At(VertexId vertex) const {
    if (!by_slot_.empty()) return by_slot_[vertex.index()];
    if (table_.empty()) return kNone;
    std::size_t at = Home(vertex.value());
    while (table_[at].slot >= 0 && table_[at].slot != vertex.value()) {
      at = (at + 1) & (table_.size() - 1);
    }
    return table_[at].place;
  }

 private:
  struct Entry {
    std::int32_t slot = -1;
    std::int32_t place = kNone;
  };

  [[nodiscard]] std::size_t Home(std::int32_t slot) const {
    // Multiplication by a number without structure spreads neighbouring slots.
    const auto mixed = static_cast<std::uint64_t>(slot) * 0x9e3779b97f4a7c15U;
    return static_cast<std::size_t>(mixed >> 32) & (table_.size() - 1);
  }
  [[nodiscard]] Entry* Find(std::int32_t slot) {
    std::size_t at = Home(slot);
    while (table_[at].slot >= 0 && table_[at].slot != slot) at = (at + 1) & (table_.size() - 1);
    return &table_[at];
  }

  /// With one vertex in so many, the array takes no more memory than the table.
  static constexpr std::size_t kDenseShare = 16;

  std::size_t slot_count_ = 0;  // 0: never an array.
  std::vector<std::int32_t> by_slot_;
  std::vector<Entry> table_;
  std::size_t count_ = 0;
};

}  // namespace pliant
