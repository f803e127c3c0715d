#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/rng.h"
#include "tests/support/pieces.h"

namespace pliant::fuzz {

/// The body of LLVMFuzzerCustomMutator for inputs that are pieces: bytes alone would hardly ever be
/// a message.
/// @param fresh  where to begin anew, from time to time and with fewer than `least` pieces
inline std::size_t MutatePieces(std::uint8_t* data, std::size_t size, std::size_t size_max,
                                unsigned int seed, std::size_t least,
                                const std::function<std::vector<test::Piece>(Rng&)>& fresh) {
  Rng rng(seed);
  std::vector<test::Piece> pieces = test::Cut({reinterpret_cast<const char*>(data), size});
  if (pieces.size() < least || rng.Below(16) == 0) pieces = fresh(rng);
  const std::string bytes = test::Join(test::Mutated(std::move(pieces), rng));
  const std::size_t count = std::min(bytes.size(), size_max);
  std::memcpy(data, bytes.data(), count);
  return count;
}

}  // namespace pliant::fuzz
