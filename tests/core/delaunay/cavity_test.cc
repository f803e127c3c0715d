#include "core/delaunay/cavity.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "core/mesh/star.h"
#include "core/mesh/validate.h"
#include "tests/support/cases.h"
#include "tests/support/loop_mesh.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::Faults;

std::vector<TriangleId> StarOf(const Mesh& mesh, VertexId vertex) {
  Star star;
  star.Gather(mesh, vertex);
  return {star.triangles().begin(), star.triangles().end()};
}

bool KeepsNone(VertexId) { return false; }
bool KeepsAll(VertexId) { return true; }

TEST(Cavity, LosesItsFreeVertices) {
  auto grid = testing::ImportedMesh(testing::GridData(4, 4));
  const double area = Area(grid->mesh);
  const auto filled = RetriangulateCavity(grid->edit, StarOf(grid->mesh, VertexId(12)), KeepsNone);
  ASSERT_TRUE(filled.ok());
  EXPECT_EQ(filled->removed, std::vector<VertexId>{VertexId(12)});
  EXPECT_EQ(filled->corners.size(), 6U);
  EXPECT_EQ(Faults(grid->mesh), "");
  EXPECT_EQ(Area(grid->mesh), area);
}

// Goal: vertices inside a wall go if they are told to, several in a row too, and the edges at them
// become one. Method: the bottom of a square, and a wall through it, which has a cavity on both
// sides.
TEST(Cavity, TakesVerticesOffWalls) {
  for (const double y : {0.0, 0.5}) {
    SCOPED_TRACE(y);
    testing::Case square = testing::DiscCase(300, testing::DiscState::kOff);
    square.domain.points = {{0, 0}, {1, 0}, {1, 0.5}, {1, 1}, {0, 1}, {0, 0.5}};
    square.domain.segments.clear();
    for (const auto& [a, b] : {std::pair(0, 1), {1, 2}, {2, 3}, {3, 4}, {4, 5}, {5, 0}, {5, 2}}) {
      square.domain.segments.push_back({a, b, 0});
    }
    const auto made = testing::LoopMesh(std::move(square));
    const Mesh& mesh = made->mesh;
    std::map<double, VertexId> wall;
    for (const VertexId vertex : testing::LiveVertices(mesh)) {
      const Vec2 p = mesh.position(vertex);
      if (p.y == y && mesh.vertex(vertex).edge.valid()) wall[p.x] = vertex;
    }
    std::vector<VertexId> along;
    for (const auto& [x, vertex] : wall) along.push_back(vertex);
    ASSERT_GT(along.size(), 10U);
    const std::vector<VertexId> leaving = {along[4], along[3], along[6]};
    std::vector<TriangleId> cavity;
    for (const VertexId vertex : leaving) {
      for (const TriangleId id : StarOf(mesh, vertex)) cavity.push_back(id);
    }
    const auto filled = RetriangulateCavity(made->edit, cavity, KeepsAll, leaving);
    ASSERT_TRUE(filled.ok());
    for (const VertexId vertex : leaving) EXPECT_FALSE(mesh.IsLive(vertex));
    EXPECT_TRUE(mesh.FindEdge(along[2], along[5]).valid());
    EXPECT_TRUE(mesh.FindEdge(along[5], along[7]).valid());
    EXPECT_EQ(Faults(mesh), "");
    EXPECT_NEAR(Area(mesh), 1, 1e-12);
  }
}

// A vertex has been put where its triangles are inverted: the cavity does not care.
TEST(Cavity, RepairsInvertedTriangles) {
  auto grid = testing::ImportedMesh(testing::GridData(4, 4));
  std::vector<TriangleId> cavity;
  for (const std::int32_t v : {11, 12, 13, 6, 7, 8, 16, 17, 18}) {
    for (const TriangleId id : StarOf(grid->mesh, VertexId(v))) cavity.push_back(id);
  }
  grid->edit.PlaceVertex(VertexId(12), {3.25, 2.5});
  ASSERT_NE(Faults(grid->mesh), "");
  const auto filled = RetriangulateCavity(grid->edit, cavity,
                                          [](VertexId vertex) { return vertex == VertexId(12); });
  ASSERT_TRUE(filled.ok());
  EXPECT_EQ(filled->removed.size(), 8U);
  EXPECT_TRUE(grid->mesh.IsLive(VertexId(12)));
  EXPECT_EQ(Faults(grid->mesh), "");
  EXPECT_EQ(Area(grid->mesh), 16);
}

TEST(Cavity, IsLeftAloneIfItsRimCrossesItself) {
  auto grid = testing::ImportedMesh(testing::GridData(4, 4));
  auto same = testing::ImportedMesh(testing::GridData(4, 4));
  for (auto* one : {&grid, &same}) (*one)->edit.PlaceVertex(VertexId(11), {5, 2});
  EXPECT_FALSE(RetriangulateCavity(grid->edit, StarOf(grid->mesh, VertexId(12)), KeepsNone).ok());
  EXPECT_EQ(testing::DifferenceOf(grid->mesh, same->mesh), "");
}

// Goal: constraints inside, regions on both sides and a hole within the rim survive; the whole
// domain may be the cavity.
TEST(Cavity, KeepsConstraintsRegionsAndHoles) {
  Domain domain = testing::Rectangle({0, 0}, {6, 4});
  const std::vector<Vec2> more = {{3, 0}, {3, 4}, {1, 1}, {2, 1}, {2, 2}, {1, 2}, {4, 1}, {5, 3}};
  domain.points.insert(domain.points.end(), more.begin(), more.end());
  domain.segments = {{0, 4, 1}, {4, 1, 1}, {1, 2, 2}, {2, 5, 3}, {5, 3, 3}, {3, 0, 4},
                     {4, 5, 5}, {6, 7, 6}, {7, 8, 6}, {8, 9, 6}, {9, 6, 6}, {10, 11, 7}};
  domain.holes = {{1.5, 1.5}};
  domain.regions = {{{0.5, 0.5}, 10}, {{5.5, 0.5}, 20}};
  const auto mesh = testing::DomainMesh(domain);
  const auto areas = testing::RegionAreas(mesh->mesh);
  const auto lengths = testing::TagLengths(mesh->mesh);
  ASSERT_EQ(areas.size(), 2U);
  const auto filled = RetriangulateCavity(mesh->edit, testing::LiveTriangles(mesh->mesh), KeepsAll);
  ASSERT_TRUE(filled.ok());
  EXPECT_TRUE(filled->removed.empty());
  EXPECT_EQ(Faults(mesh->mesh), "");
  EXPECT_EQ(testing::RegionAreas(mesh->mesh), areas);
  EXPECT_EQ(testing::TagLengths(mesh->mesh), lengths);
}

}  // namespace
}  // namespace pliant
