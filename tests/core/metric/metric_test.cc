#include "core/metric/metric.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/rng.h"

namespace pliant {
namespace {

Vec2 Direction(double angle) { return {std::cos(angle), std::sin(angle)}; }

/// Eq. 3 written out with trigonometric functions and matrix products.
Metric Equation3(double r1, double r2, double t) {
  const double c = std::cos(t);
  const double s = std::sin(t);
  const double a = 1 / (r1 * r1);
  const double b = 1 / (r2 * r2);
  return {a * c * c + b * s * s, (a - b) * s * c, a * s * s + b * c * c};
}

/// Largest |e' (a - b) e| / (e' b e) over `count` directions, equally spaced in angle.
double WorstRelativeDifference(const Metric& a, const Metric& b, int count = 360) {
  double worst = 0;
  for (int i = 0; i < count; ++i) {
    const Vec2 e = Direction(i * std::numbers::pi / count);
    worst = std::max(worst, std::abs(SquaredLength(a, e) / SquaredLength(b, e) - 1));
  }
  return worst;
}

/// The least of (e' a e) / (e' b e) over all directions: how far a is from being inside b.
/// The extremes in the frame of b's axes are found by sampling there, so that a needle-like b
/// cannot hide one between two samples.
double LeastRatio(const Metric& a, const Metric& b) {
  const MetricAxes axes = AxesFromMetric(b);
  const Vec2 u = axes.major_direction;
  const Vec2 v = {-u.y, u.x};
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 360; ++i) {
    const Vec2 unit = Direction(i * std::numbers::pi / 360);
    const Vec2 e = axes.major_radius * unit.x * u + axes.minor_radius * unit.y * v;
    least = std::min(least, SquaredLength(a, e) / SquaredLength(b, e));
  }
  return least;
}

struct RandomMetric {
  double r1;
  double r2;
  double t;
  Metric metric;
};
RandomMetric Draw(Rng& rng, double ratio_exponent_max) {
  const double r1 = std::pow(10, rng.Uniform(-5, 5));
  const double r2 = r1 * std::pow(10, -rng.Uniform(0, ratio_exponent_max));
  const double t = rng.Uniform(0, std::numbers::pi);
  return {r1, r2, t, Equation3(r1, r2, t)};
}

TEST(MetricFromAxes, IsEquation3) {
  Rng rng(1996);
  for (int trial = 0; trial < 1000; ++trial) {
    const auto [r1, r2, t, expected] = Draw(rng, 4);
    const Metric m = MetricFromAxes({r1, r2, Direction(t)});
    EXPECT_LT(WorstRelativeDifference(m, expected), 1e-7) << r1 << " " << r2 << " " << t;
  }
}

// Goal: axes come back with the accuracy that the entries allow. Rounding an entry by 1e-16 moves
// the small eigenvalue by 1e-16 times the ratio of the two, so that is the tolerance.
TEST(AxesFromMetric, InvertsEquation3UpToTheConditionOfTheTensor) {
  Rng rng(1996);
  for (int trial = 0; trial < 20000; ++trial) {
    const auto [r1, r2, t, m] = Draw(rng, 6);
    SCOPED_TRACE(::testing::Message() << "trial " << trial << " " << r1 << " " << r2 << " " << t);
    ASSERT_TRUE(IsPositiveDefinite(m));
    const MetricAxes axes = AxesFromMetric(m);
    const double condition = (r1 / r2) * (r1 / r2);
    ASSERT_NEAR(axes.minor_radius / r2, 1, 4e-16 * 4);
    ASSERT_NEAR(axes.major_radius / r1, 1, 2e-15 * condition);
    ASSERT_NEAR(Length(axes.major_direction), 1, 1e-15);
    if (condition > 1.1) {
      ASSERT_NEAR(std::abs(Cross(axes.major_direction, Direction(t))), 0, 2e-14);
    }
    ASSERT_TRUE(axes.major_direction.x > 0 || axes.major_direction.x == 0);
  }
}

TEST(AxesFromMetric, IsExactOnTheAxesAtAnyRatio) {
  for (const double ratio : {1.0, 1.0 + 0x1p-50, 1e4, 1e8, 1e70}) {
    const MetricAxes flat = AxesFromMetric({1, 0, ratio * ratio});
    EXPECT_DOUBLE_EQ(flat.major_radius, 1);
    EXPECT_DOUBLE_EQ(flat.minor_radius, 1 / ratio);
    EXPECT_EQ(flat.major_direction, (Vec2{1, 0}));
    const MetricAxes upright = AxesFromMetric({ratio * ratio, 0, 1});
    EXPECT_DOUBLE_EQ(upright.major_radius, 1);
    EXPECT_DOUBLE_EQ(upright.minor_radius, 1 / ratio);
  }
  EXPECT_EQ(AxesFromMetric(Metric::Isotropic(0.5)).major_direction, (Vec2{1, 0}));
  EXPECT_EQ(AxesFromMetric({4, 0, 1}).major_direction, (Vec2{0, 1}));
}

TEST(AxesFromMetric, KeepsTheAxesOfANearlyIsotropicMetric) {
  for (const double t : {0.3, 1.0, 2.0, 3.0}) {
    const double d = 0x1p-30;
    const Metric m = {1 + d * std::cos(2 * t), d * std::sin(2 * t), 1 - d * std::cos(2 * t)};
    // The eigenvector at angle t belongs to the large eigenvalue, so the major axis is across.
    EXPECT_NEAR(Dot(AxesFromMetric(m).major_direction, Direction(t)), 0, 1e-6);
  }
}

TEST(IsPositiveDefinite, RefusesWhatCannotBeMeasured) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(IsPositiveDefinite({1, 0, 1}));
  EXPECT_TRUE(IsPositiveDefinite({1, 0.999999, 1}));
  EXPECT_TRUE(IsPositiveDefinite({1e140, 0, 1e-140}));
  EXPECT_FALSE(IsPositiveDefinite({1, 1, 1}));
  EXPECT_FALSE(IsPositiveDefinite({1, 2, 1}));
  EXPECT_FALSE(IsPositiveDefinite({-1, 0, -1}));
  EXPECT_FALSE(IsPositiveDefinite({0, 0, 1}));
  EXPECT_FALSE(IsPositiveDefinite({0, 0, 0}));
  EXPECT_FALSE(IsPositiveDefinite({kNaN, 0, 1}));
  EXPECT_FALSE(IsPositiveDefinite({1, kNaN, 1}));
  EXPECT_FALSE(IsPositiveDefinite({1, 0, kInfinity}));
  EXPECT_FALSE(IsPositiveDefinite({1e-160, 0, 1e-160}));
  // 0.1 * 0.9 rounds above 0.3 * 0.3, though as real numbers these doubles are the other way.
  const Metric rounded = {0x1.999999999999ap-4, 0x1.3333333333333p-2, 0x1.ccccccccccccdp-1};
  EXPECT_EQ(IsPositiveDefinite(rounded),
            EigenvaluesOf(rounded).low > 0 && Determinant(rounded) > 0);
}

