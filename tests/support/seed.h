#pragma once

#include <cstdint>
#include <cstdlib>

namespace pliant::test {

/// The first seed of a random test: PLIANT_SEED, or 0.
inline std::uint64_t FirstSeed() {
  const char* seed = std::getenv("PLIANT_SEED");
  return seed != nullptr ? std::strtoull(seed, nullptr, 10) : 0;
}

}  // namespace pliant::test
