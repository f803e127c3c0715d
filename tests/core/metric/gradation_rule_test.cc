#include "core/metric/gradation_rule.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/rng.h"

namespace pliant {
namespace {

AxisFrame FrameAt(double angle) { return {std::cos(2 * angle), std::sin(2 * angle)}; }

AxisSizes Draw(Rng& rng, double ratio_max) {
  const double thin = std::pow(10, rng.Uniform(-3, 1));
  const double wide = thin * std::pow(ratio_max, rng.Unit());
  return {thin, wide, FrameAt(rng.Uniform(0, std::numbers::pi))};
}

Vec2 DrawEdge(Rng& rng) { return {rng.Uniform(-1, 1), rng.Uniform(-1, 1)}; }

TEST(AxisSizes, RoundTripThroughTheMetric) {
  Rng rng(1996);
  for (int trial = 0; trial < 5000; ++trial) {
    const AxisSizes sizes = Draw(rng, 1e4);
    const double ratio2 = (sizes.wide / sizes.thin) * (sizes.wide / sizes.thin);
    const AxisSizes back = SizesFromMetric(MetricFromSizes(sizes));
    ASSERT_NEAR(back.thin / sizes.thin, 1, 1e-15 * 4);
    ASSERT_NEAR(back.wide / sizes.wide, 1, 2e-15 * ratio2 + 4e-15);
    if (ratio2 > 1.1) {
      ASSERT_LT(SquaredSine(back.frame, sizes.frame), 1e-28);
    }
  }
  EXPECT_EQ(SizesFromMetric({1, 0, 16}), (AxisSizes{0.25, 1, {-1, 0}}));
  EXPECT_EQ(SizesFromMetric(Metric::Isotropic(2)), (AxisSizes{2, 2, {1, 0}}));
}

TEST(Split, GivesTheSquaredComponents) {
  Rng rng(1996);
  for (int trial = 0; trial < 1000; ++trial) {
    const double angle = rng.Uniform(0, std::numbers::pi);
    const Vec2 e = DrawEdge(rng);
    const double along = e.x * std::cos(angle) + e.y * std::sin(angle);
    const double across = e.y * std::cos(angle) - e.x * std::sin(angle);
    EXPECT_NEAR(Split(e, FrameAt(angle)).along, along * along, 1e-15);
    EXPECT_NEAR(Split(e, FrameAt(angle)).across, across * across, 1e-15);
  }
  EXPECT_EQ(Split({3, 4}, {0, 0}).along, 12.5);
  EXPECT_GE(Split({1, 1e-9}, FrameAt(1e-9)).across, 0);
}

TEST(SquaredSine, IsTheSineOfTheAngleBetweenAxes) {
  for (const double d : {0.0, 1e-9, 0.3, 1.0, 1.5, 2.0}) {
    EXPECT_NEAR(SquaredSine(FrameAt(0.7), FrameAt(0.7 + d)), std::sin(d) * std::sin(d), 1e-15);
  }
  EXPECT_NEAR(SquaredSine({1, 0}, {-1, 0}), 1, 0);
}

TEST(ThinAndWideLimit, GrowByTheMetricLengthTimesTheSize) {
  // A step of length l in p's metric may take both sizes up by the factor 1 + growth l.
  Rng rng(1996);
  for (int trial = 0; trial < 1000; ++trial) {
    const AxisSizes p = Draw(rng, 100);
    const Vec2 e = DrawEdge(rng);
    const double length = std::sqrt(SquaredLength(MetricFromSizes(p), e));
    EXPECT_NEAR(ThinLimit(p, e, 0.4) / (p.thin * (1 + 0.4 * length)), 1, 1e-9);
    EXPECT_NEAR(WideLimit(p, e, 0.4) / (p.wide * (1 + 0.4 * length)), 1, 1e-9);
    EXPECT_EQ(ThinLimit(p, e, 0.4), ThinLimit(p, -e, 0.4));
  }
}

TEST(Grow, IsAlwaysMore) {
  EXPECT_GT(Grow(1, 0, 1), 1);
  EXPECT_GT(Grow(1e10, 0.1, 1e-40), 1e10);
  EXPECT_EQ(Grow(1, 0.5, 16), 3);
}

// Goal: the limit is the root of the equation in its comment. Method: insert it.
TEST(RotationLimit, SolvesItsEquation) {
  Rng rng(1996);
  const GradationRates rates = {.growth = 0, .rotation = 0.7};
  int solved = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    const AxisSizes p = Draw(rng, 1000);
    const AxisSizes q = Draw(rng, 1000);
    const Vec2 e = 0.1 * DrawEdge(rng);
    const double limit = RotationLimit(p, q, e, rates);
    EXPECT_EQ(limit, RotationLimit(p, q, -e, rates));
    if (limit <= q.thin) continue;  // The floor, not the root.
    ++solved;
    const double wp = 1 - p.thin / p.wide;
    const double wq = 1 - q.thin / q.wide;
    const double c = wp * p.frame.c + wq * q.frame.c;
    const double s = wp * p.frame.s + wq * q.frame.s;
    const double angle = 0.5 * std::atan2(s, c);
    const double along = e.x * std::cos(angle) + e.y * std::sin(angle);
    const double across = e.y * std::cos(angle) - e.x * std::sin(angle);
    const double thin = 0.5 * (p.thin + q.thin);
    const double length = std::hypot(along / thin, across / limit);
    const double k =
        std::sqrt(SquaredSine(p.frame, q.frame) * (1 / (q.thin * q.thin) - 1 / (q.wide * q.wide)));
    EXPECT_NEAR(k * limit / (0.7 * length), 1, 1e-9) << "trial " << trial;
  }
  EXPECT_GT(solved, 300);
}

TEST(RotationLimit, IsOffWhereNothingTurns) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const AxisSizes p = {0.01, 1, FrameAt(0.3)};
  const AxisSizes turned = {0.01, 1, FrameAt(0.4)};
  const AxisSizes round = {0.5, 0.5, FrameAt(1.2)};
  EXPECT_EQ(RotationLimit(p, p, {0.1, 0.1}, {.growth = 0.4, .rotation = 0.7}), kInfinity);
  EXPECT_EQ(RotationLimit(p, round, {0.1, 0.1}, {.growth = 0.4, .rotation = 0.7}), kInfinity);
  EXPECT_EQ(RotationLimit(p, turned, {0.1, 0.1}, {.growth = 0.4, .rotation = 0}), kInfinity);
  EXPECT_LT(RotationLimit(p, turned, {0.1, 0.1}, {.growth = 0.4, .rotation = 0.7}), 1);
  // Never below growth from the neighbour's thin size over the turn.
  const double floor = 0.01 + 0.4 * std::sqrt(0.02) * std::sin(0.1);
  EXPECT_GE(RotationLimit(p, turned, {0.1, 0.1}, {.growth = 0.4, .rotation = 1e-9}),
            floor * (1 - 1e-12));
}

// Goal: the wide size is the largest with which the new tensor is as fine as the old one
// everywhere. Method: the smallest eigenvalue of the difference is 0 up to rounding.
TEST(WideInFrame, IsTheLargestThatKeepsTheOldOneInside) {
  Rng rng(1996);
  for (int trial = 0; trial < 2000; ++trial) {
    const AxisSizes raw = Draw(rng, 100);
    const AxisFrame frame = FrameAt(rng.Uniform(0, std::numbers::pi));
    const double thin = raw.thin * rng.Uniform(0.1, 0.99);
    const double wide = WideInFrame(raw, frame, thin);
    ASSERT_LE(wide, raw.wide * (1 + 1e-12));
    const Metric difference = MetricFromSizes({thin, wide, frame}) - MetricFromSizes(raw);
    EXPECT_NEAR(EigenvaluesOf(difference).low * (raw.thin * raw.thin), 0, 1e-12);
  }
}

}  // namespace
}  // namespace pliant
