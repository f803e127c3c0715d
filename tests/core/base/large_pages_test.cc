#include "core/base/large_pages.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <numeric>
#include <vector>

namespace pliant {
namespace {

struct alignas(64) Line {
  std::int64_t value = 0;
};

// Goal: a vector keeps its elements when it grows from ordinary blocks into large ones and back,
// and every block is aligned as its elements, or its pages, ask for.
TEST(LargePages, VectorsGrowAcrossTheLimit) {
  constexpr std::size_t kLarge = 2 * internal::kLargeBlockSize / sizeof(Line);
  LargeVector<Line> lines;
  for (std::size_t i = 0; i < kLarge; ++i) {
    lines.push_back({static_cast<std::int64_t>(i)});
    if ((i & (i - 1)) != 0) continue;
    ASSERT_EQ(reinterpret_cast<std::uintptr_t>(lines.data()) % alignof(Line), 0U);
  }
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(lines.data()) % (std::size_t{1} << 21), 0U);
  for (std::size_t i = 0; i < kLarge; ++i) {
    ASSERT_EQ(lines[i].value, static_cast<std::int64_t>(i));
  }
  lines.resize(10);
  lines.shrink_to_fit();
  EXPECT_EQ(lines[9].value, 9);
}

// Goal: asking changes nothing of what is in a block, nor around it, wherever it begins and ends.
TEST(LargePages, AreAskedForInsideBlocksOfOthers) {
  constexpr std::size_t kPage = std::size_t{1} << 21;
  std::vector<unsigned char> bytes(5 * kPage, 7);
  for (const std::size_t first : {std::size_t{0}, std::size_t{1}, kPage - 1, kPage}) {
    for (const std::size_t size : {std::size_t{0}, std::size_t{1}, kPage, 4 * kPage - 3}) {
      internal::AskForLargePages(bytes.data() + first, size);
    }
  }
  EXPECT_EQ(bytes, std::vector<unsigned char>(5 * kPage, 7));
}

}  // namespace
}  // namespace pliant
