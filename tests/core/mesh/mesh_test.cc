#include "core/mesh/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::DomainMesh;
using testing::GridData;
using testing::ImportedMesh;

TEST(Mesh, FindsConstrainedEdgesFromBothEndsAndNoOthers) {
  const auto made = DomainMesh(testing::Rectangle({0, 0}, {2, 1}));
  const Mesh& mesh = made->mesh;
  EXPECT_EQ(mesh.FindEdge(VertexId(0), VertexId(1)), EdgeId(0));
  EXPECT_EQ(mesh.FindEdge(VertexId(1), VertexId(0)), EdgeId(0));
  EXPECT_EQ(mesh.FindEdge(VertexId(3), VertexId(0)), EdgeId(3));
  EXPECT_FALSE(mesh.FindEdge(VertexId(0), VertexId(2)).valid());
  EXPECT_FALSE(mesh.FindEdge(VertexId(1), VertexId(3)).valid());
}

TEST(Mesh, GivesTheEndsOfASegmentExactly) {
  Domain domain = testing::Rectangle({0.1, 0.3}, {0.7, 1.1});
  domain.points[2] = {1.0 / 3, 1e3};  // a + (b - a) rounds away from b here.
  const auto made = DomainMesh(domain);
  for (std::int32_t s = 0; s < 4; ++s) {
    const SegmentRecord& segment = made->mesh.segments()[static_cast<std::size_t>(s)];
    EXPECT_EQ(made->mesh.PointOnSegment(s, 0), made->mesh.position(segment.a));
    EXPECT_EQ(made->mesh.PointOnSegment(s, 1), made->mesh.position(segment.b));
  }
}

TEST(Mesh, OrdersTheTwoEdgesOfAVertexInsideASegmentAlongIt) {
  const auto made = DomainMesh(testing::Rectangle({0, 0}, {1, 1}));
  const EdgeRecord bottom = made->mesh.edge(EdgeId(0));
  const auto& corners = made->mesh.triangle(bottom.triangle).vertices;
  int apex = 0;
  while (corners[static_cast<std::size_t>(apex)] == VertexId(0) ||
         corners[static_cast<std::size_t>(apex)] == VertexId(1)) {
    ++apex;
  }
  const VertexId middle = made->edit.SplitEdge({bottom.triangle, apex}, {0.5, 0}, 0.5);
  const auto [before, after] = made->mesh.SegmentEdges(middle);
  EXPECT_EQ(made->mesh.edge(before).vertices[0], VertexId(0));
  EXPECT_EQ(made->mesh.edge(before).vertices[1], middle);
  EXPECT_EQ(made->mesh.edge(after).vertices[0], middle);
  EXPECT_EQ(made->mesh.edge(after).vertices[1], VertexId(1));
}

TEST(Mesh, FanStartIsTheMostClockwiseTriangleOfAnOpenFanAndTheStartOfAClosedOne) {
  const auto made = ImportedMesh(GridData(2, 2));
  const Mesh& mesh = made->mesh;
  const TriangleId start = mesh.vertex(VertexId(4)).triangle;
  EXPECT_EQ(mesh.FanStart(VertexId(4), start), start);
  for (const TriangleId id : testing::LiveTriangles(mesh)) {
    const auto& corners = mesh.triangle(id).vertices;
    if (std::find(corners.begin(), corners.end(), VertexId(1)) == corners.end()) continue;
    const TriangleId first = mesh.FanStart(VertexId(1), id);
    // The side from vertex 1 to vertex 2, on the boundary, is the first one counter-clockwise.
    const int corner = mesh.CornerOf(first, VertexId(1));
    EXPECT_EQ(mesh.triangle(first).vertices[static_cast<std::size_t>(NextCorner(corner))],
              VertexId(2));
  }
}

TEST(Mesh, KnowsWhichSlotsAreLive) {
  const auto made = ImportedMesh(GridData(1, 1));
  EXPECT_TRUE(made->mesh.IsLive(VertexId(3)));
  EXPECT_FALSE(made->mesh.IsLive(VertexId(4)));
  EXPECT_FALSE(made->mesh.IsLive(VertexId()));
}

}  // namespace
}  // namespace pliant
