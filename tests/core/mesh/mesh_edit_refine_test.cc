#include <gtest/gtest.h>

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "core/base/rng.h"
#include "core/delaunay/import_mesh.h"
#include "core/mesh/mesh_edit.h"
#include "core/mesh/validate.h"
#include "tests/support/cases.h"

namespace pliant {
namespace {

/// A square with a hole that touches its side, an internal constraint and two regions.
Domain TrickyDomain() {
  Domain domain = testing::Rectangle({0, 0}, {4, 4});
  domain.points.insert(domain.points.end(), {{2, 0.5}, {1, 2}, {2, 3}, {3, 2}, {0.5, 3.5}});
  // The hole's lowest point lies inside; the constraint leads from it to a corner.
  domain.segments.insert(domain.segments.end(),
                         {{4, 5, 10}, {5, 6, 10}, {6, 7, 10}, {7, 4, 10}, {3, 5, 20}});
  domain.holes = {{2, 2}};
  return domain;
}

std::vector<TriangleId> LiveTriangles(const Mesh& mesh) {
  std::vector<TriangleId> triangles;
  for (std::int32_t t = 0; t < mesh.triangle_slots(); ++t) {
    if (mesh.triangle(TriangleId(t)).live) triangles.emplace_back(t);
  }
  return triangles;
}

/// Of the fixed vertices, in order of slot.
std::vector<Vec2> FixedPositions(const Mesh& mesh) {
  std::vector<Vec2> positions;
  for (std::int32_t v = 0; v < mesh.vertex_slots() && mesh.vertex(VertexId(v)).fixed; ++v) {
    positions.push_back(mesh.position(VertexId(v)));
  }
  return positions;
}

/// Splits at the straight middles of the edges for which `wanted` says so, lower triangle first.
template <class Wanted>
std::vector<EdgeSplit> MiddleSplits(const Mesh& mesh, Wanted wanted) {
  std::vector<EdgeSplit> splits;
  for (std::int32_t t = 0; t < mesh.triangle_slots(); ++t) {
    const TriangleRecord& triangle = mesh.triangle(TriangleId(t));
    if (!triangle.live) continue;
    for (int side = 0; side < 3; ++side) {
      const TriangleId beyond = triangle.neighbors[static_cast<std::size_t>(side)];
      if (beyond.valid() && beyond.value() < t) continue;
      if (!wanted()) continue;
      const VertexId a = triangle.vertices[static_cast<std::size_t>(NextCorner(side))];
      const VertexId b = triangle.vertices[static_cast<std::size_t>(PreviousCorner(side))];
      EdgeSplit split{{TriangleId(t), side}, 0.5 * (mesh.position(a) + mesh.position(b)), 0};
      if (triangle.IsConstrained(side)) {
        const EdgeRecord& edge = mesh.edge(mesh.FindEdge(a, b));
        split.t = 0.5 * (edge.parameters[0] + edge.parameters[1]);
        split.position = mesh.PointOnSegment(edge.segment, split.t);
      }
      splits.push_back(split);
    }
  }
  return splits;
}

// Goal: every template, alone and beside every other, leaves a consistent mesh of the same area
// with the expected number of triangles.
// Method: random subsets of the edges of a domain with a hole and an internal constraint, twice in
// a row, triangles in random order; Validate knows nothing of templates. A triangle with k split
// sides becomes k + 1.
TEST(Refine, RandomSubsetsOfEdgesLeaveAValidMesh) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    Rng rng(seed);
    const auto plan = PlanDomain(TrickyDomain());
    ASSERT_TRUE(plan.ok()) << plan.error().message;
    Mesh mesh;
    MeshEdit edit(mesh);
    BuildFromPlan(*plan, edit);
    for (int round = 0; round < 2; ++round) {
      const double area = Area(mesh);
      std::int32_t expected = mesh.triangle_count();
      const auto splits = MiddleSplits(mesh, [&] { return rng.Unit() < 0.4; });
      for (const EdgeSplit& split : splits) {
        const auto& record = mesh.triangle(split.side.triangle);
        expected += record.neighbors[static_cast<std::size_t>(split.side.corner)].valid() ? 2 : 1;
      }
      const std::int32_t vertex_count = mesh.vertex_count();
      std::vector<TriangleId> order = LiveTriangles(mesh);
      for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[rng.Below(i)]);
      const std::vector<Vec2> given = FixedPositions(mesh);
      edit.Refine(splits, order);
      ASSERT_EQ(Validate(mesh), std::vector<std::string>());
      EXPECT_EQ(mesh.triangle_count(), expected);
      EXPECT_EQ(mesh.vertex_count(), vertex_count + static_cast<std::int32_t>(splits.size()));
      EXPECT_NEAR(Area(mesh), area, 1e-12);
      EXPECT_EQ(FixedPositions(mesh), given);
    }
  }
}

TEST(Refine, AllEdgesMakeFourOfEveryTriangle) {
  const auto plan = PlanDomain(TrickyDomain());
  Mesh mesh;
  MeshEdit edit(mesh);
  BuildFromPlan(*plan, edit);
  const std::int32_t triangle_count = mesh.triangle_count();
  const std::int32_t edge_count = mesh.edge_count();
  edit.Refine(MiddleSplits(mesh, [] { return true; }), LiveTriangles(mesh));
  ASSERT_EQ(Validate(mesh), std::vector<std::string>());
  EXPECT_EQ(mesh.triangle_count(), 4 * triangle_count);
  EXPECT_EQ(mesh.edge_count(), 2 * edge_count);
}

// Goal: slots of deleted elements are no obstacle, and are gone afterwards.
TEST(Refine, DropsDeadSlots) {
  const auto plan = PlanDomain(testing::Rectangle({0, 0}, {1, 1}));
  Mesh mesh;
  MeshEdit edit(mesh);
  BuildFromPlan(*plan, edit);
  const VertexId middle = edit.SplitEdge({TriangleId(0), 0}, {0.5, 0.5}, 0);
  ASSERT_EQ(mesh.triangle_count(), 4);
  std::vector<TriangleId> cavity = LiveTriangles(mesh);
  edit.ReplaceCavity(cavity, std::array{NewTriangle{{VertexId(0), VertexId(1), VertexId(2)}, 0},
                                        NewTriangle{{VertexId(0), VertexId(2), VertexId(3)}, 0}});
  edit.RemoveVertex(middle);
  ASSERT_EQ(mesh.triangle_slots(), 4);
  edit.Refine(MiddleSplits(mesh, [] { return true; }), LiveTriangles(mesh));
  ASSERT_EQ(Validate(mesh), std::vector<std::string>());
  EXPECT_EQ(mesh.triangle_slots(), 8);
  EXPECT_EQ(mesh.vertex_slots(), 9);
}

}  // namespace
}  // namespace pliant
