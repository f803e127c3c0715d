#include "core/geometry/segments.h"

#include <gmpxx.h>
#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace pliant {
namespace {

TEST(IsInsideSegment, ExcludesTheEndsAndTheRestOfTheLine) {
  for (Vec2 b : {Vec2{4, 2}, Vec2{-4, 2}, Vec2{0, 4}, Vec2{4, 0}}) {
    EXPECT_TRUE(IsInsideSegment({0, 0}, b, 0.25 * b));
    EXPECT_TRUE(IsInsideSegment(b, {0, 0}, 0.25 * b));
    EXPECT_FALSE(IsInsideSegment({0, 0}, b, {0, 0}));
    EXPECT_FALSE(IsInsideSegment({0, 0}, b, b));
    EXPECT_FALSE(IsInsideSegment({0, 0}, b, 1.25 * b));
    EXPECT_FALSE(IsInsideSegment({0, 0}, b, -0.25 * b));
    EXPECT_FALSE(IsInsideSegment({0, 0}, b, 0.25 * b + Vec2{1e-15, -1e-15}));
  }
}

TEST(IsAhead, ComparesDirections) {
  EXPECT_TRUE(IsAhead({1, 1}, {1, 2}, {1, 9}));
  EXPECT_FALSE(IsAhead({1, 1}, {1, 2}, {1, -9}));
  EXPECT_TRUE(IsAhead({1, 1}, {0, 0}, {-3, -3}));
  EXPECT_FALSE(IsAhead({1, 1}, {0, 0}, {3, 3}));
}

// True if the open segments have a point in common, in rational numbers: by the parameters of the
// crossing, or of the ends of one along the other.
bool RationalCrossOrOverlap(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
  const mpq_class ux = mpq_class(b.x) - a.x;
  const mpq_class uy = mpq_class(b.y) - a.y;
  const mpq_class vx = mpq_class(d.x) - c.x;
  const mpq_class vy = mpq_class(d.y) - c.y;
  const mpq_class wx = mpq_class(c.x) - a.x;
  const mpq_class wy = mpq_class(c.y) - a.y;
  const mpq_class determinant = ux * vy - uy * vx;
  if (determinant != 0) {
    const mpq_class s = (wx * vy - wy * vx) / determinant;
    const mpq_class t = (wx * uy - wy * ux) / determinant;
    return s > 0 && s < 1 && t > 0 && t < 1;
  }
  if (wx * uy - wy * ux != 0) return false;
  const mpq_class square = ux * ux + uy * uy;
  const mpq_class s = (wx * ux + wy * uy) / square;
  const mpq_class t = s + (vx * ux + vy * uy) / square;
  const mpq_class low = s < t ? s : t;
  const mpq_class high = s < t ? t : s;
  return low < 1 && high > 0;
}

// Goal: every kind of meeting, most of them degenerate.
// Method: all pairs of random segments on a grid of 5 x 5 points, against rational parameters.
TEST(CrossOrOverlap, AgreesWithRationalParameters) {
  Rng rng(5);
  int true_count = 0;
  const auto point = [&rng] {
    return Vec2{0.1 * static_cast<double>(rng.Below(5)), 0.1 * static_cast<double>(rng.Below(5))};
  };
  for (int trial = 0; trial < 20000; ++trial) {
    const Vec2 a = point();
    const Vec2 b = point();
    const Vec2 c = point();
    const Vec2 d = point();
    if (a == b || c == d) continue;
    const bool want = RationalCrossOrOverlap(a, b, c, d);
    true_count += want ? 1 : 0;
    ASSERT_EQ(CrossOrOverlap(a, b, c, d), want) << "seed 5, trial " << trial;
    ASSERT_EQ(CrossOrOverlap(d, c, a, b), want) << "seed 5, trial " << trial;
  }
  EXPECT_GT(true_count, 2000);
}

}  // namespace
}  // namespace pliant
