#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "core/base/executor.h"
#include "core/base/large_pages.h"

namespace pliant {

/// Reserves room for `count` elements in an empty vector, and writes to every page of it, on all
/// threads there are: otherwise the one thread that fills the vector first waits for the system to
/// clear each page, which takes longer than the filling. Large pages are asked for: they are
/// cleared faster than as many small ones.
template <class Vector>
void ReserveTouched(Vector& vector, std::size_t count, Executor& executor) {
  constexpr std::size_t kPageSize = 4096;
  constexpr std::size_t kPartSize = std::size_t{1} << 21;
  vector.reserve(count);
  const std::size_t size = count * sizeof(typename Vector::value_type);
  if (!vector.empty() || size < 2 * kPartSize) return;
  internal::AskForLargePages(vector.data(), size);
  auto* const block = reinterpret_cast<volatile unsigned char*>(vector.data());
  const auto part_count = static_cast<std::int32_t>((size + kPartSize - 1) / kPartSize);
  executor.Run(part_count, [&](std::int32_t part) {
    const std::size_t begin = static_cast<std::size_t>(part) * kPartSize;
    const std::size_t end = std::min(size, begin + kPartSize);
    for (std::size_t at = begin; at < end; at += kPageSize) block[at] = 0;
  });
}

}  // namespace pliant