TEST(EigenvaluesOf, TellsTheSignOfTheSmallOne) {
  EXPECT_EQ(EigenvaluesOf({1, 1, 1}).low, 0);
  EXPECT_EQ(EigenvaluesOf({1, 1, 1}).high, 2);
  EXPECT_EQ(EigenvaluesOf({0, 0, 0}).high, 0);
  EXPECT_NEAR(EigenvaluesOf({1, 2, 1}).low, -1, 1e-15);
  EXPECT_NEAR(EigenvaluesOf({1, 2, 1}).high, 3, 1e-15);
  EXPECT_NEAR(EigenvaluesOf({-1, 2, -1}).low, -3, 1e-15);
  EXPECT_NEAR(EigenvaluesOf({-1, 2, -1}).high, 1, 1e-15);
  // One unit in the last place decides, 2^-52 below and above.
  EXPECT_LT(EigenvaluesOf({1, 1 + 0x1p-52, 1}).low, 0);
  EXPECT_GT(EigenvaluesOf({1, 1 - 0x1p-53, 1}).low, 0);
}

TEST(LogMetric, RoundTripsWithTheAccuracyOfTheEntries) {
  Rng rng(1996);
  for (int trial = 0; trial < 20000; ++trial) {
    const auto [r1, r2, t, m] = Draw(rng, 4);
    const double condition = (r1 / r2) * (r1 / r2);
    ASSERT_LT(WorstRelativeDifference(Exp(Log(m)), m, 36), 1e-14 * condition + 1e-13)
        << "trial " << trial << " " << r1 << " " << r2 << " " << t;
  }
}

