#include "core/pliant/insert.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "core/metric/function_field.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::Faults;
using testing::GridData;
using testing::ImportedMesh;

/// A metric that tells where it was asked for.
auto PlaceField() {
  return FunctionField([](Vec2 p) { return Metric{1 + p.x, 0, 1 + p.y}; });
}

std::optional<Insertion> InsertBetween(testing::EditedMesh& made, VertexId center, VertexId end,
                                       AfterInsertion after = AfterInsertion::kLeaveEdges) {
  MetricFlipper flipper(made.edit);
  Star star;
  star.Gather(made.mesh, center);
  const auto spoke = std::find(star.ring().begin(), star.ring().end(), end) - star.ring().begin();
  return InsertOnSpoke(made.edit, flipper, PlaceField(), star, static_cast<std::size_t>(spoke),
                       after);
}

TEST(InsertOnSpoke, SplitsEverySpokeOfAStarInTheMiddle) {
  for (const VertexId center : {VertexId(4), VertexId(1), VertexId(0), VertexId(2)}) {
    const auto probe = ImportedMesh(GridData(2, 2));
    Star star;
    star.Gather(probe->mesh, center);
    for (const VertexId end : star.ring()) {
      const auto made = ImportedMesh(GridData(2, 2));
      const bool boundary = made->mesh.FindEdge(center, end).valid();
      const auto insertion = InsertBetween(*made, center, end);
      ASSERT_TRUE(insertion.has_value());
      EXPECT_EQ(Faults(made->mesh), "");
      const Vec2 expected = 0.5 * (probe->mesh.position(center) + probe->mesh.position(end));
      EXPECT_EQ(made->mesh.position(insertion->vertex), expected);
      EXPECT_EQ(made->mesh.metric(insertion->vertex).m11, 1 + expected.x);
      EXPECT_EQ(made->mesh.metric(insertion->vertex).m22, 1 + expected.y);
      EXPECT_EQ(insertion->swaps, 0);
      EXPECT_EQ(made->mesh.triangle_count(), boundary ? 9 : 10);
      EXPECT_EQ(made->mesh.vertex(insertion->vertex).edge.valid(), boundary);
      EXPECT_FALSE(made->mesh.vertex(insertion->vertex).fixed);
    }
  }
}

TEST(InsertOnSpoke, HalvesTheParametersOfAConstrainedEdge) {
  const auto made = ImportedMesh(GridData(4, 1));
  const auto insertion = InsertBetween(*made, VertexId(1), VertexId(2));
  ASSERT_TRUE(insertion.has_value());
  const auto [before, after] = made->mesh.SegmentEdges(insertion->vertex);
  EXPECT_EQ(made->mesh.edge(before).parameters[1], 0.375);
  EXPECT_EQ(made->mesh.edge(after).parameters[0], 0.375);
  EXPECT_EQ(made->mesh.position(insertion->vertex), (Vec2{1.5, 0}));
}

TEST(InsertOnSpoke, SwapsEdgesAroundTheNewVertexIfAsked) {
  MeshData data;  // A flat kite: the new vertex wants an edge to the far right.
  data.points = {{0, -1}, {4, 0}, {0, 1}, {-1, 0}, {0.5, 3}};
  data.triangles = {{0, 1, 2}, {0, 2, 3}, {2, 1, 4}};
  const auto made = ImportedMesh(data);
  const auto insertion = InsertBetween(*made, VertexId(2), VertexId(1), AfterInsertion::kSwapEdges);
  ASSERT_TRUE(insertion.has_value());
  EXPECT_EQ(Faults(made->mesh), "");
}

TEST(InsertOnSpoke, RefusesWhereRoundingLeavesNoRoom) {
  MeshData data;
  const double next = std::nextafter(1.0, 2.0);
  data.points = {{1, 0}, {next, 0}, {1, 1}, {1, -1}};
  data.triangles = {{0, 1, 2}, {0, 3, 1}};
  const auto made = ImportedMesh(data);
  const Mesh before = made->mesh;
  EXPECT_FALSE(InsertBetween(*made, VertexId(0), VertexId(1)).has_value());
  EXPECT_EQ(testing::DifferenceOf(made->mesh, before), "");
}

}  // namespace
}  // namespace pliant
