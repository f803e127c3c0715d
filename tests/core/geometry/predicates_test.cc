#include "core/geometry/predicates.h"

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <vector>

#include "core/base/rng.h"

namespace pliant {
namespace {

// The oracle: the same determinants in GMP's rational numbers.
int RationalOrient2d(Vec2 a, Vec2 b, Vec2 c) {
  const mpq_class px = mpq_class(a.x) - c.x;
  const mpq_class py = mpq_class(a.y) - c.y;
  const mpq_class qx = mpq_class(b.x) - c.x;
  const mpq_class qy = mpq_class(b.y) - c.y;
  return sgn(mpq_class(px * qy - py * qx));
}

int RationalInCircle(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
  const mpq_class px = mpq_class(a.x) - d.x;
  const mpq_class py = mpq_class(a.y) - d.y;
  const mpq_class qx = mpq_class(b.x) - d.x;
  const mpq_class qy = mpq_class(b.y) - d.y;
  const mpq_class rx = mpq_class(c.x) - d.x;
  const mpq_class ry = mpq_class(c.y) - d.y;
  const mpq_class determinant = (px * px + py * py) * (qx * ry - qy * rx) +
                                (qx * qx + qy * qy) * (rx * py - ry * px) +
                                (rx * rx + ry * ry) * (px * qy - py * qx);
  return sgn(determinant);
}

// How often a suite of trials met each outcome; a test that never reaches the exact path, or never
// sees a zero, tests nothing.
struct Tally {
  int undecided = 0;
  int zero = 0;
  int negative = 0;
  int positive = 0;

  void Count(int filtered, int sign) {
    undecided += filtered == 0 ? 1 : 0;
    (sign == 0 ? zero : sign < 0 ? negative : positive) += 1;
  }
};

// Checks all six orders of three points.
void CheckOrient2d(const std::array<Vec2, 3>& p, Tally& tally) {
  const int want = RationalOrient2d(p[0], p[1], p[2]);
  tally.Count(internal::FilterOrient2d(p[0], p[1], p[2]), want);
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3;
    const std::size_t k = (i + 2) % 3;
    ASSERT_EQ(Orient2d(p[i], p[j], p[k]), want);
    ASSERT_EQ(Orient2d(p[j], p[i], p[k]), -want);
  }
}

// Checks all twenty-four orders of four points: each swap of two changes the sign.
void CheckInCircle(const std::array<Vec2, 4>& p, Tally& tally) {
  const int want = RationalInCircle(p[0], p[1], p[2], p[3]);
  tally.Count(internal::FilterInCircle(p[0], p[1], p[2], p[3]), want);
  std::array<std::size_t, 4> order = {0, 1, 2, 3};
  do {
    int sign = want;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) sign = order[i] > order[j] ? -sign : sign;
    }
    ASSERT_EQ(InCircle(p[order[0]], p[order[1]], p[order[2]], p[order[3]]), sign);
  } while (std::next_permutation(order.begin(), order.end()));
}

double Nudge(double x, int ulps) {
  const double toward =
      ulps < 0 ? -std::numeric_limits<double>::infinity() : std::numeric_limits<double>::infinity();
  for (int i = 0; i < std::abs(ulps); ++i) x = std::nextafter(x, toward);
  return x;
}

Vec2 RandomNudge(Vec2 p, Rng& rng) {
  return {Nudge(p.x, static_cast<int>(rng.Below(5)) - 2),
          Nudge(p.y, static_cast<int>(rng.Below(5)) - 2)};
}

TEST(Orient2d, HasTheDocumentedSign) {
  EXPECT_EQ(Orient2d({0, 0}, {1, 0}, {0, 1}), 1);
  EXPECT_EQ(Orient2d({0, 0}, {0, 1}, {1, 0}), -1);
  EXPECT_EQ(Orient2d({0, 0}, {1, 1}, {3, 3}), 0);
}

