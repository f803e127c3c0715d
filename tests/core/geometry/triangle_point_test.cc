#include "core/geometry/triangle_point.h"

#include <gtest/gtest.h>

#include "core/base/rng.h"

namespace pliant {
namespace {

constexpr std::array<Vec2, 3> kCorners = {{{0, 0}, {4, 0}, {0, 2}}};

Vec2 PointAt(const std::array<double, 3>& weights) {
  return weights[0] * kCorners[0] + weights[1] * kCorners[1] + weights[2] * kCorners[2];
}

TEST(TrianglePoint, FindsTheNearestPointOfASide) {
  EXPECT_EQ(NearestOnSide(kCorners, 2, {1, -3}).weights, (std::array<double, 3>{0.75, 0.25, 0}));
  EXPECT_EQ(NearestOnSide(kCorners, 2, {1, -3}).squared_distance, 9);
  EXPECT_EQ(NearestOnSide(kCorners, 2, {9, 1}).weights, (std::array<double, 3>{0, 1, 0}));
}

// Goal: no point of the boundary is nearer. Method: sample it.
TEST(TrianglePoint, FindsTheNearestPointOfTheBoundary) {
  Rng rng(1);
  for (int trial = 0; trial < 100; ++trial) {
    const Vec2 p = {rng.Uniform(-2, 6), rng.Uniform(-2, 4)};
    const BoundaryPoint nearest = NearestOnBoundary(kCorners, p);
    const Vec2 at = PointAt(nearest.weights);
    EXPECT_NEAR(Dot(p - at, p - at), nearest.squared_distance, 1e-12);
    for (std::size_t i = 0; i < 3; ++i) {
      for (int k = 0; k <= 100; ++k) {
        const Vec2 sample = kCorners[i] + (k / 100.0) * (kCorners[(i + 1) % 3] - kCorners[i]);
        EXPECT_GE(Dot(p - sample, p - sample), nearest.squared_distance - 1e-12);
      }
    }
  }
}

TEST(TrianglePoint, KnowsInsideOutsideAndBorder) {
  EXPECT_EQ(SideSigns(kCorners, {1, 0.5}), (std::array<int, 3>{1, 1, 1}));
  EXPECT_EQ(SideSigns(kCorners, {1, 0}), (std::array<int, 3>{1, 1, 0}));
  EXPECT_EQ(SideSigns(kCorners, {1, -1}), (std::array<int, 3>{1, 1, -1}));
  EXPECT_TRUE(Contains(kCorners, {2, 1}));
  EXPECT_FALSE(Contains(kCorners, {2, 1.0000001}));
}

TEST(TrianglePoint, WeighsItsCornersSoThatTheirMeanIsThePoint) {
  Rng rng(2);
  for (int trial = 0; trial < 100; ++trial) {
    const double u = rng.Uniform(0, 1);
    const double v = rng.Uniform(0, 1 - u);
    const Vec2 p = {4 * u, 2 * v};
    const auto weights = InteriorWeights(kCorners, p, SideSigns(kCorners, p));
    EXPECT_LT(Length(PointAt(weights) - p), 1e-14);
  }
  const auto on_side = InteriorWeights(kCorners, {3, 0}, SideSigns(kCorners, {3, 0}));
  EXPECT_EQ(on_side[2], 0) << "exactly, so that both triangles at a side agree";
}

}  // namespace
}  // namespace pliant
