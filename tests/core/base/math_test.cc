#include "core/base/math.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/base/rng.h"

namespace pliant {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kSubnormalMin = std::numeric_limits<double>::denorm_min();

/// The distance of `value` from the long double `exact`, in units of the last place of `exact`
/// rounded to double.
double UlpError(double value, long double exact) {
  const double rounded = static_cast<double>(exact);
  const double next = std::nextafter(std::abs(rounded), kInfinity);
  const double ulp = next - std::abs(rounded);
  return static_cast<double>(std::abs(static_cast<long double>(value) - exact) / ulp);
}

std::uint64_t AddToHash(std::uint64_t hash, double value) {
  return (hash ^ std::bit_cast<std::uint64_t>(value)) * 0x100000001b3U;
}

// Goal: the documented error bounds. Method: the C library's long double functions, which have 11
// more bits, at random arguments over the whole range and close to the places where things change.
TEST(Exp, IsWithinOneUlpOverTheWholeRange) {
  Rng rng(1996);
  double worst = 0;
  for (int i = 0; i < 300'000; ++i) {
    const double range = i % 3 == 0 ? 0.4 : i % 3 == 1 ? 20 : 745;
    const double x = std::min(rng.Uniform(-range, range), 709.78);
    const double error = UlpError(Exp(x), std::exp(static_cast<long double>(x)));
    ASSERT_LT(error, 1) << "x=" << x;
    worst = std::max(worst, error);
  }
  EXPECT_GT(worst, 0.5);  // Rounding alone reaches a half: less means that nothing was measured.
}

TEST(Exp, HandlesTheEndsOfTheRange) {
  EXPECT_EQ(Exp(0), 1);
  EXPECT_EQ(Exp(-0.0), 1);
  EXPECT_EQ(Exp(1e-300), 1);
  EXPECT_TRUE(std::isfinite(Exp(709.7827128933839)));
  EXPECT_EQ(Exp(709.782712893384), kInfinity);
  EXPECT_EQ(Exp(kInfinity), kInfinity);
  EXPECT_EQ(Exp(-745.1332191019411), kSubnormalMin);
  EXPECT_EQ(Exp(-745.1332191019413), 0);
  EXPECT_EQ(Exp(-kInfinity), 0);
  EXPECT_TRUE(std::isnan(Exp(std::numeric_limits<double>::quiet_NaN())));
}

TEST(Log, IsWithinOneUlpForEveryPositiveNumber) {
  Rng rng(1996);
  for (int i = 0; i < 300'000; ++i) {
    double x = rng.Uniform(0.5, 2);
    if (i % 3 == 1) x = 1 + (x - 1) * 1e-6;
    if (i % 3 == 2) x = std::bit_cast<double>(rng.Next() >> 1);  // Any exponent, subnormals too.
    if (!(x > 0 && x < kInfinity)) continue;
    ASSERT_LT(UlpError(Log(x), std::log(static_cast<long double>(x))), 1) << "x=" << x;
  }
  for (double x = kSubnormalMin; x < 1e-300; x *= 3) {
    ASSERT_LT(UlpError(Log(x), std::log(static_cast<long double>(x))), 1) << "x=" << x;
  }
}

TEST(Log, HandlesTheEndsOfTheRange) {
  EXPECT_EQ(Log(1), 0);
  EXPECT_EQ(Log(0), -kInfinity);
  EXPECT_EQ(Log(-0.0), -kInfinity);
  EXPECT_EQ(Log(kInfinity), kInfinity);
  EXPECT_TRUE(std::isnan(Log(-1)));
  EXPECT_TRUE(std::isnan(Log(-kInfinity)));
  EXPECT_TRUE(std::isnan(Log(std::numeric_limits<double>::quiet_NaN())));
}

TEST(ExpNegative, HasThePromisedRelativeError) {
  Rng rng(1996);
  EXPECT_EQ(ExpNegative(0), 1);
  for (int i = 0; i < 300'000; ++i) {
    const double x = i == 0 ? -256 : -rng.Uniform(0, i % 2 == 0 ? 1 : 256);
    const long double exact = std::exp(static_cast<long double>(x));
    ASSERT_LT(std::abs(ExpNegative(x) / exact - 1), 1e-13L) << "x=" << x;
  }
}

// Goal: a compiler, an option or a CPU that changes one bit of one result shows at once.
// Method: a hash over 10^6 results. The numbers were recorded with g++ 12 -O3; clang++ 14, -O0 and
// CPUs with and without FMA must give them as well.
TEST(Math, HasTheSameBitsEverywhere) {
  Rng rng(1996);
  std::uint64_t exp_hash = 0;
  std::uint64_t log_hash = 0;
  std::uint64_t exp_negative_hash = 0;
  for (int i = 0; i < 1'000'000; ++i) {
    exp_hash = AddToHash(exp_hash, Exp(rng.Uniform(-746, 710)));
    log_hash = AddToHash(log_hash, Log(std::bit_cast<double>(rng.Next() >> 2)));
    exp_negative_hash = AddToHash(exp_negative_hash, ExpNegative(-rng.Uniform(0, 256)));
  }
  EXPECT_EQ(exp_hash, 15577943804536637457U);
  EXPECT_EQ(log_hash, 10466373602072524450U);
  EXPECT_EQ(exp_negative_hash, 6188634853840915945U);
}

}  // namespace
}  // namespace pliant
