#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/large_pages.h"
#include "core/base/prefetch.h"

namespace pliant {

/// Slots and what stood in them, in order of insertion.
///
/// Slots and records lie apart: together a record that fills a cache line would take two, and what
/// stood in slots that follow each other goes back as one block. A log that has become large makes
/// room for a whole mesh at once: to move it again and again while it grows takes longer than a
/// cancel may wait, and memory that nobody writes to costs nothing.
///
/// *Threads*: as a standard container.
template <class IdType, class Record>
class RecordLog {
 public:
  struct Entry {
    IdType first;
    const Record& second;
  };

  class Iterator {
   public:
    using iterator_category = std::input_iterator_tag;
    using difference_type = std::ptrdiff_t;
    using value_type = Entry;
    using reference = Entry;
    using pointer = void;

    Iterator(const RecordLog& log, std::size_t at) : log_(&log), at_(at) {}
    Entry operator*() const { return (*log_)[at_]; }
    Iterator& operator++() {
      ++at_;
      return *this;
    }
    Iterator operator++(int) { return {*log_, at_++}; }
    friend bool operator==(const Iterator& a, const Iterator& b) { return a.at_ == b.at_; }

   private:
    const RecordLog* log_;
    std::size_t at_;
  };

  [[nodiscard]] std::size_t size() const { return ids_.size(); }
  [[nodiscard]] bool empty() const { return ids_.empty(); }
  [[nodiscard]] Entry operator[](std::size_t i) const { return {ids_[i], records_[i]}; }
  [[nodiscard]] const std::vector<IdType>& ids() const { return ids_; }
  [[nodiscard]] Iterator begin() const { return {*this, 0}; }
  [[nodiscard]] Iterator end() const { return {*this, size()}; }

  /// @param slots  of the mesh that the records are from
  void Add(IdType id, const Record& record, std::size_t slots) {
    if (records_.size() == records_.capacity()) Grow(slots);
    ids_.push_back(id);
    records_.push_back(record);
  }

  /// Forgets everything but its memory.
  void Clear() {
    ids_.clear();
    records_.clear();
  }

  /// Puts the entries in order of their slots. @pre no slot has two
  /// @par Cost O(n), but O(n log n) if n is a small part of the slots and they are in no order
  void Sort();

  /// Places of the entries in order of their slots. @par Cost as Sort
  [[nodiscard]] std::vector<std::uint32_t> Order() const;

  /// Writes all records back. @param records  by slot, the array that they are from
  /// @param before  called with each entry and what stands there, before that is written
  template <class Records, class Before>
  void WriteTo(Records& records, const Before& before) const;

  /// Takes the arrays out, of equal length; the log is empty then. Room to spare they have only
  /// where it is memory that nobody has written to.
  [[nodiscard]] std::pair<std::vector<IdType>, LargeVector<Record>> Take();

 private:
  static constexpr std::size_t kLarge = internal::kLargeBlockSize / sizeof(Record);
  /// From one in so many slots on, a table by slot is better than sorting.
  static constexpr std::size_t kTableShare = 16;
  static constexpr std::size_t kAhead = 16;
  /// Entries that are looked at and written together, while they are near the processor.
  static constexpr std::size_t kBlock = 512;

  void Grow(std::size_t slots);

  std::vector<IdType> ids_;
  LargeVector<Record> records_;
};

template <class IdType, class Record>
void RecordLog<IdType, Record>::Grow(std::size_t slots) {
  std::size_t room = std::max<std::size_t>(16, 2 * records_.capacity());
  // The mesh may grow by a part of its own meanwhile.
  if (room >= kLarge) room = std::max(room, slots + slots / 4);
  records_.reserve(room);
  ids_.reserve(room);
}

template <class IdType, class Record>
std::vector<std::uint32_t> RecordLog<IdType, Record>::Order() const {
  std::vector<std::uint32_t> order;
  if (empty()) return order;
  order.reserve(size());
  const std::size_t slots = std::ranges::max(ids_).index() + 1;
  if (kTableShare * size() >= slots) {
    constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> place_of(slots, kNone);
    for (std::size_t i = 0; i < size(); ++i) {
      place_of[ids_[i].index()] = static_cast<std::uint32_t>(i);
    }
    std::ranges::copy_if(place_of, std::back_inserter(order),
                         [](std::uint32_t place) { return place != kNone; });
    return order;
  }
  std::vector<std::uint64_t> keys;
  keys.reserve(size());
  for (std::size_t i = 0; i < size(); ++i) {
    keys.push_back(static_cast<std::uint64_t>(ids_[i].index()) << 32 | i);
  }
  std::ranges::sort(keys);
  for (const std::uint64_t key : keys) order.push_back(static_cast<std::uint32_t>(key));
  return order;
}

template <class IdType, class Record>
void RecordLog<IdType, Record>::Sort() {
  if (std::ranges::is_sorted(ids_)) return;
  const std::vector<std::uint32_t> order = Order();
  std::vector<IdType> ids;
  LargeVector<Record> records;
  ids.reserve(size());
  records.reserve(size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i + kAhead < order.size()) PrefetchToRead(&records_[order[i + kAhead]]);
    ids.push_back(ids_[order[i]]);
    records.push_back(records_[order[i]]);
  }
  ids_ = std::move(ids);
  records_ = std::move(records);
}

template <class IdType, class Record>
template <class Records, class Before>
void RecordLog<IdType, Record>::WriteTo(Records& records, const Before& before) const {
  for (std::size_t i = 0; i < size();) {
    const std::size_t first = i;
    do {
      before((*this)[i], std::as_const(records[ids_[i].index()]));
      ++i;
    } while (i < size() && i < first + kBlock && ids_[i].index() == ids_[i - 1].index() + 1);
    std::copy(records_.begin() + static_cast<std::ptrdiff_t>(first),
              records_.begin() + static_cast<std::ptrdiff_t>(i),
              records.begin() + static_cast<std::ptrdiff_t>(ids_[first].index()));
  }
}

template <class IdType, class Record>
std::pair<std::vector<IdType>, LargeVector<Record>> RecordLog<IdType, Record>::Take() {
  if (records_.capacity() < kLarge && records_.capacity() > size() + size() / 8) {
    ids_ = std::vector<IdType>(ids_);
    records_ = LargeVector<Record>(records_);
  }
  return {std::exchange(ids_, {}), std::exchange(records_, {})};
}

}  // namespace pliant
