#include "core/pliant/slide.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <vector>

#include "tests/support/loop_mesh.h"

namespace pliant {
namespace {

using testing::EditedMesh;

/// The unit square with some 16 edges along each side.
std::unique_ptr<EditedMesh> Square() {
  return testing::LoopMesh(testing::DiscCase(300, testing::DiscState::kOff));
}

/// Vertices inside the wall y = 0, from left to right.
std::vector<VertexId> BottomOf(const Mesh& mesh) {
  std::map<double, VertexId> by_x;
  for (const VertexId vertex : testing::LiveVertices(mesh)) {
    const Vec2 p = mesh.position(vertex);
    if (p.y == 0 && p.x > 0 && p.x < 1) by_x[p.x] = vertex;
  }
  std::vector<VertexId> vertices;
  for (const auto& [x, vertex] : by_x) vertices.push_back(vertex);
  return vertices;
}

double EdgeLength(const Mesh& mesh) { return 1 / std::sqrt(mesh.metric(VertexId(0)).m11); }

TEST(IsSlidable, HoldsInsideWallsOnly) {
  const auto square = Square();
  const Mesh& mesh = square->mesh;
  for (const VertexId vertex : testing::LiveVertices(mesh)) {
    const Vec2 p = mesh.position(vertex);
    const int walls = (p.x == 0 || p.x == 1 ? 1 : 0) + (p.y == 0 || p.y == 1 ? 1 : 0);
    EXPECT_EQ(IsSlidable(mesh, vertex), walls == 1) << p.x << " " << p.y;
  }
  const VertexId some = BottomOf(mesh)[2];
  square->edit.SetHold(some, MeshEdit::Hold::kFrozen);
  EXPECT_FALSE(IsSlidable(mesh, some));
}

TEST(PlaceAlongWall, FollowsWhereTheWallLeads) {
  const auto square = Square();
  const double edge = EdgeLength(square->mesh);
  const VertexId vertex = BottomOf(square->mesh)[5];
  const Vec2 from = square->mesh.position(vertex);
  const auto place = PlaceAlongWall(square->mesh, vertex, {0.8 * edge, 0.2 * edge});
  ASSERT_TRUE(place.has_value());
  EXPECT_NEAR(place->x, from.x + 0.8 * edge, 1e-12);
  EXPECT_EQ(place->y, 0);
  EXPECT_FALSE(PlaceAlongWall(square->mesh, vertex, {0.8 * edge, 0.3 * edge}).has_value());
}

// Goal: of those who stand still on the wall, exactly those are overtaken that a slide passes or
// comes too near to. Method: a run of four slides by all kinds of ways, in both directions; who is
// in the way is looked up among all vertices of the wall.
TEST(PlanSlides, OvertakesWhoStandsInTheWay) {
  const auto square = Square();
  const Mesh& mesh = square->mesh;
  const std::vector<VertexId> wall = BottomOf(mesh);
  ASSERT_GT(wall.size(), 13U);
  const double edge = EdgeLength(mesh);
  for (int way = -28; way <= 28; ++way) {
    SCOPED_TRACE(way);
    if (way == 0) continue;
    const double by = 0.1 * way * edge;
    std::vector<PlaceOnWall> list;
    for (std::size_t k = 5; k < 9; ++k) {
      list.push_back({wall[k], mesh.position(wall[k]) + Vec2{by, 0}});
    }
    const SlidePlan plan = PlanSlides(mesh, list);
    ASSERT_EQ(plan.slides.size(), 4U);
    for (const Slide& slide : plan.slides) EXPECT_NEAR(slide.to - slide.from, by, 1e-12);
    std::vector<VertexId> in_the_way;
    for (std::size_t k = 0; k < wall.size(); ++k) {
      if (k >= 5 && k < 9) continue;
      const double x = mesh.position(wall[k]).x;
      const bool passed = by > 0 ? k > 8 && x < mesh.position(wall[8]).x + by + 0.6 * edge
                                 : k < 5 && x > mesh.position(wall[5]).x + by - 0.6 * edge;
      if (passed) in_the_way.push_back(wall[k]);
    }
    std::vector<VertexId> overtaken = plan.overtaken;
    std::ranges::sort(overtaken);
    std::ranges::sort(in_the_way);
    EXPECT_EQ(overtaken, in_the_way);
  }
}

TEST(PlanSlides, LosesWhoComesToTheEndOfTheWall) {
  const auto square = Square();
  const std::vector<VertexId> wall = BottomOf(square->mesh);
  const double edge = EdgeLength(square->mesh);
  std::vector<PlaceOnWall> list;
  for (std::size_t k = wall.size() - 4; k < wall.size(); ++k) {
    list.push_back({wall[k], square->mesh.position(wall[k]) + Vec2{1.7 * edge, 0}});
  }
  const SlidePlan plan = PlanSlides(square->mesh, list);
  ASSERT_EQ(plan.slides.size(), 2U);
  EXPECT_EQ(plan.slides[1].vertex, wall[wall.size() - 3]);
  EXPECT_EQ(plan.overtaken, (std::vector<VertexId>{wall.back(), wall[wall.size() - 2]}));
}

TEST(PlanSlides, LeavesAWallAloneWhereSomeWouldChangePlaces) {
  const auto square = Square();
  const Mesh& mesh = square->mesh;
  const std::vector<VertexId> wall = BottomOf(mesh);
  const std::vector<PlaceOnWall> list = {{wall[3], mesh.position(wall[5])},
                                         {wall[4], mesh.position(wall[4]) + Vec2{0.001, 0}}};
  const SlidePlan plan = PlanSlides(mesh, list);
  EXPECT_TRUE(plan.slides.empty());
  EXPECT_TRUE(plan.overtaken.empty());
}

}  // namespace
}  // namespace pliant