TEST(LogMetric, IsTheLogarithmOfTheEigenvalues) {
  const LogMetric log = Log(Metric{std::exp(2.0), 0, std::exp(-3.0)});
  EXPECT_NEAR(log.l11, 2, 1e-15);
  EXPECT_EQ(log.l12, 0);
  EXPECT_NEAR(log.l22, -3, 1e-15);
  // A turn by 45 degrees: (a + b) / 2 on the diagonal, (a - b) / 2 beside it.
  const double a = std::exp(2.0);
  const double b = std::exp(-3.0);
  const LogMetric turned = Log(Metric{(a + b) / 2, (a - b) / 2, (a + b) / 2});
  EXPECT_NEAR(turned.l11, -0.5, 1e-13);
  EXPECT_NEAR(turned.l12, 2.5, 1e-13);
}

// Goal: many at once have the bits of each alone, also where eigenvalues are equal, or logarithms
// and exponentials leave the range of a kernel; at any place of a block.
TEST(LogMetric, HasTheSameBitsForManyAtOnce) {
  constexpr std::uint64_t kSeed = 64;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  Rng rng(kSeed);
  std::vector<Metric> metrics = {Metric::Isotropic(1),  Metric::Isotropic(0.003), {2, 0, 2},
                                 {1e-150, 0, 1e-150},   {1e-150, 0, 1e150},       {1e150, 0, 1e150},
                                 {1e-150, 0, 2.3e-158}, {4e-324, 0, 1},           {1, 1e-170, 1},
                                 {1, 1 - 1e-16, 1}};
  while (metrics.size() < 500) metrics.push_back(Draw(rng, 7).metric);
  for (std::size_t i = metrics.size() - 1; i > 0; --i) {
    std::swap(metrics[i], metrics[rng.Below(i + 1)]);
  }
  std::vector<LogMetric> logs(metrics.size());
  LogEach(metrics, logs);
  for (std::size_t i = 0; i < metrics.size(); ++i) EXPECT_EQ(logs[i], Log(metrics[i])) << i;

  for (int i = 0; i < 20; ++i) {
    logs.push_back({rng.Uniform(-800, 800), rng.Uniform(-300, 300), rng.Uniform(-800, 800)});
  }
  for (const std::size_t count : {0U, 1U, 63U, 64U, 65U, 520U}) {
    std::vector<Metric> found(count);
    ExpEach(std::span(logs).first(count), found);
    for (std::size_t i = 0; i < count; ++i) {
      const Metric one = Exp(logs[i]);
      const bool is_nan = one.m11 != one.m11 || one.m12 != one.m12 || one.m22 != one.m22;
      EXPECT_TRUE(is_nan || found[i] == one) << i;
    }
  }
}

