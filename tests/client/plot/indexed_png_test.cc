#include "client/plot/indexed_png.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <vector>

#include "tests/client/plot/support.h"

namespace pliant::plot {
namespace {

/// A picture of `shades` greys, one after the other.
std::vector<unsigned char> Greys(int width, int height, int shades) {
  std::vector<unsigned char> bytes(static_cast<std::size_t>(4 * width * height));
  for (std::size_t i = 0; i < bytes.size() / 4; ++i) {
    const auto grey = static_cast<int>(i) % shades * 255 / (shades - 1);
    for (std::size_t k = 0; k < 3; ++k) bytes[4 * i + k] = static_cast<unsigned char>(grey);
  }
  return bytes;
}

// Goal: a reader of PNG files that is not ours sees the pixels, to the rounding that we promise.
TEST(IndexedPng, IsReadByCairo) {
  const io::TemporaryFolder folder;
  constexpr int kWidth = 61;
  constexpr int kHeight = 33;
  const std::vector<unsigned char> bytes = Greys(kWidth, kHeight, 256);
  const std::optional<std::string> png = FormatIndexedPng(
      {.bytes = bytes, .row_bytes = 4 * kWidth, .width = kWidth, .height = kHeight});
  ASSERT_TRUE(png.has_value());
  std::ofstream(folder.File("a.png"), std::ios::binary) << *png;
  const Picture picture = Decode(folder.File("a.png"));
  ASSERT_EQ(picture.width, kWidth);
  ASSERT_EQ(picture.height, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const int wanted = bytes[static_cast<std::size_t>(4 * (y * kWidth + x))];
      ASSERT_NEAR(picture.at(x, y), wanted, 7) << x << " " << y;
      if (wanted == 0 || wanted == 255) {
        ASSERT_EQ(picture.at(x, y), wanted);
      }
    }
  }
}

TEST(IndexedPng, LeavesPicturesOfManyColorsToOthers) {
  std::vector<unsigned char> bytes(std::size_t{4} * 257);
  for (std::size_t i = 0; i < 257; ++i) {
    bytes[4 * i] = static_cast<unsigned char>(16 * (i % 16));
    bytes[4 * i + 1] = static_cast<unsigned char>(16 * (i / 16 % 16));
    bytes[4 * i + 2] = static_cast<unsigned char>(16 * (i / 256));
  }
  const Pixels all{.bytes = bytes, .row_bytes = 4 * 257, .width = 257, .height = 1};
  EXPECT_FALSE(FormatIndexedPng(all).has_value());
  Pixels fewer = all;
  fewer.width = 256;
  EXPECT_TRUE(FormatIndexedPng(fewer).has_value());
}

}  // namespace
}  // namespace pliant::plot