TEST(InCircle, HasTheDocumentedSign) {
  EXPECT_EQ(InCircle({0, 0}, {1, 0}, {0, 1}, {0.5, 0.5}), 1);
  EXPECT_EQ(InCircle({0, 0}, {1, 0}, {0, 1}, {1, 1}), 0);
  EXPECT_EQ(InCircle({0, 0}, {1, 0}, {0, 1}, {1, 1.5}), -1);
}

// Goal: exact around points that are collinear but for a few units in the last place.
// Method: the classical picture: a grid of ulps around a point of the line y = x.
TEST(Orient2d, IsExactOnAGridOfUlpsAroundALine) {
  Tally tally;
  for (int i = -20; i <= 20; ++i) {
    for (int j = -20; j <= 20; ++j) {
      CheckOrient2d({Vec2{Nudge(0.5, i), Nudge(0.5, j)}, Vec2{12, 12}, Vec2{24, 24}}, tally);
    }
  }
  EXPECT_GT(tally.undecided, 800);
  EXPECT_EQ(tally.zero, 41);
  EXPECT_EQ(tally.negative, tally.positive);
}

// Goal: exact for nearly collinear points of mixed magnitudes anywhere.
// Method: two random points, a third near a random point of their line, nudged by 0 to 2 ulps.
TEST(Orient2d, IsExactNearRandomLines) {
  Rng rng(1997);
  Tally tally;
  for (int trial = 0; trial < 20000; ++trial) {
    SCOPED_TRACE(::testing::Message() << "seed 1997, trial " << trial);
    const double scale = std::ldexp(1.0, static_cast<int>(rng.Below(200)) - 100);
    const Vec2 a = scale * Vec2{rng.Uniform(-1, 1), rng.Uniform(-1, 1)};
    const Vec2 b = scale * Vec2{rng.Uniform(-1, 1), rng.Below(4) == 0 ? 0 : rng.Uniform(-1, 1)};
    const Vec2 c = RandomNudge(a + rng.Uniform(-2, 2) * (b - a), rng);
    ASSERT_NO_FATAL_FAILURE(CheckOrient2d({a, b, c}, tally));
  }
  EXPECT_GT(tally.undecided, 10000);
  EXPECT_GT(tally.negative, 5000);
  EXPECT_GT(tally.positive, 5000);
}

// Goal: exact where rounding of the differences themselves matters: near and far points mixed.
TEST(Orient2d, IsExactForMixedMagnitudes) {
  Rng rng(7);
  Tally tally;
  const auto coordinate = [&] {
    const int exponent = static_cast<int>(rng.Below(120)) - 60;
    return rng.Below(8) == 0 ? 0 : std::ldexp(rng.Uniform(-1, 1), exponent);
  };
  for (int trial = 0; trial < 20000; ++trial) {
    SCOPED_TRACE(::testing::Message() << "seed 7, trial " << trial);
    const Vec2 a = {coordinate(), coordinate()};
    const Vec2 b = {coordinate(), coordinate()};
    const Vec2 c = rng.Below(2) == 0 ? RandomNudge(2 * a, rng) : Vec2{coordinate(), coordinate()};
    ASSERT_NO_FATAL_FAILURE(CheckOrient2d({a, rng.Below(2) == 0 ? 4 * a : b, c}, tally));
  }
  EXPECT_GT(tally.undecided, 2000);
}