TEST(LogDistance, ComparesSizesByTheirRatio) {
  const LogMetric fine = Log(Metric::Isotropic(0.1));
  const LogMetric coarse = Log(Metric::Isotropic(0.2));
  EXPECT_EQ(LogDistance(fine, fine), 0);
  EXPECT_NEAR(LogDistance(fine, coarse), std::sqrt(2.0) * std::log(4.0), 1e-14);
  EXPECT_EQ(LogDistance(fine, coarse), LogDistance(coarse, fine));
  // Twice as fine along one axis, whichever that is.
  const LogMetric turned = Log(MetricFromAxes({0.2, 0.1, {0.6, 0.8}}));
  EXPECT_NEAR(LogDistance(turned, coarse), std::log(4.0), 1e-13);
}

/// A B^-1 A.
Metric Sandwich(const Metric& a, const Metric& b) {
  const double inverse = 1 / Determinant(b);
  const Metric i = {inverse * b.m22, -inverse * b.m12, inverse * b.m11};
  const double p11 = a.m11 * i.m11 + a.m12 * i.m12;
  const double p12 = a.m11 * i.m12 + a.m12 * i.m22;
  const double p21 = a.m12 * i.m11 + a.m22 * i.m12;
  const double p22 = a.m12 * i.m12 + a.m22 * i.m22;
  return {p11 * a.m11 + p12 * a.m12, p11 * a.m12 + p12 * a.m22, p21 * a.m12 + p22 * a.m22};
}

// Goal: the mean is what it says. Method: G A^-1 G = B, which has one positive definite solution;
// sizes whose mean everyone knows; and metrics at the end of what can be computed.
TEST(GeometricMean, SolvesItsEquation) {
  EXPECT_NEAR(GeometricMean(Metric::Isotropic(0.1), Metric::Isotropic(10)).m11, 1, 1e-14);
  Rng rng(11);
  for (int trial = 0; trial < 500; ++trial) {
    const Metric a = Draw(rng, 2).metric;
    const Metric b = Draw(rng, 2).metric;
    const Metric mean = GeometricMean(a, b);
    ASSERT_TRUE(IsPositiveDefinite(mean)) << "seed 11, trial " << trial;
    EXPECT_LT(WorstRelativeDifference(Sandwich(mean, a), b), 1e-6) << "seed 11, trial " << trial;
    EXPECT_LT(WorstRelativeDifference(GeometricMean(b, a), mean), 1e-14);
  }
  const Metric huge = Metric::Isotropic(1e-70);
  const Metric tiny = Metric::Isotropic(1e70);
  EXPECT_TRUE(IsPositiveDefinite(GeometricMean(huge, tiny)));
  EXPECT_TRUE(IsPositiveDefinite(GeometricMean(huge, huge)));
}

TEST(LogEuclideanMean, IsGeometricAndReachesTheEnds) {
  const Metric middle = LogEuclideanMean(Metric::Isotropic(0.1), Metric::Isotropic(10), 0.5);
  EXPECT_NEAR(middle.m11, 1, 1e-14);
  EXPECT_EQ(middle.m12, 0);
  Rng rng(7);
  for (int trial = 0; trial < 200; ++trial) {
    const Metric a = Draw(rng, 3).metric;
    const Metric b = Draw(rng, 3).metric;
    EXPECT_LT(WorstRelativeDifference(LogEuclideanMean(a, b, 0), a), 1e-8);
    EXPECT_LT(WorstRelativeDifference(LogEuclideanMean(a, b, 1), b), 1e-8);
    const Metric mean = LogEuclideanMean(a, b, 0.3);
    ASSERT_TRUE(IsPositiveDefinite(mean));
    EXPECT_NEAR(std::log(Determinant(mean)),
                0.7 * std::log(Determinant(a)) + 0.3 * std::log(Determinant(b)), 1e-6);
  }
}

