#pragma once

#include <cstddef>
#include <cstdint>

namespace pliant {

/// A number that is known not to be negative, as an index of an array. @pre i >= 0
[[nodiscard]] constexpr std::size_t AsIndex(std::int32_t i) { return static_cast<std::size_t>(i); }

}  // namespace pliant
