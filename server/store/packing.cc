#include "server/store/packing.h"

#include <zstd.h>

#include <utility>

namespace pliant::server {
namespace {

// Below that a frame's own bytes eat what it saves.
constexpr std::size_t kCompressBytesMin = 256;
// Level 1: columns of coordinates hold little that a better search would find.
constexpr int kLevel = 1;
// No row is longer, so a length beyond is not one that was written.
constexpr std::size_t kRowBytesMax = std::size_t{1} << 30;

std::uint64_t Mix(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
  x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
  return x ^ (x >> 31);
}

std::uint64_t ChecksumOf(const Packed& packed, std::uint64_t place) {
  std::uint64_t sum = Mix(place + 0x9e3779b97f4a7c15);
  sum = Mix(sum + static_cast<std::uint64_t>(packed.form) + 1);
  sum = Mix(sum + packed.size);
  return Mix(sum + Checksum(packed.bytes));
}

Error Corrupt(const char* what) {
  return {ErrorCode::kDataCorrupt, std::string("a stored row ") + what, "store"};
}

}  // namespace

Packed Pack(std::span<const std::byte> bytes, std::uint64_t place) {
  Packed packed;
  packed.size = bytes.size();
  if (bytes.size() >= kCompressBytesMin) {
    Bytes small(ZSTD_compressBound(bytes.size()));
    const std::size_t size =
        ZSTD_compress(small.data(), small.size(), bytes.data(), bytes.size(), kLevel);
    if (ZSTD_isError(size) == 0 && size <= bytes.size() - bytes.size() / 8) {
      small.resize(size);
      packed.form = PackForm::kZstd;
      packed.bytes = std::move(small);
    }
  }
  if (packed.form == PackForm::kRaw) packed.bytes.assign(bytes.begin(), bytes.end());
  packed.checksum = ChecksumOf(packed, place);
  return packed;
}

Result<Bytes> Unpack(const Packed& packed, std::uint64_t place) {
  if (packed.checksum != ChecksumOf(packed, place)) return Corrupt("does not fit its checksum");
  if (packed.size > kRowBytesMax) return Corrupt("names an impossible length");
  if (packed.form == PackForm::kRaw) {
    if (packed.size != packed.bytes.size()) return Corrupt("has another length than it names");
    return packed.bytes;
  }
  if (packed.form != PackForm::kZstd) return Corrupt("has an unknown form");
  Bytes bytes(packed.size);
  const std::size_t size =
      ZSTD_decompress(bytes.data(), bytes.size(), packed.bytes.data(), packed.bytes.size());
  if (ZSTD_isError(size) != 0 || size != packed.size) return Corrupt("cannot be decompressed");
  return bytes;
}

}  // namespace pliant::server
