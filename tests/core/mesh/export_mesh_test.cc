#include "core/mesh/export_mesh.h"

#include <gtest/gtest.h>

#include "core/delaunay/import_mesh.h"
#include "core/geometry/predicates.h"
#include "core/mesh/validate.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::GridData;
using testing::ImportedMesh;

TEST(ExportMesh, GivesBackWhatWasImported) {
  MeshData data = GridData(3, 2);
  data.triangle_tags.assign(data.triangles.size(), 4);
  data.edges = {{5, 6}, {6, 10}};
  data.edge_tags = {8, 9};
  const auto made = ImportedMesh(data);
  const ExportedMesh out = ExportMesh(made->mesh);
  EXPECT_EQ(out.data.points, data.points);
  EXPECT_EQ(out.data.triangle_tags, data.triangle_tags);
  ASSERT_GE(out.data.edges.size(), 2U);
  EXPECT_EQ(out.data.edges[0], data.edges[0]);
  EXPECT_EQ(out.data.edges[1], data.edges[1]);
  EXPECT_EQ(out.data.edges.size(), 2U + 10U) << "the boundary has 10 edges";
  for (std::size_t i = 0; i < out.vertex_ids.size(); ++i) {
    EXPECT_EQ(out.vertex_ids[i], VertexId::FromIndex(i));
  }
}

// Goal: gaps in the slots do not show, every id stands beside its element.
TEST(ExportMesh, SkipsDeadSlotsAndNamesTheLiveOnes) {
  const auto made = ImportedMesh(GridData(5, 5));
  testing::RandomEditor editor(*made, 21);
  for (int i = 0; i < 500; ++i) editor.Step();
  ASSERT_LT(made->mesh.vertex_count(), made->mesh.vertex_slots()) << "the test needs gaps";
  const ExportedMesh out = ExportMesh(made->mesh);
  EXPECT_EQ(out.vertex_ids, testing::LiveVertices(made->mesh));
  EXPECT_EQ(out.triangle_ids, testing::LiveTriangles(made->mesh));
  for (std::size_t i = 0; i < out.vertex_ids.size(); ++i) {
    EXPECT_EQ(out.data.points[i], made->mesh.position(out.vertex_ids[i]));
  }
  for (std::size_t t = 0; t < out.triangle_ids.size(); ++t) {
    const auto expected = CanonicalTriangle(made->mesh.triangle(out.triangle_ids[t]).vertices);
    for (std::size_t k = 0; k < 3; ++k) {
      const auto dense = static_cast<std::size_t>(out.data.triangles[t][k]);
      EXPECT_EQ(out.vertex_ids[dense], expected[k]);
    }
  }
  for (std::size_t e = 0; e < out.edge_ids.size(); ++e) {
    const EdgeRecord& edge = made->mesh.edge(out.edge_ids[e]);
    EXPECT_EQ(out.vertex_ids[static_cast<std::size_t>(out.data.edges[e][0])], edge.vertices[0]);
    EXPECT_EQ(out.data.edge_tags[e], edge.tag);
  }
  const auto again = ImportedMesh(out.data);
  EXPECT_EQ(testing::Faults(again->mesh), "");
  EXPECT_EQ(Area(again->mesh), Area(made->mesh));
}

}  // namespace
}  // namespace pliant
