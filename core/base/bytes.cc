#include "core/base/bytes.h"

#include <array>

namespace pliant {
namespace {

constexpr std::size_t kHeaderBytes = 24;
constexpr std::uint64_t kMultiplier = 0x9e3779b97f4a7c15;  // Odd, so that a product loses nothing.

/// A bijection of the word for every lane, and of the lane for every word.
std::uint64_t MixWord(std::uint64_t lane, std::uint64_t word) {
  lane = (lane ^ word) * kMultiplier;
  return lane ^ (lane >> 29);
}

std::uint64_t WordAt(std::span<const std::byte> bytes, std::size_t at) {
  std::uint64_t word = 0;
  std::memcpy(&word, bytes.data() + at, std::min<std::size_t>(8, bytes.size() - at));
  return internal::LittleEndian(word);
}

}  // namespace

std::uint64_t Checksum(std::span<const std::byte> bytes) {
  // Four lanes, because a multiplication takes several cycles but one can begin in each.
  std::array<std::uint64_t, 4> lanes{1, 2, 3, 4};
  std::size_t at = 0;
  for (; at + 32 <= bytes.size(); at += 32) {
    for (std::size_t lane = 0; lane < 4; ++lane) {
      lanes[lane] = MixWord(lanes[lane], WordAt(bytes, at + 8 * lane));
    }
  }
  for (std::size_t lane = 0; at < bytes.size(); at += 8, ++lane) {
    lanes[lane] = MixWord(lanes[lane], WordAt(bytes, at));
  }
  std::uint64_t sum = MixWord(0, bytes.size());
  for (const std::uint64_t lane : lanes) sum = MixWord(sum, lane);
  return MixWord(sum, 0);
}

Bytes SealBytes(const Seal& seal, std::span<const std::byte> payload) {
  ByteWriter header;
  header.Put(seal.kind);
  header.Put(seal.version);
  header.Put(static_cast<std::uint64_t>(payload.size()));
  header.Put(Checksum(payload));
  Bytes sealed = std::move(header).Take();
  sealed.insert(sealed.end(), payload.begin(), payload.end());
  return sealed;
}

Result<std::span<const std::byte>> OpenSeal(std::span<const std::byte> bytes, const Seal& seal,
                                            const std::string& name) {
  ByteReader header(bytes);
  const auto kind = header.Take<std::uint32_t>();
  const auto version = header.Take<std::uint32_t>();
  const auto size = header.Take<std::uint64_t>();
  const auto checksum = header.Take<std::uint64_t>();
  if (!header.ok() || kind != seal.kind) {
    return CorruptData(name, "does not begin as one; it is something else or its begin is lost");
  }
  if (version == 0 || version > seal.version) {
    return Error{ErrorCode::kDataVersion,
                 "the " + name + " has format " + std::to_string(version) +
                     "; this program reads formats up to " + std::to_string(seal.version) +
                     ": read it with the program that wrote it or a newer one",
                 name};
  }
  const std::span<const std::byte> payload = bytes.subspan(kHeaderBytes);
  if (payload.size() != size) {
    return CorruptData(
        name, "has " + std::to_string(payload.size()) + " of " + std::to_string(size) + " bytes");
  }
  if (Checksum(payload) != checksum) return CorruptData(name, "does not have its checksum");
  return payload;
}

Error CorruptData(const std::string& name, const std::string& what) {
  return {ErrorCode::kDataCorrupt, "the " + name + " is damaged: it " + what, name};
}

}  // namespace pliant