// Goal: the intersection is at least as fine as both in every direction, and no finer than it
// must be. Method: sampled directions; its determinant is that of the generalized eigenvalues.
TEST(Intersect, DominatesBothAndIsTheLargestThatDoes) {
  Rng rng(1996);
  for (int trial = 0; trial < 3000; ++trial) {
    const RandomMetric a = Draw(rng, 4);
    RandomMetric b = Draw(rng, 4);
    b.metric = (b.r1 * b.r2) / (a.r1 * a.r2) * b.metric;  // Of one area, so that both matter.
    SCOPED_TRACE(::testing::Message() << "trial " << trial);
    const Metric m = Intersect(a.metric, b.metric);
    ASSERT_TRUE(IsPositiveDefinite(m));
    ASSERT_GT(LeastRatio(m, a.metric), 1 - 1e-7);
    ASSERT_GT(LeastRatio(m, b.metric), 1 - 1e-7);
    // det m / det a = product of max(1, lambda_i), lambda_i the roots of det(b - lambda a).
    const double det_a = Determinant(a.metric);
    const double p = (a.metric.m11 * b.metric.m22 + a.metric.m22 * b.metric.m11 -
                      2 * a.metric.m12 * b.metric.m12) /
                     det_a;
    const double q = Determinant(b.metric) / det_a;
    const double high = p / 2 + std::sqrt(std::max(0.0, p * p / 4 - q));
    const double expected = std::max(1.0, high) * std::max(1.0, q / high);
    ASSERT_NEAR(Determinant(m) / det_a / expected, 1, 1e-6);
  }
}

TEST(Intersect, OfNestedMetricsIsTheFinerOneToTheBit) {
  const Metric fine = {9, 1, 7};
  const Metric coarse = {2, 0.5, 1};
  EXPECT_EQ(Intersect(fine, coarse), fine);
  EXPECT_EQ(Intersect(coarse, fine), fine);
  EXPECT_EQ(Intersect(fine, fine), fine);
  const Metric crossed = Intersect({100, 0, 1}, {1, 0, 100});
  EXPECT_NEAR(crossed.m11, 100, 1e-12);
  EXPECT_NEAR(crossed.m22, 100, 1e-12);
  EXPECT_NEAR(crossed.m12, 0, 1e-12);
}

TEST(Intersect, CommutesWithItsArgumentsAndWithTurningAndScaling) {
  Rng rng(5);
  for (int trial = 0; trial < 1000; ++trial) {
    const double t1 = rng.Uniform(0, 3);
    const double t2 = rng.Uniform(0, 3);
    const double turn = rng.Uniform(0, 6);
    const double r = rng.Uniform(0.1, 3);
    const Metric m = Intersect(Equation3(1, 0.05, t1), Equation3(r, 0.1 * r, t2));
    const Metric swapped = Intersect(Equation3(r, 0.1 * r, t2), Equation3(1, 0.05, t1));
    EXPECT_LT(WorstRelativeDifference(m, swapped), 1e-9);
    const double scale = 37.0;
    const Metric moved = Intersect(Equation3(scale, scale * 0.05, t1 + turn),
                                   Equation3(scale * r, scale * 0.1 * r, t2 + turn));
    const MetricAxes axes = AxesFromMetric(m);
    const MetricAxes moved_axes = AxesFromMetric(moved);
    EXPECT_NEAR(moved_axes.major_radius / (scale * axes.major_radius), 1, 1e-9);
    EXPECT_NEAR(moved_axes.minor_radius / (scale * axes.minor_radius), 1, 1e-9);
  }
}

TEST(Bound, ForcesTheRadiiIntoTheBoundsAndKeepsTheAxes) {
  const Vec2 u = Direction(0.7);
  const Metric m = MetricFromAxes({10, 0.01, u});
  const auto bounded = [&](const SizeBounds& bounds) { return AxesFromMetric(Bound(m, bounds)); };
  const auto expect = [&](const MetricAxes& axes, double major, double minor) {
    EXPECT_NEAR(axes.major_radius / major, 1, 1e-9);
    EXPECT_NEAR(axes.minor_radius / minor, 1, 1e-9);
    const double turn = major == minor ? 0 : std::abs(Cross(axes.major_direction, u));
    EXPECT_NEAR(turn, 0, 1e-9);
  };
  expect(bounded({.size_min = 0.1}), 10, 0.1);
  expect(bounded({.size_max = 2}), 2, 0.01);
  expect(bounded({.size_min = 0.1, .size_max = 2}), 2, 0.1);
  expect(bounded({.anisotropy_max = 50}), 0.5, 0.01);
  expect(bounded({.size_min = 0.1, .size_max = 8, .anisotropy_max = 50}), 5, 0.1);
  expect(bounded({.size_min = 20}), 20, 20);
  expect(bounded({.size_max = 0.001}), 0.001, 0.001);
  EXPECT_EQ(Bound(m, {}), m);
  EXPECT_EQ(Bound(m, {.size_min = 0.001, .size_max = 100, .anisotropy_max = 1e6}), m);
}

