#pragma once

#include <optional>
#include <span>
#include <string>

namespace pliant::plot {

/// Pixels in rows from the top, each four bytes blue, green, red and one that is not used.
struct Pixels {
  std::span<const unsigned char> bytes;
  int row_bytes = 0;  ///< From one row to the next.
  int width = 0;
  int height = 0;
};

/// The picture as a PNG file with a palette, colours rounded to 32 steps per channel, or to 16 if
/// more than 256 colours remain; nothing if even those are more. Line drawings, which are one ink
/// and its shades, have few; as a palette they take a third to a fifth of the bytes of 24 bits per
/// pixel. [PNG specification]
/// @pre bytes.size() >= height * row_bytes, row_bytes >= 4 * width, width and height >= 1
[[nodiscard]] std::optional<std::string> FormatIndexedPng(const Pixels& pixels);

}  // namespace pliant::plot
