#include "core/delaunay/constrain.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/base/rng.h"
#include "tests/core/delaunay/check_triangulation.h"

namespace pliant {
namespace {

void CheckHull(const HullTriangulation& hull, const std::vector<Vec2>& points) {
  for (std::size_t t = 0; t < hull.triangles.size(); ++t) {
    if (HullTriangulation::IsGhost(hull.triangles[t])) continue;
    ASSERT_NO_FATAL_FAILURE(
        delaunay_test::CheckTriangle(static_cast<std::int32_t>(t), hull.triangles, points));
  }
}

int CountSides(const HullTriangulation& hull, std::int32_t segment) {
  int count = 0;
  for (const auto& triangle : hull.triangles) {
    count += static_cast<int>(std::ranges::count(triangle.segments, segment));
  }
  return count;
}

// Goal: after every single insertion the triangulation is whole, and Delaunay except at segments.
// Method: random segments that do not cross, on lattices (every decision a tie) and random points;
// most cross many edges, and many leave segments hanging into the holes that later ones cut.
TEST(Constrainer, KeepsTheTriangulationConstrainedDelaunay) {
  Rng rng(31);
  for (int trial = 0; trial < 60; ++trial) {
    SCOPED_TRACE(::testing::Message() << "seed 31, trial " << trial);
    Domain domain;
    if (trial % 2 == 0) {
      domain.points = delaunay_test::Lattice(4 + trial / 6).points;
    } else {
      for (int i = 0; i < 3 * trial; ++i) domain.points.push_back({rng.Unit(), rng.Unit()});
    }
    delaunay_test::AddRandomConstraints(domain, 400, rng);
    HullTriangulation hull = DelaunayTriangulation(domain.points);
    const std::size_t count = hull.triangles.size();
    Constrainer constrainer(domain.points, hull);
    for (std::size_t i = 0; i < domain.segments.size(); ++i) {
      const Segment& s = domain.segments[i];
      ASSERT_EQ(constrainer.Insert({static_cast<std::int32_t>(i), s.a, s.b}),
                Constrainer::Outcome::kInserted);
      if (trial < 30) {
        ASSERT_NO_FATAL_FAILURE(CheckHull(hull, domain.points));
      }
    }
    ASSERT_NO_FATAL_FAILURE(CheckHull(hull, domain.points));
    ASSERT_EQ(hull.triangles.size(), count);
    for (std::size_t i = 0; i < domain.segments.size(); ++i) {
      ASSERT_EQ(CountSides(hull, static_cast<std::int32_t>(i)), 2) << "segment " << i;
    }
    for (std::size_t i = 0; i < domain.points.size(); ++i) {
      const auto& at = hull.triangles[AsIndex(hull.triangle_of_point[i])];
      ASSERT_LT(HullTriangulation::CornerAt(at, static_cast<std::int32_t>(i)), 3U);
    }
  }
}

// Goal: what is in the way is noticed at the start, on the way, and along the border of the hull.
TEST(Constrainer, RefusesWhatCrossesASegmentOrAPoint) {
  const std::vector<Vec2> points = delaunay_test::Lattice(5).points;
  HullTriangulation hull = DelaunayTriangulation(points);
  Constrainer constrainer(points, hull);
  const auto at = [](std::int32_t x, std::int32_t y) { return 5 * y + x; };
  using Outcome = Constrainer::Outcome;
  ASSERT_EQ(constrainer.Insert({0, at(1, 0), at(2, 3)}), Outcome::kInserted);
  EXPECT_EQ(constrainer.Insert({1, at(0, 2), at(3, 1)}), Outcome::kBlocked) << "crosses 0";
  EXPECT_EQ(constrainer.Insert({2, at(0, 0), at(2, 2)}), Outcome::kBlocked) << "over (1, 1)";
  EXPECT_EQ(constrainer.Insert({3, at(4, 0), at(0, 0)}), Outcome::kBlocked) << "along the hull";
  EXPECT_EQ(constrainer.Insert({4, at(0, 0), at(4, 0)}), Outcome::kBlocked) << "along the hull";
  EXPECT_EQ(constrainer.Insert({5, at(0, 0), at(4, 2)}), Outcome::kBlocked) << "over (2, 1)";
  EXPECT_EQ(constrainer.Insert({6, at(3, 0), at(3, 1)}), Outcome::kInserted) << "is an edge";
  for (std::int32_t refused : {1, 2, 3, 4, 5}) EXPECT_EQ(CountSides(hull, refused), 0);
  EXPECT_EQ(CountSides(hull, 6), 2);
  CheckHull(hull, points);
}

// Goal: a segment through a strip of many triangles does not take quadratic time or deep recursion.
// Method: 20,000 points on each of two parabolas that curve towards each other.
TEST(Constrainer, CrossesALongStrip) {
  std::vector<Vec2> points = {{0, 0.5}, {1, 0.5}};
  constexpr int kCount = 20000;
  for (int i = 1; i < kCount; ++i) {
    const double x = static_cast<double>(i) / kCount;
    points.push_back({x, 0.25 * x * (1 - x)});
    points.push_back({x, 1 - 0.25 * x * (1 - x)});
  }
  HullTriangulation hull = DelaunayTriangulation(points);
  Constrainer constrainer(points, hull);
  ASSERT_EQ(constrainer.Insert({0, 0, 1}), Constrainer::Outcome::kInserted);
  EXPECT_EQ(CountSides(hull, 0), 2);
  CheckHull(hull, points);
}

}  // namespace
}  // namespace pliant
