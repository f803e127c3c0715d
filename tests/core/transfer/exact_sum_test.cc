#include "core/transfer/exact_sum.h"

#include <gtest/gtest.h>

namespace pliant {
namespace {

TEST(ExactSum, SeesWhatCancellationLeaves) {
  ExactSum sum;
  sum.Add(1e8 + 1, 1e8 - 1);  // 1e16 - 1, which no double holds.
  sum.Add(-1e8, 1e8);
  EXPECT_EQ(sum.value(), -1);
}

TEST(ExactSum, KeepsSmallTermsBesideLargeOnes) {
  ExactSum sum;
  sum.Add(1, 1);
  for (int i = 0; i < 1000; ++i) sum.Add(0x1p-60, 1);
  sum.Add(-1, 1);
  EXPECT_EQ(sum.value(), 1000 * 0x1p-60);
}

}  // namespace
}  // namespace pliant
