#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>

#include "core/base/stop_signal.h"

namespace pliant {

/// Sorts like std::sort, in pieces that take a millisecond or two.
///
/// @param stop  not owned; null: nobody; else asked between pieces. Once it has said yes the range
///              is in no useful order.
/// @pre less is a total order of different elements, so that pieces do not show in the result.
/// @par Cost O(n log n)
template <class Iterator, class Less = std::less<>>
void SortUnlessStopped(Iterator first, Iterator last, const StopSignal* stop, Less less = {}) {
  constexpr std::ptrdiff_t kPiece = std::ptrdiff_t{1} << 14;
  const std::ptrdiff_t count = std::distance(first, last);
  const auto asked = [&] { return count > kPiece && stop != nullptr && stop->asked(); };
  const auto at = [&](std::ptrdiff_t place) { return first + std::min(place, count); };
  for (std::ptrdiff_t begin = 0; begin < count && !asked(); begin += kPiece) {
    std::sort(at(begin), at(begin + kPiece), less);
  }
  for (std::ptrdiff_t size = kPiece; size < count; size *= 2) {
    for (std::ptrdiff_t begin = 0; begin + size < count; begin += 2 * size) {
      if (asked()) return;
      std::inplace_merge(at(begin), at(begin + size), at(begin + 2 * size), less);
    }
  }
}

}  // namespace pliant
