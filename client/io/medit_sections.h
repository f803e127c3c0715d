#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "client/io/number_reader.h"

namespace pliant::io {

/// Walks the sections of a Medit file (.mesh, .sol), or of its binary form (.meshb, .solb,
/// versions 1 to 4, either byte order; which one it is shows in the first four bytes).
///
/// The keywords and the binary layout are those of [Marechal2017, libMeshb]: a keyword, in binary
/// files its number followed by the position of the next keyword, then a count and the elements.
class MeditSections {
 public:
  explicit MeditSections(std::string_view bytes);

  /// Goes to the next section and returns its keyword, whatever was read of the last one; empty at
  /// the end or after a failure. "?" stands for a keyword that this class does not know.
  std::string_view Next();
  /// The count at the start of a section, checked against what is left of the file.
  [[nodiscard]] std::size_t Count(std::size_t numbers_per_element);

  [[nodiscard]] NumberReader& reader() { return reader_; }
  /// 2 or 3; 0 until the file has said so.
  [[nodiscard]] std::int64_t dimension() const { return dimension_; }
  /// Bytes per number: at least 2 in text (a digit and a blank), at least 4 in binary.
  [[nodiscard]] std::size_t number_size_min() const { return binary_ ? 4 : 2; }

 private:
  void ReadBinaryHeader();
  std::string_view NextText();
  std::string_view NextBinary();
  void ReadDimension();

  NumberReader reader_;
  bool binary_ = false;
  bool wide_positions_ = false;  ///< Positions in the file have 8 bytes, from version 3 on.
  bool wide_integers_ = false;   ///< Integers have 8 bytes, from version 4 on.
  std::size_t next_position_ = 0;
  std::int64_t dimension_ = 0;
};

}  // namespace pliant::io
