#include "core/pliant/refine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/delaunay/import_mesh.h"
#include "core/mesh/mesh_edit.h"
#include "core/mesh/validate.h"
#include "core/metric/function_field.h"
#include "tests/support/cases.h"

namespace pliant {
namespace {

/// The triangulated square with a metric at its corners.
struct Square {
  explicit Square(const MetricField& field) : edit(mesh) {
    const auto plan = PlanDomain(testing::Rectangle({1, 1}, {2, 2}));
    BuildFromPlan(*plan, edit);
    std::int32_t hint = MetricField::kNoHint;
    for (std::int32_t v = 0; v < mesh.vertex_slots(); ++v) {
      edit.SetMetric(VertexId(v), field.At(mesh.position(VertexId(v)), hint));
    }
  }
  Mesh mesh;
  MeshEdit edit;
};

TEST(PlanRefinement, HalvesLongEdgesAndLeavesShortOnesWhole) {
  // The sides have length 1 in the plane: 1.4 and 1.2 in these metrics; the diagonal is longer.
  const Square long_sides(FunctionField([](Vec2) { return Metric::Isotropic(1 / 1.4); }));
  EXPECT_EQ(PlanRefinement(long_sides.mesh, 1).size(), 5U);
  const Square short_sides(FunctionField([](Vec2) { return Metric::Isotropic(1 / 1.2); }));
  const auto splits = PlanRefinement(short_sides.mesh, 1);
  ASSERT_EQ(splits.size(), 1U);
  EXPECT_EQ(splits[0].position, (Vec2{1.5, 1.5}));
}

// Goal: midpoints halve edges in the metric, not in the plane.
// Method: h = c x is the metric of the hyperbolic half plane, where the way between (1, y) and
// (2, y) along a segment of the boundary has its middle at x = sqrt(2), to second order 1.4166.
TEST(PlanRefinement, PutsMidpointsWhereTheMetricHasThem) {
  const Square square(FunctionField([](Vec2 p) { return Metric::Isotropic(0.2 * p.x); }));
  int horizontal_count = 0;
  for (const EdgeSplit& split : PlanRefinement(square.mesh, 1)) {
    const double y = split.position.y;
    if (y != 1 && y != 2) continue;
    ++horizontal_count;
    EXPECT_NEAR(split.position.x, std::sqrt(2.0), 0.03);
    EXPECT_LT(split.position.x, 1.47);
  }
  EXPECT_EQ(horizontal_count, 2);
}

// Goal: whatever the metric, the refined mesh is valid.
// Method: metrics that change by a factor of a million between neighbouring vertices push every
// midpoint to the end of its leash.
TEST(PlanRefinement, WildMetricsGiveValidChildren) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    Rng rng(seed);
    Square square(FunctionField([&](Vec2) {
      const double t = rng.Uniform(0, 3.14);
      return MetricFromAxes({std::pow(10, rng.Uniform(-2, -1)),
                             std::pow(10, rng.Uniform(-5, -2)),
                             {std::cos(t), std::sin(t)}});
    }));
    for (int level = 0; level < 5; ++level) {
      square.edit.Refine(PlanRefinement(square.mesh, 1), TrianglesBySlot(square.mesh));
      for (std::int32_t v = 0; v < square.mesh.vertex_slots(); ++v) {
        const double t = rng.Uniform(0, 3.14);
        square.edit.SetMetric(
            VertexId(v),
            MetricFromAxes({1e-2, std::pow(10, rng.Uniform(-5, -2)), {std::cos(t), std::sin(t)}}));
      }
      ASSERT_EQ(Validate(square.mesh), std::vector<std::string>());
    }
  }
}

// Goal: both orders name every live triangle once, and the curve's steps are short.
TEST(TrianglesAlongCurve, KeepsNeighborsTogether) {
  Square square(FunctionField([](Vec2) { return Metric::Isotropic(1e-3); }));
  for (int level = 0; level < 5; ++level) {
    square.edit.Refine(PlanRefinement(square.mesh, 1), TrianglesBySlot(square.mesh));
    for (std::int32_t v = 0; v < square.mesh.vertex_slots(); ++v) {
      square.edit.SetMetric(VertexId(v), Metric::Isotropic(1e-3));
    }
  }
  const std::vector<TriangleId> curve = TrianglesAlongCurve(square.mesh);
  std::vector<TriangleId> sorted = curve;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(sorted, TrianglesBySlot(square.mesh));
  ASSERT_EQ(curve.size(), 2048U);
  double steps = 0;
  for (std::size_t i = 1; i < curve.size(); ++i) {
    steps += Length(square.mesh.position(square.mesh.triangle(curve[i]).vertices[0]) -
                    square.mesh.position(square.mesh.triangle(curve[i - 1]).vertices[0]));
  }
  EXPECT_LT(steps / 2048, 2.0 / 32);  // The sides of a triangle are 1/32 long.
}

// Goal: an edge is measured in the metric to come.
TEST(PlanRefinement, LooksAheadByTheGrowthOfTheMetric) {
  const Square square(FunctionField([](Vec2) { return Metric::Isotropic(2 / 1.4); }));
  EXPECT_EQ(PlanRefinement(square.mesh, 1).size(), 0U);
  EXPECT_EQ(PlanRefinement(square.mesh, 4).size(), 5U);
}

}  // namespace
}  // namespace pliant
