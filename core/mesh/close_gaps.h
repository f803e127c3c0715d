#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "core/base/executor.h"

namespace pliant {

/// How many of `count` slots are live before each chunk of them; the last entry is the total.
/// @param is_live  called for every slot, perhaps at the same time.
template <class Function>
std::vector<std::size_t> LiveBefore(std::int64_t count, Function&& is_live, Executor& executor) {
  const Chunks chunks(count);
  std::vector<std::size_t> before(static_cast<std::size_t>(chunks.count()) + 1, 0);
  executor.Run(chunks.count(), [&](std::int32_t chunk) {
    std::size_t live_count = 0;
    for (std::int64_t i = chunks.begin(chunk); i < chunks.end(chunk); ++i) {
      live_count += is_live(static_cast<std::size_t>(i)) ? 1 : 0;
    }
    before[static_cast<std::size_t>(chunk) + 1] = live_count;
  });
  std::partial_sum(before.begin(), before.end(), before.begin());
  return before;
}

/// New slot numbers of the live records, in order; -1 for the dead.
template <class Records>
std::vector<std::int32_t> DenseNumbers(const Records& records, Executor& executor) {
  const std::vector<std::size_t> before = LiveBefore(
      std::ssize(records), [&](std::size_t i) { return records[i].live; }, executor);
  const Chunks chunks(std::ssize(records));
  std::vector<std::int32_t> numbers(records.size());
  executor.Run(chunks.count(), [&](std::int32_t chunk) {
    auto number = static_cast<std::int32_t>(before[static_cast<std::size_t>(chunk)]);
    for (std::int64_t i = chunks.begin(chunk); i < chunks.end(chunk); ++i) {
      const auto slot = static_cast<std::size_t>(i);
      numbers[slot] = records[slot].live ? number++ : -1;
    }
  });
  return numbers;
}

/// Moves each record to its new number, which DenseNumbers made, and drops the others, in place.
template <class Records>
void CloseGaps(Records& records, const std::vector<std::int32_t>& numbers, Executor& executor) {
  const Chunks chunks(std::ssize(records));
  struct Head {
    std::size_t to = 0;
    std::vector<typename Records::value_type> records;
  };
  std::vector<Head> heads(static_cast<std::size_t>(chunks.count()));
  // What leaves its chunk waits until the chunks before have moved what they keep.
  executor.Run(chunks.count(), [&](std::int32_t chunk) {
    Head& head = heads[static_cast<std::size_t>(chunk)];
    const std::int64_t begin = chunks.begin(chunk);
    for (std::int64_t i = begin; i < chunks.end(chunk); ++i) {
      const auto slot = static_cast<std::size_t>(i);
      if (numbers[slot] < 0 || numbers[slot] == i) continue;
      const auto number = static_cast<std::size_t>(numbers[slot]);
      if (numbers[slot] >= begin) {
        records[number] = records[slot];
        continue;
      }
      if (head.records.empty()) head.to = number;
      head.records.push_back(records[slot]);
    }
  });
  executor.Run(chunks.count(), [&](std::int32_t chunk) {
    const Head& head = heads[static_cast<std::size_t>(chunk)];
    std::copy(head.records.begin(), head.records.end(),
              records.begin() + static_cast<std::ptrdiff_t>(head.to));
  });
  records.resize(numbers.size() -
                 static_cast<std::size_t>(std::count(numbers.begin(), numbers.end(), -1)));
}

}  // namespace pliant
