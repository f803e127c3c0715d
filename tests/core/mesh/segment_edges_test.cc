#include "core/mesh/segment_edges.h"

#include <gtest/gtest.h>

#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

// Goal: a segment's edges and the vertices between them come in the order of their parameters.
TEST(SegmentEdges, AreVisitedFromTheBeginning) {
  const auto made = testing::ImportedMesh(testing::GridData(5, 2));
  const Mesh& mesh = made->mesh;
  ASSERT_EQ(mesh.segments().size(), 4U);
  std::int32_t edge_count = 0;
  for (std::int32_t s = 0; s < 4; ++s) {
    double t = 0;
    VertexId at = mesh.segments()[static_cast<std::size_t>(s)].a;
    std::vector<VertexId> between;
    ForEachPiece(mesh, s, [&](EdgeId id) {
      EXPECT_EQ(mesh.edge(id).vertices[0], at);
      EXPECT_EQ(mesh.edge(id).parameters[0], t);
      EXPECT_EQ(EdgeFrom(mesh, s, at), id);
      at = mesh.edge(id).vertices[1];
      t = mesh.edge(id).parameters[1];
      between.push_back(at);
      ++edge_count;
    });
    EXPECT_EQ(t, 1);
    between.pop_back();
    std::vector<VertexId> inside;
    ForEachInside(mesh, s, [&](VertexId vertex, double) { inside.push_back(vertex); });
    EXPECT_EQ(inside, between);
  }
  EXPECT_EQ(edge_count, mesh.edge_count());
  EXPECT_FALSE(EdgeFrom(mesh, 0, mesh.segments()[0].b).valid());
}

}  // namespace
}  // namespace pliant
