#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/rng.h"

/// Strings of bytes that stand for sequences of messages, for fuzzers and for the tests that replay
/// a corpus with random mutations.
namespace pliant::test {

/// A message and a number that chooses what is done with it.
struct Piece {
  std::uint8_t choice = 0;
  std::string bytes;
};

/// Three bytes before each piece: its choice and its length. Whatever the bytes are, they are cut.
inline std::vector<Piece> Cut(std::string_view bytes) {
  std::vector<Piece> pieces;
  while (bytes.size() >= 3) {
    const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(bytes[i]); };
    const std::size_t length = std::min<std::size_t>(byte(1) + 256U * byte(2), bytes.size() - 3);
    pieces.push_back({byte(0), std::string(bytes.substr(3, length))});
    bytes.remove_prefix(3 + length);
  }
  return pieces;
}

inline std::string Join(const std::vector<Piece>& pieces) {
  std::string bytes;
  for (const Piece& piece : pieces) {
    const std::size_t length = std::min<std::size_t>(piece.bytes.size(), 0xffff);
    bytes += static_cast<char>(piece.choice);
    bytes += static_cast<char>(length & 0xff);
    bytes += static_cast<char>(length >> 8);
    bytes += piece.bytes.substr(0, length);
  }
  return bytes;
}

/// A seed for a fuzzer: a file of that name in the folder PLIANT_WRITE_CORPUS, if that is set.
inline void WriteSeed(const std::string& name, const std::vector<Piece>& pieces) {
  const char* folder = std::getenv("PLIANT_WRITE_CORPUS");
  if (folder == nullptr) return;
  std::ofstream(std::string(folder) + "/" + name, std::ios::binary) << Join(pieces);
}

/// Bits flipped, bytes replaced, cut, doubled, and a part of another string spliced in.
inline std::string Mutated(std::string bytes, const std::string& other, Rng& rng) {
  for (std::uint64_t count = 1 + rng.Below(2); count > 0; --count) {
    if (bytes.empty()) return other;
    const auto at = static_cast<std::size_t>(rng.Below(bytes.size()));
    switch (rng.Below(5)) {
      case 0:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << rng.Below(8)));
        break;
      case 1:
        bytes[at] = static_cast<char>(rng.Below(256));
        break;
      case 2:
        bytes.resize(at);
        break;
      case 3:
        bytes.insert(at, bytes.substr(at, 1 + rng.Below(16)));
        break;
      default:
        if (!other.empty()) bytes.insert(at, other.substr(rng.Below(other.size())));
        break;
    }
  }
  return bytes;
}

/// A sequence with some pieces mutated, left out, doubled or moved.
inline std::vector<Piece> Mutated(std::vector<Piece> pieces, Rng& rng) {
  for (std::uint64_t count = 1 + rng.Below(3); count > 0 && !pieces.empty(); --count) {
    const auto at = static_cast<std::size_t>(rng.Below(pieces.size()));
    const auto other = static_cast<std::size_t>(rng.Below(pieces.size()));
    switch (rng.Below(6)) {
      case 0:
        pieces.erase(pieces.begin() + static_cast<std::ptrdiff_t>(at));
        break;
      case 1: {
        const Piece copy = pieces[other];
        pieces.insert(pieces.begin() + static_cast<std::ptrdiff_t>(at), copy);
        break;
      }
      case 2:
        std::swap(pieces[at], pieces[other]);
        break;
      case 3:
        pieces[at].choice = static_cast<std::uint8_t>(rng.Below(256));
        break;
      default: {
        const std::string from = pieces[other].bytes;
        pieces[at].bytes = Mutated(std::move(pieces[at].bytes), from, rng);
        break;
      }
    }
  }
  return pieces;
}

}  // namespace pliant::test