TEST(Bound, RaisesSemiDefiniteAndIndefiniteTensorsToTheLargestSize) {
  const Metric flat = Bound({0, 0, 0}, {.size_max = 4});
  EXPECT_EQ(flat, Metric::Isotropic(4));
  const MetricAxes axes = AxesFromMetric(Bound({1, 1, 1}, {.size_max = 4}));
  EXPECT_NEAR(axes.major_radius, 4, 1e-12);
  EXPECT_NEAR(axes.minor_radius, std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(axes.major_direction.y, -std::sqrt(0.5), 1e-12);
  EXPECT_TRUE(IsPositiveDefinite(Bound({-3, 1, -1}, {.size_max = 4})));
}

// Goal: the change is what the most different direction sees. Method: sample directions in the
// frame of the old tensor.
TEST(RelativeChange, IsTheLargestChangeOfASquaredLength) {
  Rng rng(1996);
  for (int trial = 0; trial < 500; ++trial) {
    const Metric old = Draw(rng, 2).metric;
    EXPECT_NEAR(RelativeChange(old, old), 0, 1e-6);
    EXPECT_NEAR(RelativeChange(old, 1.05 * old), 0.05, 1e-6);
    const MetricAxes axes = AxesFromMetric(old);
    const double t = rng.Uniform(0, 3);
    const Metric now = MetricFromAxes({axes.major_radius * rng.Uniform(0.8, 1.5),
                                       axes.minor_radius * rng.Uniform(0.5, 0.7), Direction(t)});
    const Vec2 u = axes.major_direction;
    const Vec2 v = {-u.y, u.x};
    double most = 0;
    for (int i = 0; i < 360; ++i) {
      const Vec2 unit = Direction(i * std::numbers::pi / 360);
      const Vec2 e = axes.major_radius * unit.x * u + axes.minor_radius * unit.y * v;
      most = std::max(most, std::abs(SquaredLength(now, e) / SquaredLength(old, e) - 1));
    }
    EXPECT_NEAR(RelativeChange(old, now) / most, 1, 1e-3);
  }
  EXPECT_DOUBLE_EQ(RelativeChange({1, 0, 1}, {1, 0, 0.25}), 0.75);
  EXPECT_DOUBLE_EQ(RelativeChange({1, 0, 1}, {1, 0, 4}), 3);
}

TEST(Distance, IsEquation4AndNormalizedAreaIsEquation5) {
  const Metric a = Metric::Isotropic(0.5);
  const Metric b = {1, 0, 16};
  EXPECT_DOUBLE_EQ(Distance({0, 0}, a, {2, 0}, b), std::sqrt(2.5) * 2);
  EXPECT_DOUBLE_EQ(Distance({0, 0}, a, {0, 1}, b), std::sqrt(10.0));
  const double det = ((4 + 1 + 1) / 3.0) * ((4 + 16 + 1) / 3.0);
  EXPECT_DOUBLE_EQ(NormalizedArea({0, 0}, a, {1, 0}, b, {0, 1}, {1, 0, 1}), 0.5 * std::sqrt(det));
  EXPECT_LT(NormalizedArea({0, 0}, a, {0, 1}, b, {1, 0}, {1, 0, 1}), 0);
}

}  // namespace
}  // namespace pliant
