#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/bytes.h"
#include "core/base/result.h"

namespace pliant::server {

/// How bytes lie in the store. Numbers are part of its format.
enum class PackForm : std::int32_t { kRaw = 0, kZstd = 1 };

/// Bytes as they are stored.
struct Packed {
  PackForm form = PackForm::kRaw;
  std::size_t size = 0;        ///< Of the bytes that were packed.
  std::uint64_t checksum = 0;  ///< Of everything here, and of where it stands.
  Bytes bytes = {};
};

/// Compresses where that saves at least an eighth, and adds a checksum.
/// @param place  where it will stand (document, number): a row that was stored in another's place
///               does not pass for it.
/// @par Cost about 2 ns a byte.
[[nodiscard]] Packed Pack(std::span<const std::byte> bytes, std::uint64_t place);

/// The bytes again. Error: kDataCorrupt.
[[nodiscard]] Result<Bytes> Unpack(const Packed& packed, std::uint64_t place);

}  // namespace pliant::server
