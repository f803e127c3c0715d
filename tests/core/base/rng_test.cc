#include "core/base/rng.h"

#include <gtest/gtest.h>

namespace pliant {
namespace {

// Goal: the generator is the published one, so that a seed means the same mesh for ever.
// Method: the first outputs of xoshiro256** after splitmix64(0), computed by another program.
TEST(Rng, IsXoshiro256StarStarSeededBySplitMix) {
  Rng rng(0);
  EXPECT_EQ(rng.Next(), 0x99ec5f36cb75f2b4U);
  EXPECT_EQ(rng.Next(), 0xbf6e1f784956452aU);
  EXPECT_EQ(rng.Next(), 0x1a5f849d4933e6e0U);
  EXPECT_EQ(rng.Next(), 0x6aa594f1262d2d2cU);
}

TEST(Rng, BelowStaysBelowAndReachesEveryValue) {
  Rng rng(1996);
  int seen[7] = {};
  for (int i = 0; i < 7000; ++i) {
    const std::uint64_t draw = rng.Below(7);
    ASSERT_LT(draw, 7U);
    ++seen[draw];
  }
  for (int count : seen) EXPECT_NEAR(count, 1000, 150);
}

}  // namespace
}  // namespace pliant
