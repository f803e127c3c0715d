#include "core/metric/metric_spec.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <utility>

namespace pliant {
namespace {

constexpr BoundingBox kSpecBox = {{-1, -2}, {3, 4}};

Metric Ask(const MetricSpec& spec, Vec2 p) {
  const auto field = MakeMetricField(spec, kSpecBox);
  EXPECT_TRUE(field.ok()) << field.error().message;
  std::int32_t hint = MetricField::kNoHint;
  return field.value()->At(p, hint);
}

Error Refusal(const MetricSpec& spec) {
  const auto field = MakeMetricField(spec, kSpecBox);
  EXPECT_FALSE(field.ok());
  return field.ok() ? Error{} : field.error();
}

MetricSpec BySize(const std::string& size) { return {.source = SizeMetric{size}}; }

TEST(MakeMetricField, BuildsWhatTheSpecificationDescribes) {
  EXPECT_EQ(Ask({}, {0, 0}), Metric::Isotropic(1));
  EXPECT_EQ(Ask({.source = SizeMetric{"x*t"}, .time = 3}, {2, 0}), Metric::Isotropic(6));
  EXPECT_EQ(Ask({.source = ExpressionMetric{"4", "x", "9"}}, {2, 0}), (Metric{4, 2, 9}));
  BackgroundMetric background;
  background.mesh.points = {{0, 0}, {1, 0}, {0, 1}};
  background.mesh.triangles = {{0, 1, 2}};
  background.tensors.assign(3, Metric{1, 0, 1});
  EXPECT_EQ(Ask({.source = background}, {0.2, 0.2}), (Metric{1, 0, 1}));
  EXPECT_EQ(Ask({.source = background, .bounds = {.size_max = 0.5}}, {9, 9}),
            Metric::Isotropic(0.5));
}

TEST(MakeMetricField, RefusesAnExpressionOnlyIfItWorksAtNoTrialPoint) {
  const Error error = Refusal(BySize("-1"));
  EXPECT_EQ(error.code, ErrorCode::kExpressionValue);
  EXPECT_EQ(error.field, "metric.size");
  EXPECT_EQ(Refusal({.source = ExpressionMetric{"1", "5", "1"}}).code, ErrorCode::kExpressionValue);
  // A formula for a disc has no value at the corners of its box, and that is no mistake.
  const auto disc = MakeMetricField(BySize("sqrt(4 - (x-1)^2 - (y-1)^2)"), kSpecBox);
  ASSERT_TRUE(disc.ok());
  EXPECT_TRUE(disc.value()->status().ok());
  std::int32_t hint = MetricField::kNoHint;
  EXPECT_TRUE(IsPositiveDefinite(disc.value()->At({3, 4}, hint)));
  EXPECT_EQ(disc.value()->status().error().code, ErrorCode::kExpressionValue);
}

TEST(MakeMetricField, PassesOnTheErrorsOfItsParts) {
  EXPECT_EQ(Refusal(BySize("x +")).code, ErrorCode::kExpressionSyntax);
  EXPECT_EQ(Refusal(BySize(std::string(5000, '1'))).code, ErrorCode::kTooLarge);
  EXPECT_EQ(Refusal({.source = BackgroundMetric{}}).code, ErrorCode::kEmpty);
}

TEST(MakeMetricField, ChecksTimeAndBounds) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(Refusal({.time = kNaN}).field, "metric.time");
  EXPECT_EQ(Refusal({.time = kInfinity}).code, ErrorCode::kNotFinite);
  const std::pair<SizeBounds, std::string> cases[] = {
      {{.size_min = -1}, "metric.limits.size_min"},
      {{.size_min = kNaN}, "metric.limits.size_min"},
      {{.size_min = 1e-80}, "metric.limits.size_min"},
      {{.size_max = -1}, "metric.limits.size_max"},
      {{.size_max = kInfinity}, "metric.limits.size_max"},
      {{.size_min = 2, .size_max = 1}, "metric.limits.size_max"},
      {{.anisotropy_max = 0.5}, "metric.limits.anisotropy_max"},
      {{.anisotropy_max = kNaN}, "metric.limits.anisotropy_max"},
  };
  for (const auto& [bounds, field] : cases) {
    const Error error = Refusal({.bounds = bounds});
    EXPECT_EQ(error.code, ErrorCode::kOutOfRange);
    EXPECT_EQ(error.field, field);
  }
  EXPECT_EQ(Ask({.bounds = {.size_min = 2, .size_max = 2, .anisotropy_max = 1}}, {}),
            Metric::Isotropic(2));
}

TEST(MetricSpec, ComparesByContent) {
  EXPECT_EQ(BySize("x"), BySize("x"));
  EXPECT_NE(BySize("x"), BySize("x "));
  EXPECT_NE(MetricSpec{}, (MetricSpec{.time = 1}));
  EXPECT_NE(MetricSpec{}, (MetricSpec{.source = ExpressionMetric{}}));
}

}  // namespace
}  // namespace pliant
