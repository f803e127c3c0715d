#include "client/plot/indexed_png.h"

#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

namespace pliant::plot {
namespace {

/// The picture by numbers of colours, each row after the byte that says it has no filter.
struct Indexed {
  std::string palette;  ///< Red, green, blue of each colour.
  std::string rows;
};

/// The picture with `bits` of each channel; nothing if it has too many colours even so.
std::optional<Indexed> ToIndexed(const Pixels& pixels, unsigned bits) {
  constexpr std::size_t kColorsMax = 256;
  Indexed indexed;
  std::vector<std::int16_t> numbers(std::size_t{1} << 3 * bits, -1);
  const unsigned shift = 8 - bits;
  // The steps of a channel spread over its 256 values, so that white stays white.
  const auto spread = [bits](unsigned step) {
    return static_cast<char>(step * 255 / ((1U << bits) - 1));
  };
  std::size_t count = 0;
  const auto width = static_cast<std::size_t>(pixels.width);
  const auto height = static_cast<std::size_t>(pixels.height);
  indexed.rows.reserve(height * (width + 1));
  for (std::size_t y = 0; y < height; ++y) {
    indexed.rows.push_back(0);
    const unsigned char* p = &pixels.bytes[y * static_cast<std::size_t>(pixels.row_bytes)];
    for (std::size_t x = 0; x < width; ++x, p += 4) {
      const unsigned r = p[2] >> shift;
      const unsigned g = p[1] >> shift;
      const unsigned b = p[0] >> shift;
      std::int16_t& number = numbers[r << 2 * bits | g << bits | b];
      if (number < 0) {
        if (count == kColorsMax) return std::nullopt;
        number = static_cast<std::int16_t>(count++);
        indexed.palette += {spread(r), spread(g), spread(b)};
      }
      indexed.rows.push_back(static_cast<char>(number));
    }
  }
  return indexed;
}

void AppendNumber(std::uint32_t number, std::string& bytes) {
  for (const unsigned shift : {24U, 16U, 8U, 0U}) {
    bytes.push_back(static_cast<char>(number >> shift & 0xFFU));
  }
}

void AppendChunk(std::string_view type, std::string_view data, std::string& png) {
  AppendNumber(static_cast<std::uint32_t>(data.size()), png);
  const std::size_t begin = png.size();
  png += type;
  png += data;
  const auto* checked = reinterpret_cast<const Bytef*>(png.data() + begin);
  AppendNumber(static_cast<std::uint32_t>(crc32_z(0, checked, png.size() - begin)), png);
}

std::string Compress(const std::string& data) {
  uLongf size = compressBound(static_cast<uLong>(data.size()));
  std::string compressed(size, '\0');
  compress2(reinterpret_cast<Bytef*>(compressed.data()), &size,
            reinterpret_cast<const Bytef*>(data.data()), static_cast<uLong>(data.size()),
            Z_BEST_COMPRESSION);
  compressed.resize(size);
  return compressed;
}

}  // namespace

std::optional<std::string> FormatIndexedPng(const Pixels& pixels) {
  std::optional<Indexed> indexed = ToIndexed(pixels, 5);
  if (!indexed) indexed = ToIndexed(pixels, 4);
  if (!indexed) return std::nullopt;
  std::string header;
  AppendNumber(static_cast<std::uint32_t>(pixels.width), header);
  AppendNumber(static_cast<std::uint32_t>(pixels.height), header);
  // 8 bits per pixel, a palette, and the only kinds of compression, filter and order of rows.
  header += {8, 3, 0, 0, 0};
  std::string png = "\x89PNG\r\n\x1a\n";
  AppendChunk("IHDR", header, png);
  AppendChunk("PLTE", indexed->palette, png);
  AppendChunk("IDAT", Compress(indexed->rows), png);
  AppendChunk("IEND", "", png);
  return png;
}

}  // namespace pliant::plot
