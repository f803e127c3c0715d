#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace pliant::io {

/// Reads the numbers and words of a mesh file, text or binary, from memory.
///
/// The first failure stays: the reader jumps to the end, everything read after it is 0 or empty,
/// and status() tells what and where. So a parser reads a whole section and checks once.
///
/// *Invariants*: never reads outside the bytes; every count that Count() returns is backed by that
/// many elements' worth of bytes, so memory is bounded by a small multiple of the file's size.
/// *Threads*: one at a time. The bytes must outlive the reader.
class NumberReader {
 public:
  enum class Encoding { kText, kBinary, kBinarySwapped };

  explicit NumberReader(std::string_view bytes) : bytes_(bytes) {}

  void set_encoding(Encoding encoding) { encoding_ = encoding; }
  /// Bytes of an Integer() in binary files, 4 or 8.
  void set_integer_size(std::size_t size) { integer_size_ = size; }
  /// Bytes of a Real() in binary files, 4 or 8.
  void set_real_size(std::size_t size) { real_size_ = size; }

  [[nodiscard]] bool ok() const { return !error_.has_value(); }
  [[nodiscard]] Status status() const { return ok() ? Status() : Status(*error_); }
  [[nodiscard]] std::string_view bytes() const { return bytes_; }
  [[nodiscard]] std::size_t position() const { return position_; }
  [[nodiscard]] std::size_t remaining() const { return bytes_.size() - position_; }

  /// Goes to a byte offset, forwards or backwards. Fails if it lies past the end.
  void Seek(std::size_t position);
  /// Goes on `count` bytes. Fails if they are not there.
  void Skip(std::size_t count);
  /// Goes to just after the next occurrence of `text`. Fails if there is none.
  void SkipPast(std::string_view text);
  /// Goes to the start of the next line.
  void SkipLine();
  /// Text: skips blanks and comments; true if nothing but the line's or the file's end follows.
  [[nodiscard]] bool AtLineEnd();
  /// Text: skips blanks, lines and comments; true if nothing follows.
  [[nodiscard]] bool AtEnd();

  /// The next word in a text file (up to a blank), empty at the end of the file.
  std::string_view Word();
  /// The rest of the line in a text file without the blanks around it.
  std::string_view Line();
  /// Fails unless the next word is `expected`.
  void Expect(std::string_view expected);

  std::int64_t Integer();
  /// An integer that is 8 bytes long in binary files, whatever integer_size says.
  std::int64_t Long();
  /// An integer that is 4 bytes long in binary files, whatever integer_size says.
  std::int64_t Short();
  /// A finite number; anything else fails with kNotFinite or kOutOfRange.
  double Real();
  /// An Integer() that fits a tag.
  std::int32_t Tag();
  /// A text number with an integral value that fits a tag ("3" or "3.0").
  std::int32_t TagFromReal();
  /// An Integer() less `base`, kept in 32 bits; range checks follow when all points are known.
  std::int32_t Index(std::int64_t base);
  /// Checks a count from a header: not negative, at most 2^31-1 (kTooLarge), and at least
  /// `element_size_min` bytes left for each (kFileSyntax). Returns 0 on failure.
  std::size_t Count(std::int64_t count, std::size_t element_size_min);

  /// Records a failure at the present position unless there is one already.
  void Fail(ErrorCode code, const std::string& message);
  void FailSyntax(const std::string& message) { Fail(ErrorCode::kFileSyntax, message); }

 private:
  void SkipBlanks();
  [[nodiscard]] std::string Found();
  template <class T>
  T Raw();
  std::int64_t TextInteger();
  double TextReal();

  std::string_view bytes_;
  std::size_t position_ = 0;
  Encoding encoding_ = Encoding::kText;
  std::size_t integer_size_ = 4;
  std::size_t real_size_ = 8;
  std::optional<Error> error_;
};

}  // namespace pliant::io
