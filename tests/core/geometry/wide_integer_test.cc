#include "core/geometry/wide_integer.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/base/rng.h"

namespace pliant::internal {
namespace {

WideInteger Of(double value) { return WideInteger::FromDouble(value); }

TEST(WideInteger, KnowsTheSignOfEveryDouble) {
  EXPECT_EQ(Of(0.0).Sign(), 0);
  EXPECT_EQ(Of(-0.0).Sign(), 0);
  EXPECT_EQ(Of(std::numeric_limits<double>::denorm_min()).Sign(), 1);
  EXPECT_EQ(Of(-std::numeric_limits<double>::denorm_min()).Sign(), -1);
  EXPECT_EQ(Of(-std::numeric_limits<double>::max()).Sign(), -1);
}

// Goal: sums and products are those of the integers.
// Method: whole numbers below 2^26, whose sums and products a double holds exactly.
TEST(WideInteger, AddsAndMultipliesAsSmallWholeNumbersDo) {
  Rng rng(26);
  for (int trial = 0; trial < 10000; ++trial) {
    const double a = static_cast<double>(rng.Below(1 << 26)) - (1 << 25);
    const double b = static_cast<double>(rng.Below(1 << 26)) - (1 << 25);
    SCOPED_TRACE(::testing::Message() << "seed 26, a=" << a << " b=" << b);
    ASSERT_EQ((Of(a) + Of(b) - Of(a + b)).Sign(), 0);
    ASSERT_EQ((Of(a) * Of(b) - Of(a * b) * Of(1)).Sign(), 0);
    ASSERT_EQ((Of(a) - Of(b)).Sign(), a < b ? -1 : a > b ? 1 : 0);
  }
}

TEST(WideInteger, CarriesAcrossTheWholeRange) {
  const double huge = std::numeric_limits<double>::max();
  const double tiny = std::numeric_limits<double>::denorm_min();
  EXPECT_EQ((Of(huge) + Of(tiny) - Of(huge) - Of(tiny)).Sign(), 0);
  EXPECT_EQ((Of(huge) - Of(tiny) - Of(huge)).Sign(), -1);
  EXPECT_EQ((Of(huge) * Of(huge) - Of(huge) * Of(huge) + Of(tiny) * Of(tiny)).Sign(), 1);
}

}  // namespace
}  // namespace pliant::internal
