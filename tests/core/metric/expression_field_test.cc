#include "core/metric/expression_field.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/rng.h"

namespace pliant {
namespace {

using ::testing::HasSubstr;

constexpr Metric kFallback = {0.25, 0, 0.25};

std::unique_ptr<ExpressionField> Tensor(const ExpressionMetric& metric, const SizeBounds& bounds) {
  auto field = MakeTensorField(metric, {.time = 2, .bounds = bounds, .fallback = kFallback});
  EXPECT_TRUE(field.ok());
  return std::move(field).value();
}

std::unique_ptr<ExpressionField> Size(const std::string& size, const SizeBounds& bounds) {
  auto field = MakeSizeField({size}, {.time = 2, .bounds = bounds, .fallback = kFallback});
  EXPECT_TRUE(field.ok());
  return std::move(field).value();
}

Metric Ask(const MetricField& field, Vec2 p) {
  std::int32_t hint = MetricField::kNoHint;
  return field.At(p, hint);
}

TEST(ExpressionField, EvaluatesTensorsAndSizes) {
  const auto tensor = Tensor({"1 + x^2", "0.5*x*y", "1 + y^2 + t"}, {});
  EXPECT_EQ(Ask(*tensor, {2, 3}), (Metric{5, 3, 12}));
  EXPECT_TRUE(tensor->status().ok());
  const auto size = Size("0.1*t + x", {});
  EXPECT_EQ(Ask(*size, {1, 0}), Metric::Isotropic(0.1 * 2 + 1));
  EXPECT_TRUE(size->status().ok());
}

TEST(ExpressionField, AppliesBounds) {
  const SizeBounds bounds = {.size_min = 0.1, .size_max = 2, .anisotropy_max = 5};
  const auto size = Size("x", bounds);
  EXPECT_EQ(Ask(*size, {0.01, 0}), Metric::Isotropic(0.1));
  EXPECT_EQ(Ask(*size, {0.5, 0}), Metric::Isotropic(0.5));
  EXPECT_EQ(Ask(*size, {50, 0}), Metric::Isotropic(2));
  const auto tensor = Tensor({"1000000", "0", "0.0001"}, bounds);
  const MetricAxes axes = AxesFromMetric(Ask(*tensor, {0, 0}));
  EXPECT_NEAR(axes.minor_radius, 0.1, 1e-12);
  EXPECT_NEAR(axes.major_radius, 0.5, 1e-12);
}

// Goal: the lowest bad point is remembered, whatever the order of questions, and every answer is a
// metric all the same.
TEST(ExpressionField, RemembersTheLowestBadPoint) {
  const auto size = Size("x", {});
  EXPECT_EQ(Ask(*size, {1, 0}), Metric::Isotropic(1));
  EXPECT_TRUE(size->status().ok());
  EXPECT_EQ(Ask(*size, {-0.5, 4}), kFallback);
  EXPECT_EQ(Ask(*size, {-0.5, 3}), kFallback);
  EXPECT_EQ(Ask(*size, {-0.25, 1}), kFallback);
  EXPECT_EQ(Ask(*size, {1, 0}), Metric::Isotropic(1));
  ASSERT_FALSE(size->status().ok());
  const Error error = size->status().error();
  EXPECT_EQ(error.code, ErrorCode::kExpressionValue);
  EXPECT_EQ(error.field, "metric.size");
  EXPECT_THAT(error.message, HasSubstr("the point (-0.5, 3), t = 2, the size is -0.5"));
  size->ClearStatus();
  EXPECT_TRUE(size->status().ok());
}

/// The answers to many points at once, and one by one.
void ExpectTheSameAtOnce(const ExpressionField& field, const std::vector<Vec2>& points) {
  std::vector<Metric> metrics(points.size());
  std::vector<std::int32_t> hints(points.size(), MetricField::kNoHint);
  field.AtEach(points, hints, metrics);
  for (std::size_t i = 0; i < points.size(); ++i) {
    ASSERT_EQ(metrics[i], Ask(field, points[i])) << "point " << i << " of " << points.size();
  }
}

// Goal: who asks for many points at once gets the same bits, with and without a condition in the
// formula, with and without bounds, for blocks that are full and those that are not.
TEST(ExpressionField, AnswersManyPointsAsOne) {
  Rng rng(16);
  for (const std::size_t count : {0U, 1U, 15U, 16U, 17U, 100U}) {
    std::vector<Vec2> points(count);
    for (Vec2& p : points) p = {rng.Uniform(-2, 2), rng.Uniform(-2, 2)};
    for (const SizeBounds& bounds : {SizeBounds{}, SizeBounds{.size_min = 0.2, .size_max = 1}}) {
      ExpectTheSameAtOnce(*Size("0.1 + exp(-x*x)*t", bounds), points);
      ExpectTheSameAtOnce(*Size("x < y ? 0.5 : 1 + y*y", bounds), points);
      ExpectTheSameAtOnce(*Tensor({"1 + x^2", "0.5*x*y", "1 + y^2 + t"}, bounds), points);
      ExpectTheSameAtOnce(*Tensor({"4", "x < 0 ? 0 : 1", "1 + y^2"}, bounds), points);
    }
  }
}

TEST(ExpressionField, RemembersTheLowestBadPointOfManyAtOnce) {
  for (const char* formula : {"x + 2", "x < -5 ? 7 : x + 2"}) {
    const auto size = Size(formula, {});
    std::vector<Vec2> points(40, {1, 0});
    points[3] = {-2, 5};
    points[20] = {-3, 1};
    points[37] = {-3, 2};
    std::vector<Metric> metrics(points.size());
    std::vector<std::int32_t> hints(points.size(), MetricField::kNoHint);
    size->AtEach(points, hints, metrics);
    EXPECT_EQ(metrics[0], Metric::Isotropic(3));
    EXPECT_EQ(metrics[20], kFallback);
    ASSERT_FALSE(size->status().ok());
    EXPECT_THAT(size->status().error().message, HasSubstr("(-3, 1)"));
  }
}

TEST(ExpressionField, RefusesSizesThatAreNone) {
  for (const char* text : {"0", "-1", "0/0*x", "sqrt(-1)", "1/0", "1e-100", "1e100"}) {
    const auto size = Size(text, {});
    EXPECT_EQ(Ask(*size, {1, 1}), kFallback) << text;
    EXPECT_FALSE(size->status().ok()) << text;
  }
  const auto infinite = Size("1/0", {.size_max = 3});
  EXPECT_EQ(Ask(*infinite, {1, 1}), Metric::Isotropic(3));
  EXPECT_TRUE(infinite->status().ok());
  const auto zero = Size("0.05*hypot(x-1, y-1)", {.size_min = 0.01});
  EXPECT_EQ(Ask(*zero, {1, 1}), Metric::Isotropic(0.01));
  EXPECT_TRUE(zero->status().ok());
  const auto negative = Size("-1e-300", {.size_min = 0.01});
  EXPECT_EQ(Ask(*negative, {1, 1}), kFallback);
  EXPECT_FALSE(negative->status().ok());
}

TEST(ExpressionField, AdmitsSemiDefiniteTensorsOnlyWithASizeMax) {
  struct Case {
    ExpressionMetric metric;
    bool without_max;
    bool with_max;
  };
  const Case cases[] = {
      {{"4", "1", "2"}, true, true},
      {{"1", "1", "1"}, false, true},             // eigenvalues 0 and 2
      {{"0", "0", "0"}, false, true},             // no wish in any direction
      {{"1", "1 + 1e-15", "1"}, false, true},     // -1e-15: rounding of 0
      {{"1", "1 + 1e-9", "1"}, false, false},     // truly negative
      {{"1", "2", "1"}, false, false},            // eigenvalues -1 and 3
      {{"-1", "0", "-1"}, false, false},          // negative
      {{"-1e-20", "0", "-1e-20"}, false, false},  // negative, however small
      {{"1/0", "0", "1"}, false, false},          // infinite
      {{"1", "0/0", "1"}, false, false},          // NaN
      {{"1e200", "0", "1"}, false, false},        // beyond what can be squared
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.metric.m11 + "; " + c.metric.m12 + "; " + c.metric.m22);
    const auto without = Tensor(c.metric, {});
    EXPECT_TRUE(IsPositiveDefinite(Ask(*without, {0, 0})));
    EXPECT_EQ(without->status().ok(), c.without_max);
    const auto with = Tensor(c.metric, {.size_max = 10});
    EXPECT_TRUE(IsPositiveDefinite(Ask(*with, {0, 0})));
    EXPECT_EQ(with->status().ok(), c.with_max);
  }
  const auto straight = Tensor({"1", "1", "1"}, {.size_max = 10});
  const MetricAxes axes = AxesFromMetric(Ask(*straight, {0, 0}));
  EXPECT_NEAR(axes.major_radius, 10, 1e-12);
  EXPECT_NEAR(axes.minor_radius, std::sqrt(0.5), 1e-12);
}

TEST(ExpressionField, TellsTheTensorAndItsEigenvalues) {
  const auto field = Tensor({"1", "2", "1"}, {});
  static_cast<void>(Ask(*field, {0.25, 1e-7}));
  const Error error = field->status().error();
  EXPECT_EQ(error.code, ErrorCode::kExpressionValue);
  EXPECT_THAT(error.message, HasSubstr("(0.25, 9.9999999999999995e-08)"));
  EXPECT_THAT(error.message, HasSubstr("m11 = 1, m12 = 2, m22 = 1 with eigenvalues -1 and 3"));
}

TEST(ExpressionField, NamesTheExpressionThatCannotBeParsed) {
  const auto refused = MakeTensorField({"1", "0", "y + "}, {});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kExpressionSyntax);
  EXPECT_EQ(refused.error().field, "metric.m22");
  EXPECT_EQ(refused.error().index, 4);
  EXPECT_EQ(MakeSizeField({"h"}, {}).error().field, "metric.size");
}

}  // namespace
}  // namespace pliant
