#include "core/pliant/remove.h"

#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <vector>

#include "core/base/rng.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::Faults;
using testing::GridData;
using testing::ImportedMesh;

std::optional<std::int32_t> RemoveAt(testing::EditedMesh& made, VertexId id) {
  MetricFlipper flipper(made.edit);
  Star star;
  star.Gather(made.mesh, id);
  return RemoveNode(made.edit, flipper, star);
}

TEST(RemoveNode, OfTheInteriorLeavesTwoTrianglesFewer) {
  const auto made = ImportedMesh(GridData(3, 3));
  ASSERT_TRUE(RemoveAt(*made, VertexId(5)).has_value());
  EXPECT_EQ(Faults(made->mesh), "");
  EXPECT_FALSE(made->mesh.IsLive(VertexId(5)));
  EXPECT_EQ(made->mesh.triangle_count(), 16);
  EXPECT_EQ(testing::RegionAreas(made->mesh).at(0), 9);
}

TEST(RemoveNode, OfTheBoundaryMergesItsEdges) {
  const auto made = ImportedMesh(GridData(3, 3));
  ASSERT_TRUE(RemoveAt(*made, VertexId(1)).has_value());
  EXPECT_EQ(Faults(made->mesh), "");
  const EdgeId merged = made->mesh.FindEdge(VertexId(0), VertexId(2));
  ASSERT_TRUE(merged.valid());
  EXPECT_EQ(made->mesh.edge(merged).parameters[0], 0);
  EXPECT_DOUBLE_EQ(made->mesh.edge(merged).parameters[1], 2.0 / 3);
  EXPECT_EQ(made->mesh.edge_count(), 11);
  EXPECT_EQ(testing::RegionAreas(made->mesh).at(0), 9);
}

TEST(RemoveNode, BetweenTwoRegionsKeepsBoth) {
  MeshData data = GridData(4, 4);
  for (std::size_t t = 0; t < 32; ++t) data.triangle_tags.push_back(t < 16 ? 1 : 2);
  data.edges = {{10, 11}, {11, 12}, {12, 13}, {13, 14}};
  data.edge_tags = {6, 6, 6, 6};
  const auto made = ImportedMesh(data);
  for (const int v : {12, 11, 13}) {
    ASSERT_TRUE(RemoveAt(*made, VertexId(v)).has_value()) << v;
    EXPECT_EQ(Faults(made->mesh), "");
    EXPECT_EQ(testing::RegionAreas(made->mesh), (std::map<std::int32_t, double>{{1, 8}, {2, 8}}));
    EXPECT_EQ(testing::TagLengths(made->mesh).at(6), 4);
  }
  EXPECT_TRUE(made->mesh.FindEdge(VertexId(10), VertexId(14)).valid());
}

// Straight only up to rounding: without its middle vertex the boundary would lose a flat triangle.
TEST(RemoveNode, RefusesWhereNothingWouldBeLeftToTriangulate) {
  MeshData data;
  data.points = {{0, 0}, {1, 0}, {0.5, 1e-13}, {0.5, -1}};
  data.triangles = {{0, 1, 2}, {0, 3, 1}};
  const auto made = ImportedMesh(data);
  ASSERT_FALSE(made->mesh.vertex(VertexId(2)).fixed);
  const Mesh before = made->mesh;
  EXPECT_FALSE(RemoveAt(*made, VertexId(2)).has_value());
  EXPECT_EQ(testing::DifferenceOf(made->mesh, before), "");
}

TEST(RemoveNode, EmptiesARandomMeshOfAllItsFreeNodes) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto made = ImportedMesh(GridData(6, 6));
    testing::RandomEditor editor(*made, seed);
    for (int i = 0; i < 300; ++i) editor.Step();
    Rng rng(seed);
    for (;;) {
      std::vector<VertexId> free;
      for (const VertexId id : testing::LiveVertices(made->mesh)) {
        if (!made->mesh.vertex(id).fixed) free.push_back(id);
      }
      if (free.empty()) break;
      ASSERT_TRUE(RemoveAt(*made, free[rng.Below(free.size())]).has_value()) << "seed " << seed;
      ASSERT_EQ(Faults(made->mesh), "");
    }
    EXPECT_EQ(made->mesh.triangle_count(), 2);
    EXPECT_EQ(made->mesh.edge_count(), 4);
  }
}

}  // namespace
}  // namespace pliant
