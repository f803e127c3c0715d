#include "core/delaunay/delaunay.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/base/rng.h"
#include "core/geometry/predicates.h"
#include "tests/core/delaunay/check_triangulation.h"

namespace pliant {
namespace {

using delaunay_test::CornerPoint;

// Checks against the definition: no point strictly inside any circle, no point strictly outside the
// hull, and as many triangles as a triangulation of all points and the ghost has.
void CheckDelaunay(const std::vector<Vec2>& points) {
  const HullTriangulation hull = DelaunayTriangulation(points);
  ASSERT_EQ(hull.triangles.size(), 2 * points.size() - 2);
  for (std::size_t t = 0; t < hull.triangles.size(); ++t) {
    const HullTriangulation::Triangle& triangle = hull.triangles[t];
    const std::size_t ghost = HullTriangulation::CornerAt(triangle, HullTriangulation::kGhost);
    if (ghost == 3) {
      ASSERT_NO_FATAL_FAILURE(
          delaunay_test::CheckTriangle(static_cast<std::int32_t>(t), hull.triangles, points));
    }
    for (Vec2 p : points) {
      if (ghost < 3) {
        ASSERT_LE(Orient2d(CornerPoint(triangle, ghost + 1, points),
                           CornerPoint(triangle, ghost + 2, points), p),
                  0);
      } else {
        ASSERT_LE(InCircle(CornerPoint(triangle, 0, points), CornerPoint(triangle, 1, points),
                           CornerPoint(triangle, 2, points), p),
                  0);
      }
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto& triangle = hull.triangles[AsIndex(hull.triangle_of_point[i])];
    ASSERT_LT(HullTriangulation::CornerAt(triangle, static_cast<std::int32_t>(i)), 3U);
    ASSERT_FALSE(HullTriangulation::IsGhost(triangle));
  }
}

TEST(DelaunayTriangulation, HasEmptyCirclesForRandomPoints) {
  Rng rng(11);
  for (int trial = 0; trial < 40; ++trial) {
    SCOPED_TRACE(::testing::Message() << "seed 11, trial " << trial);
    std::vector<Vec2> points;
    const double flatness = std::ldexp(1, -(trial % 20));
    for (int i = 0; i < 3 + 5 * trial; ++i) points.push_back({rng.Unit(), flatness * rng.Unit()});
    ASSERT_NO_FATAL_FAILURE(CheckDelaunay(points));
  }
}

TEST(DelaunayTriangulation, TakesLatticesAndCircles) {
  for (std::int32_t n : {2, 3, 8, 15}) CheckDelaunay(delaunay_test::Lattice(n).points);
  std::vector<Vec2> circle;
  for (int x = -65; x <= 65; ++x) {
    for (int y = -65; y <= 65; ++y) {
      if (x * x + y * y == 65 * 65) circle.push_back({1.0 * x, 1.0 * y});
    }
  }
  ASSERT_EQ(circle.size(), 36U);
  CheckDelaunay(circle);
}

TEST(DelaunayTriangulation, TakesALineAndOnePointOff) {
  std::vector<Vec2> points = {{3, 1e-300}};
  for (int i = 0; i < 100; ++i) points.push_back({0.1 * ((i * 37) % 100), 0});
  CheckDelaunay(points);
}

// Goal: points within a few ulps of a line and of each other do not confuse it.
TEST(DelaunayTriangulation, TakesClustersOfNearlyCollinearPoints) {
  Rng rng(13);
  std::vector<Vec2> points;
  for (int i = 0; i < 12; ++i) {
    for (int j = 0; j < 12; ++j) {
      points.push_back({0.5 + std::ldexp(i, -53), 0.5 + std::ldexp(j, -53)});
    }
  }
  for (int i = 0; i < 30; ++i) points.push_back(rng.Unit() * Vec2{12, 12});
  CheckDelaunay(points);
}

TEST(DelaunayTriangulation, HasNoTrianglesOnALine) {
  EXPECT_TRUE(DelaunayTriangulation(std::vector<Vec2>{}).triangles.empty());
  EXPECT_TRUE(DelaunayTriangulation(std::vector<Vec2>{{0, 0}, {1, 0}}).triangles.empty());
  EXPECT_TRUE(
      DelaunayTriangulation(std::vector<Vec2>{{0, 0}, {2, 2}, {1, 1}, {7, 7}}).triangles.empty());
}

}  // namespace
}  // namespace pliant
