#include "core/metric/grid_metric.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "core/base/rng.h"
#include "core/metric/metric_field.h"

namespace pliant {
namespace {

GridMetric Example() {
  GridMetric grid{.origin = {-1, 2}, .step = {0.5, 0.25}, .column_count = 4, .tensors = {}};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      grid.tensors.push_back(Exp({0.3 * column - 0.2 * row, 0.1 * row, 0.4 * column}));
    }
  }
  return grid;
}

// Goal: the logarithm of the metric is linear in each cell and continuous; here it is linear all
// over, and outside it is that of the nearest point.
TEST(GridMetric, InterpolatesLogarithmsAndHoldsThemOutside) {
  Result<BackgroundMetric> background = ToBackground(Example());
  ASSERT_TRUE(background.ok());
  const auto field = MakeMetricField({.source = std::move(*background)}, {{-1, 2}, {0.5, 2.5}});
  ASSERT_TRUE(field.ok());
  Rng rng(7);
  for (int i = 0; i < 1000; ++i) {
    const Vec2 p{rng.Uniform(-1.5, 1), rng.Uniform(1.5, 3)};
    const double column = std::clamp((p.x + 1) / 0.5, 0.0, 3.0);
    const double row = std::clamp((p.y - 2) / 0.25, 0.0, 2.0);
    const Metric expected = Exp({0.3 * column - 0.2 * row, 0.1 * row, 0.4 * column});
    std::int32_t hint = MetricField::kNoHint;
    const Metric metric = (*field)->At(p, hint);
    EXPECT_NEAR(metric.m11, expected.m11, 1e-12 * expected.m11) << p.x << " " << p.y;
    EXPECT_NEAR(metric.m12, expected.m12, 1e-12 * expected.m22) << p.x << " " << p.y;
    EXPECT_NEAR(metric.m22, expected.m22, 1e-12 * expected.m22) << p.x << " " << p.y;
  }
}

TEST(GridMetric, RefusesWhatIsNoGrid) {
  const double inf = std::numeric_limits<double>::infinity();
  const auto expect = [](auto change, ErrorCode code, const std::string& field) {
    GridMetric grid = Example();
    change(grid);
    const auto refused = ToBackground(std::move(grid));
    ASSERT_FALSE(refused.ok()) << field;
    EXPECT_EQ(refused.error().code, code) << refused.error().message;
    EXPECT_EQ(refused.error().field, "metric.grid." + field);
  };
  expect([&](GridMetric& g) { g.origin.x = inf; }, ErrorCode::kNotFinite, "origin_x");
  expect([&](GridMetric& g) { g.step.y = std::nan(""); }, ErrorCode::kNotFinite, "step_y");
  expect([](GridMetric& g) { g.step.x = 0; }, ErrorCode::kOutOfRange, "step_x");
  expect([](GridMetric& g) { g.step.x = 1e-30; }, ErrorCode::kOutOfRange, "step_x");
  expect([](GridMetric& g) { g.step.y = 1e308; }, ErrorCode::kOutOfRange, "step_y");
  expect([](GridMetric& g) { g.column_count = 1; }, ErrorCode::kOutOfRange, "column_count");
  expect([](GridMetric& g) { g.column_count = 5; }, ErrorCode::kArrayLength, "tensors");
  expect([](GridMetric& g) { g.column_count = 12; }, ErrorCode::kArrayLength, "tensors");
  expect([](GridMetric& g) { g.tensors.clear(); }, ErrorCode::kArrayLength, "tensors");
}

}  // namespace
}  // namespace pliant
