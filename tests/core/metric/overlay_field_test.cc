#include "core/metric/overlay_field.h"

#include <gtest/gtest.h>

#include <memory>
#include <utility>

#include "core/metric/function_field.h"

namespace pliant {
namespace {

std::shared_ptr<MetricField> Uniform(double size) {
  const auto function = [size](Vec2) { return Metric::Isotropic(size); };
  return std::make_shared<FunctionField<decltype(function)>>(function);
}

/// The square [x, x + 1] x [0, 1] in two triangles, one tensor everywhere.
BackgroundMetric SquareAt(double x, double size) {
  return {{.points = {{x, 0}, {x + 1, 0}, {x + 1, 1}, {x, 1}},
           .triangles = {{0, 1, 2}, {0, 2, 3}},
           .triangle_tags = {},
           .edges = {},
           .edge_tags = {}},
          std::vector<Metric>(4, Metric::Isotropic(size))};
}

double SizeAt(const MetricField& field, Vec2 p) {
  std::int32_t hint = MetricField::kNoHint;
  return AxesFromMetric(field.At(p, hint)).major_radius;
}

TEST(OverlayField, DecidesInsideItsTrianglesAndNowhereElse) {
  const auto field = OverlayField::Lay(Uniform(1), SquareAt(0, 0.5), {});
  ASSERT_TRUE(field.ok()) << field.error().message;
  EXPECT_NEAR(SizeAt(**field, {0.25, 0.5}), 0.5, 1e-14);
  EXPECT_NEAR(SizeAt(**field, {1, 1}), 0.5, 1e-14);
  EXPECT_EQ(SizeAt(**field, {1.01, 0.5}), 1);
  EXPECT_EQ(SizeAt(**field, {0.5, -0.01}), 1);
}

// Goal: a vertex that slid along a segment, and so lies off it by rounding, is still inside.
TEST(OverlayField, RoundingAtTheRimCountsAsInside) {
  const auto field = OverlayField::Lay(Uniform(1), SquareAt(0, 0.5), {});
  EXPECT_NEAR(SizeAt(**field, {0.5, -1e-15}), 0.5, 1e-9);
  EXPECT_NEAR(SizeAt(**field, {1 + 1e-15, 0.5}), 0.5, 1e-9);
  EXPECT_EQ(SizeAt(**field, {0.5, -1e-7}), 1);
}

TEST(OverlayField, TheTopmostLayerWinsAndOlderFieldsStay) {
  const auto lower = OverlayField::Lay(Uniform(1), SquareAt(0, 0.5), {}).value();
  const auto upper = OverlayField::Lay(lower, SquareAt(0.5, 0.25), {}).value();
  EXPECT_NEAR(SizeAt(*upper, {0.25, 0.5}), 0.5, 1e-14);
  EXPECT_NEAR(SizeAt(*upper, {0.75, 0.5}), 0.25, 1e-14);
  EXPECT_NEAR(SizeAt(*lower, {0.75, 0.5}), 0.5, 1e-14);
  EXPECT_EQ(upper->layer_count(), 2U);
  EXPECT_EQ(upper->triangle_count(), 4U);
  EXPECT_EQ(lower->layer_count(), 1U);
}

TEST(OverlayField, RefusesWhatABackgroundFieldRefuses) {
  BackgroundMetric bad = SquareAt(0, 0.5);
  bad.tensors[2] = {1, 2, 1};
  const auto field = OverlayField::Lay(Uniform(1), bad, {});
  ASSERT_FALSE(field.ok());
  EXPECT_EQ(field.error().code, ErrorCode::kNotPositiveDefinite);
  EXPECT_EQ(field.error().index, 2);
}

}  // namespace
}  // namespace pliant
