#include "core/pliant/retriangulate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/base/rng.h"
#include "core/geometry/predicates.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

/// A mesh whose vertices 0, 1, ... are the corners of a simple polygon.
std::unique_ptr<testing::EditedMesh> PolygonMesh(const std::vector<Vec2>& corners) {
  Domain domain;
  domain.points = corners;
  const auto n = static_cast<std::int32_t>(corners.size());
  for (std::int32_t i = 0; i < n; ++i) domain.segments.push_back({i, (i + 1) % n, 0});
  return testing::DomainMesh(domain);
}

std::vector<VertexId> Ids(std::size_t count) {
  std::vector<VertexId> ids;
  for (std::size_t i = 0; i < count; ++i) ids.push_back(VertexId::FromIndex(i));
  return ids;
}

/// A polygon around the origin: simple, and as jagged as its radii.
std::vector<Vec2> StarShaped(Rng& rng, int n) {
  std::vector<double> angles;
  for (int i = 0; i < n; ++i) angles.push_back(6.28 * (i + rng.Uniform(0.1, 0.9)) / n);
  std::vector<Vec2> corners;
  for (const double angle : angles) {
    const double r = rng.Below(3) == 0 ? rng.Uniform(0.01, 0.1) : rng.Uniform(0.5, 1);
    corners.push_back({r * std::cos(angle), r * std::sin(angle)});
  }
  return corners;
}

// Goal: any simple polygon is covered exactly, by positive triangles. Method: random star-shaped
// ones in random metrics; the area as an integral along the outline.
TEST(CutEars, CoversRandomSimplePolygons) {
  Rng rng(4);
  for (int trial = 0; trial < 500; ++trial) {
    const int n = static_cast<int>(4 + rng.Below(20));
    const std::vector<Vec2> corners = StarShaped(rng, n);
    double area = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      area += 0.5 * Cross(corners[i], corners[(i + 1) % corners.size()]);
    }
    const auto made = PolygonMesh(corners);
    const Metric metric{rng.Uniform(1, 50), rng.Uniform(-1, 1), rng.Uniform(1, 2)};
    const auto triangles = CutEars(made->mesh, Ids(corners.size()), metric, 17);
    ASSERT_TRUE(triangles.has_value()) << "trial " << trial;
    ASSERT_EQ(triangles->size(), corners.size() - 2);
    double sum = 0;
    for (const NewTriangle& triangle : *triangles) {
      const auto& [a, b, c] = triangle.vertices;
      const Vec2 p = corners[a.index()];
      EXPECT_GT(Orient2d(p, corners[b.index()], corners[c.index()]), 0);
      EXPECT_EQ(triangle.region, 17);
      sum += 0.5 * Cross(corners[b.index()] - p, corners[c.index()] - p);
    }
    EXPECT_NEAR(sum, area, 1e-13) << "trial " << trial;
  }
}

// Goal: the cost of a deletion is bounded: a polygon of 250 corners is cut, one of 251 is refused.
TEST(CutEars, RefusesPolygonsOfManyCorners) {
  for (const std::size_t n : {250U, 251U}) {
    std::vector<Vec2> corners;
    for (std::size_t i = 0; i < n; ++i) {
      const double angle = 6.28 * static_cast<double>(i) / static_cast<double>(n);
      corners.push_back({std::cos(angle), std::sin(angle)});
    }
    const auto made = PolygonMesh(corners);
    EXPECT_EQ(CutEars(made->mesh, Ids(n), Metric::Isotropic(1), 0).has_value(), n == 250);
  }
}

TEST(CutEars, CutsTheBestShapedEarInTheMetricFirst) {
  const std::vector<Vec2> square{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const auto made = PolygonMesh(square);
  const auto diagonal = [&](const Metric& metric) {
    const auto triangles = CutEars(made->mesh, Ids(4), metric, 0);
    // The first triangle's tip is what the diagonal leaves out.
    return (*triangles)[0].vertices[1].value() % 2;
  };
  // Long axis along (1, 1): the diagonal 0 2 is short there, so 1 or 3 is the tip.
  EXPECT_EQ(diagonal({10, -9, 10}), 1);
  EXPECT_EQ(diagonal({10, 9, 10}), 0);
}

TEST(CutEars, RefusesWhatIsNotSimpleOrNotPositive) {
  const auto made = PolygonMesh({{0, 0}, {2, 0}, {2, 2}, {0, 2}, {0, 1}});
  const auto id = [](int i) { return VertexId(i); };
  const Metric unit;
  const std::vector<VertexId> clockwise{id(3), id(2), id(1), id(0)};
  EXPECT_FALSE(CutEars(made->mesh, clockwise, unit, 0).has_value());
  const std::vector<VertexId> flat{id(0), id(4), id(3)};
  EXPECT_FALSE(CutEars(made->mesh, flat, unit, 0).has_value());
  const std::vector<VertexId> bowtie{id(0), id(2), id(1), id(3)};
  EXPECT_FALSE(CutEars(made->mesh, bowtie, unit, 0).has_value());
}

}  // namespace
}  // namespace pliant