// Goal: exact among co-circular points.
// Method: the lattice points of x^2 + y^2 = 65^2 * 17^2 as they are (all exactly co-circular), then
// moved far from the origin, scaled by 0.1 (so that they are only nearly so), and nudged by ulps.
TEST(InCircle, IsExactNearCommonCircles) {
  std::vector<Vec2> lattice;
  for (int x = -1105; x <= 1105; ++x) {
    for (int y = -1105; y <= 1105; ++y) {
      if (x * x + y * y == 1105 * 1105) lattice.push_back({1.0 * x, 1.0 * y});
    }
  }
  ASSERT_EQ(lattice.size(), 108U);
  Rng rng(1105);
  Tally tally;
  for (int trial = 0; trial < 8000; ++trial) {
    SCOPED_TRACE(::testing::Message() << "seed 1105, trial " << trial);
    const Vec2 offset = trial % 3 == 0 ? Vec2{0, 0} : Vec2{rng.Uniform(-1e4, 1e4), 12345.75};
    const double scale = trial % 2 == 0 ? 1 : 0.1;
    std::array<Vec2, 4> p;
    for (Vec2& q : p) q = scale * (lattice[rng.Below(lattice.size())] + offset);
    if (trial % 5 != 0) p[3] = RandomNudge(p[3], rng);
    ASSERT_NO_FATAL_FAILURE(CheckInCircle(p, tally));
  }
  EXPECT_GT(tally.undecided, 4000);
  EXPECT_GT(tally.zero, 500);
  EXPECT_GT(tally.negative, 500);
  EXPECT_GT(tally.positive, 500);
}

// Goal: exact where the differences of coordinates are themselves rounded.
// Method: points of a circle by its rational parametrisation with parameters of all magnitudes, so
// that near and far neighbours mix, around centres of all magnitudes.
TEST(InCircle, IsExactForMixedMagnitudes) {
  Rng rng(4);
  Tally tally;
  for (int trial = 0; trial < 4000; ++trial) {
    SCOPED_TRACE(::testing::Message() << "seed 4, trial " << trial);
    const double radius = std::ldexp(1.0, static_cast<int>(rng.Below(40)) - 20);
    const Vec2 center = {rng.Uniform(-1, 1), rng.Uniform(-1e-9, 1e-9)};
    std::array<Vec2, 4> p;
    for (Vec2& q : p) {
      const double t = std::ldexp(rng.Uniform(-1, 1), static_cast<int>(rng.Below(40)) - 20);
      q = center + radius / (1 + t * t) * Vec2{1 - t * t, 2 * t};
    }
    ASSERT_NO_FATAL_FAILURE(CheckInCircle(p, tally));
  }
  EXPECT_GT(tally.undecided, 1000);
  EXPECT_GT(tally.negative, 1000);
  EXPECT_GT(tally.positive, 1000);
}

// Goal: right at every magnitude that a finite double can have, where expansions would overflow or
// lose bits: the integers take over.
TEST(Predicates, AreExactFromSubnormalToHuge) {
  constexpr double kHuge = std::numeric_limits<double>::max();
  constexpr double kTiny = std::numeric_limits<double>::denorm_min();
  Rng rng(1074);
  Tally orient;
  Tally circle;
  const auto coordinate = [&] {
    switch (rng.Below(6)) {
      case 0:
        return kTiny * static_cast<double>(rng.Below(4));
      case 1:
        return -kHuge;
      case 2:
        return Nudge(kHuge, -static_cast<int>(rng.Below(3)));
      case 3:
        return std::ldexp(rng.Uniform(-1, 1), static_cast<int>(rng.Below(2090)) - 1070);
      case 4:
        return 1.0;
      default:
        return 0.0;
    }
  };
  for (int trial = 0; trial < 1000; ++trial) {
    SCOPED_TRACE(::testing::Message() << "seed 1074, trial " << trial);
    std::array<Vec2, 4> p;
    for (Vec2& q : p) q = {coordinate(), coordinate()};
    if (trial % 3 == 0) {  // All subnormal: the products vanish in floating point.
      const auto digit = [&] { return kTiny * static_cast<double>(rng.Below(9)); };
      for (Vec2& q : p) q = {digit(), digit()};
    }
    ASSERT_NO_FATAL_FAILURE(CheckOrient2d({p[0], p[1], p[2]}, orient));
    ASSERT_NO_FATAL_FAILURE(CheckInCircle(p, circle));
  }
  EXPECT_GT(orient.undecided, 300);
  EXPECT_GT(circle.undecided, 300);
  EXPECT_GT(orient.positive, 100);
  EXPECT_GT(circle.positive, 100);
}

}  // namespace
}  // namespace pliant
