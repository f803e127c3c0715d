#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "core/base/result.h"

namespace pliant {

using Bytes = std::vector<std::byte>;

namespace internal {

/// Turns a number into its little-endian form and back.
template <class T>
[[nodiscard]] T LittleEndian(T value) {
  if constexpr (std::endian::native == std::endian::big) {
    std::array<std::byte, sizeof(T)> raw;
    std::memcpy(raw.data(), &value, sizeof(T));
    std::reverse(raw.begin(), raw.end());
    std::memcpy(&value, raw.data(), sizeof(T));
  }
  return value;
}

}  // namespace internal

/// Appends numbers to bytes, little-endian, without padding.
class ByteWriter {
 public:
  template <class T>
  void Put(T value) {
    static_assert(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>);
    const T little = internal::LittleEndian(value);
    const std::size_t at = bytes_.size();
    bytes_.resize(at + sizeof(T));
    std::memcpy(bytes_.data() + at, &little, sizeof(T));
  }

  /// A count (64 bits) and the values.
  template <class T>
  void PutColumn(std::span<const T> values) {
    Put(static_cast<std::uint64_t>(values.size()));
    if constexpr (std::endian::native == std::endian::little) {
      const std::span<const std::byte> raw = std::as_bytes(values);
      bytes_.insert(bytes_.end(), raw.begin(), raw.end());
    } else {
      for (const T value : values) Put(value);
    }
  }
  template <class T>
  void PutColumn(const std::vector<T>& values) {
    PutColumn(std::span<const T>(values));
  }

  void PutText(std::string_view text) {
    PutColumn(std::span<const char>(text.data(), text.size()));
  }

  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  [[nodiscard]] Bytes Take() && { return std::move(bytes_); }

 private:
  Bytes bytes_;
};

/// Reads what a ByteWriter wrote. Never reads past the end: the first value that is not there, and
/// every one after it, is zero or empty, and ok() says so.
class ByteReader {
 public:
  explicit ByteReader(std::span<const std::byte> bytes) : rest_(bytes) {}

  template <class T>
  [[nodiscard]] T Take() {
    static_assert(std::is_arithmetic_v<T> && !std::is_same_v<T, bool>);
    T value{};
    if (!Has(sizeof(T))) return value;
    std::memcpy(&value, rest_.data(), sizeof(T));
    rest_ = rest_.subspan(sizeof(T));
    return internal::LittleEndian(value);
  }

  /// The values of a column, however many; no more than are there are allocated.
  template <class T>
  [[nodiscard]] std::vector<T> TakeColumn() {
    const auto count = Take<std::uint64_t>();
    if (!ok_ || count > rest_.size() / sizeof(T)) {
      Fail();
      return {};
    }
    std::vector<T> values(static_cast<std::size_t>(count));
    if (count == 0) return values;
    std::memcpy(values.data(), rest_.data(), values.size() * sizeof(T));
    rest_ = rest_.subspan(values.size() * sizeof(T));
    if constexpr (std::endian::native == std::endian::big) {
      for (T& value : values) value = internal::LittleEndian(value);
    }
    return values;
  }

  [[nodiscard]] std::string TakeText() {
    const std::vector<char> text = TakeColumn<char>();
    return std::string(text.begin(), text.end());
  }

  /// For values that are there and cannot be: everything from here on fails.
  void Fail() {
    ok_ = false;
    rest_ = {};
  }

  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] std::size_t size_left() const { return rest_.size(); }
  /// True if everything was read and nothing failed.
  [[nodiscard]] bool AtEnd() const { return ok_ && rest_.empty(); }

 private:
  bool Has(std::size_t size) {
    if (ok_ && rest_.size() >= size) return true;
    Fail();
    return false;
  }

  std::span<const std::byte> rest_;
  bool ok_ = true;
};

/// A 64-bit checksum. Any change within one aligned 8 bytes, any change of the length and all but
/// one in 2^64 of other changes show. Not a defence against someone who means harm.
/// @par Cost about 0.2 ns a byte.
[[nodiscard]] std::uint64_t Checksum(std::span<const std::byte> bytes);

/// What kind of bytes these are, and how they are laid out.
struct Seal {
  std::uint32_t kind = 0;     ///< Four letters.
  std::uint32_t version = 0;  ///< From 1; what a program writes is the highest it can read.
};

/// Puts kind, version, length and checksum before a payload.
[[nodiscard]] Bytes SealBytes(const Seal& seal, std::span<const std::byte> payload);

/// The payload of sealed bytes, inside them.
/// @param name  what the bytes are to be, for messages and as `field`.
/// Errors: kDataCorrupt (another kind, cut off, checksum), kDataVersion (written by a newer
/// program).
[[nodiscard]] Result<std::span<const std::byte>> OpenSeal(std::span<const std::byte> bytes,
                                                          const Seal& seal,
                                                          const std::string& name);

/// Bytes whose checksum is right and whose contents cannot be: kDataCorrupt.
[[nodiscard]] Error CorruptData(const std::string& name, const std::string& what);

}  // namespace pliant
