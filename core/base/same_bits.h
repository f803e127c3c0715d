#pragma once

#include <bit>
#include <cstdint>

namespace pliant {

/// Equality that tells -0 from 0, and finds a NaN equal to itself.
[[nodiscard]] constexpr bool SameBits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

}  // namespace pliant
