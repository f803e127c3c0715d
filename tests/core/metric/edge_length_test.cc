#include "core/metric/edge_length.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "core/base/rng.h"
#include "core/metric/function_field.h"

namespace pliant {
namespace {

/// The integral of sqrt(e' M e) over pq by the midpoint rule.
double MidpointLength(const MetricField& field, Vec2 p, Vec2 q, int step_count) {
  const Vec2 e = q - p;
  std::int32_t hint = MetricField::kNoHint;
  double sum = 0;
  for (int i = 0; i < step_count; ++i) {
    sum += std::sqrt(SquaredLength(field.At(p + ((i + 0.5) / step_count) * e, hint), e));
  }
  return sum / step_count;
}

Metric Turning(Vec2 p) {
  const double t = p.x + 0.5 * p.y;
  const double r = 0.3 * std::exp(p.y);
  return MetricFromAxes({r, 0.2 * r, {std::cos(t), std::sin(t)}});
}

// Goal: to ask for the points of many segments together changes no bit.
TEST(IntegratedLength, IsThatOfItsPoints) {
  const FunctionField field(Turning);
  Rng rng(5);
  for (int trial = 0; trial < 100; ++trial) {
    const Vec2 p = {rng.Uniform(-1, 1), rng.Uniform(-1, 1)};
    const Vec2 q = {rng.Uniform(-1, 1), rng.Uniform(-1, 1)};
    std::array<Metric, kIntegrationPointCount> metrics;
    std::ranges::transform(IntegrationPoints(p, q), metrics.begin(), Turning);
    std::int32_t hint = MetricField::kNoHint;
    EXPECT_EQ(IntegratedLength(q - p, metrics), IntegratedLength(field, p, q, hint));
  }
}

// Goal: the quadrature integrates the field, not something near it.
// Method: 20,000 midpoints along random segments of about the length a mesh would have.
TEST(IntegratedLength, EqualsTheIntegral) {
  const FunctionField field(Turning);
  Rng rng(1996);
  for (int trial = 0; trial < 100; ++trial) {
    const Vec2 p = {rng.Uniform(-1, 1), rng.Uniform(-1, 1)};
    const Vec2 q = p + Vec2{rng.Uniform(-0.2, 0.2), rng.Uniform(-0.2, 0.2)};
    std::int32_t hint = MetricField::kNoHint;
    const double length = IntegratedLength(field, p, q, hint);
    EXPECT_NEAR(length / MidpointLength(field, p, q, 20000), 1, 1e-6) << "trial " << trial;
    EXPECT_NEAR(IntegratedLength(field, q, p, hint) / length, 1, 1e-15);
  }
}

TEST(IntegratedLength, IsExactForAPolynomialOfDegreeNine) {
  // sqrt(e' M e) = 1 + x^9 along the x axis; the integral over [0, 1] is 1.1.
  const FunctionField field([](Vec2 p) {
    double power = p.x * p.x * p.x;
    power = 1 + power * power * power;
    return Metric{power * power, 0, 1};
  });
  std::int32_t hint = MetricField::kNoHint;
  EXPECT_NEAR(IntegratedLength(field, {0, 0}, {1, 0}, hint), 1.1, 1e-15);
}

TEST(IntegratedLength, ForwardsTheHint) {
  class Counting final : public MetricField {
   public:
    Metric At(Vec2, std::int32_t& hint) const override {
      ++hint;
      return {};
    }
  };
  std::int32_t hint = 10;
  EXPECT_NEAR(IntegratedLength(Counting(), {0, 0}, {3, 4}, hint), 5, 1e-15);
  EXPECT_EQ(hint, 15);
}

// Goal: the closed form is the integral it stands for, for sizes up to six decades apart, to the
// promised 1e-14. Method: the same formula in long double, away from equal ends; the series against
// the midpoint rule close to them.
TEST(GeometricLength, IsTheLogarithmicMean) {
  Rng rng(1996);
  for (int trial = 0; trial < 2000; ++trial) {
    const double hp = std::pow(10, rng.Uniform(-3, 3));
    const double hq = trial % 2 == 0 ? hp * rng.Uniform(0.5, 2) : std::pow(10, rng.Uniform(-3, 3));
    SCOPED_TRACE(::testing::Message() << "trial " << trial << " hp=" << hp << " hq=" << hq);
    const Metric mp = Metric::Isotropic(hp);
    const Metric mq = Metric::Isotropic(hq);
    const long double lp = 5 * std::sqrt(static_cast<long double>(mp.m11));
    const long double lq = 5 * std::sqrt(static_cast<long double>(mq.m11));
    const double length = GeometricLength({0, 0}, mp, {3, 4}, mq);
    if (std::abs(lp / lq - 1) > 1e-3) {
      const long double expected = (lp - lq) / std::log(lp / lq);
      EXPECT_NEAR(static_cast<double>(length / expected), 1, 1e-14);
    }
    EXPECT_EQ(length, GeometricLength({3, 4}, mq, {0, 0}, mp));
  }
}

TEST(GeometricLength, NeedsNoSpecialCaseForEqualEnds) {
  const Metric m = {2, 0.5, 1};
  const double exact = std::sqrt(SquaredLength(m, {1, 2}));
  EXPECT_DOUBLE_EQ(GeometricLength({1, 1}, m, {2, 3}, m), exact);
  for (const double d : {1e-15, 1e-10, 1e-6}) {
    // The logarithmic mean of l and l (1 + u) is l (1 + u/2 - u^2/12 + ...), u = sqrt(1 + d) - 1.
    const double u = std::sqrt(1 + d) - 1;
    EXPECT_NEAR(GeometricLength({1, 1}, m, {2, 3}, (1 + d) * m) / exact, 1 + u / 2, 1e-12);
  }
  EXPECT_EQ(GeometricLength({1, 1}, m, {1, 1}, m), 0);
}

}  // namespace
}  // namespace pliant
