#include "core/delaunay/overtaken.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/delaunay/cavity.h"
#include "tests/support/board.h"
#include "tests/support/mesh_testing.h"
#include "tests/support/stop_after.h"

namespace pliant {
namespace {

using testing::Board;
using testing::Faults;

// Goal: somebody who wants the motion to end is asked.
TEST(OvertakenCavity, CanBeStopped) {
  Board board;
  board.Put(VertexId(40), {6.4, 4.2});
  const testing::StopAfter stop(1);
  const std::vector<TriangleId> inverted = board.Inverted();
  EXPECT_EQ(OvertakenCavity(board.grid->mesh, inverted, board.Move(), Overtaking::kAllGo, &stop),
            inverted);
  EXPECT_EQ(stop.asked_count(), 1);
  const testing::StopAfter patient(100);
  EXPECT_GT(OvertakenCavity(board.grid->mesh, inverted, board.Move(), Overtaking::kAllGo, &patient)
                .size(),
            inverted.size());
}

// Goal: a block of 3 x 3 vertices that jumps by two and a half cells to the right survives, those
// that it lands on go, and nobody elsewhere does.
TEST(OvertakenCavity, LosesThoseThatStoodStill) {
  Board board;
  for (const std::int32_t row : {3, 4, 5}) {
    for (const std::int32_t column : {2, 3, 4}) {
      const VertexId vertex(9 * row + column);
      board.Put(vertex, board.grid->mesh.position(vertex) + Vec2{2.5, 0});
    }
  }
  const std::vector<TriangleId> inverted = board.Inverted();
  ASSERT_FALSE(inverted.empty());
  const std::vector<TriangleId> cavity =
      OvertakenCavity(board.grid->mesh, inverted, board.Move(), Overtaking::kStillGo);
  EXPECT_TRUE(std::is_sorted(cavity.begin(), cavity.end()));
  const auto filled = RetriangulateCavity(
      board.grid->edit, cavity, [&](VertexId vertex) { return !board.Move().is_free(vertex); });
  ASSERT_TRUE(filled.ok());
  EXPECT_EQ(Faults(board.grid->mesh), "");
  for (const VertexId vertex : board.moved) EXPECT_TRUE(board.grid->mesh.IsLive(vertex));
  EXPECT_GE(filled->removed.size(), 6U);
  for (const VertexId vertex : filled->removed) {
    const Vec2 p{static_cast<double>(vertex.value() % 9), static_cast<double>(vertex.value() / 9)};
    EXPECT_GT(p.x, 3.9);
    EXPECT_LT(p.x, 8);
    EXPECT_GT(p.y, 1.9);
    EXPECT_LT(p.y, 6.3);
  }
}

// Goal: who moves goes where it lands beyond the wall.
TEST(OvertakenCavity, LosesThoseThatWouldLeaveTheDomain) {
  Board board;
  for (const std::int32_t row : {3, 4, 5}) {
    for (const std::int32_t column : {5, 6, 7}) {
      const VertexId vertex(9 * row + column);
      board.Put(vertex, board.grid->mesh.position(vertex) + Vec2{1.25, 0.125});
    }
  }
  const std::vector<TriangleId> cavity =
      OvertakenCavity(board.grid->mesh, board.Inverted(), board.Move(), Overtaking::kAllGo);
  const auto filled = RetriangulateCavity(
      board.grid->edit, cavity, [&](VertexId vertex) { return !board.Move().is_free(vertex); });
  ASSERT_TRUE(filled.ok());
  EXPECT_EQ(Faults(board.grid->mesh), "");
  for (const std::int32_t row : {3, 4, 5}) {
    EXPECT_FALSE(board.grid->mesh.IsLive(VertexId(9 * row + 7)));
    EXPECT_TRUE(board.grid->mesh.IsLive(VertexId(9 * row + 5)));
  }
}

TEST(OvertakenCavity, IsWhatWasSpoiledIfNobodyPassed) {
  Board board;
  board.Put(VertexId(40), {4.9, 4.05});
  const std::vector<TriangleId> spoiled = {board.grid->mesh.vertex(VertexId(40)).triangle};
  EXPECT_EQ(OvertakenCavity(board.grid->mesh, spoiled, board.Move(), Overtaking::kAllGo), spoiled);
}

TEST(WithRing, AddsTheTrianglesAtAllCorners) {
  const Board board;
  const Mesh& mesh = board.grid->mesh;
  const std::vector<TriangleId> one = {mesh.vertex(VertexId(40)).triangle};
  const std::vector<TriangleId> ring = WithRing(mesh, one);
  for (std::int32_t t = 0; t < mesh.triangle_slots(); ++t) {
    bool shares = false;
    for (const VertexId corner : mesh.triangle(TriangleId(t)).vertices) {
      for (const VertexId other : mesh.triangle(one[0]).vertices) shares |= corner == other;
    }
    EXPECT_EQ(std::binary_search(ring.begin(), ring.end(), TriangleId(t)), shares) << t;
  }
}

}  // namespace
}  // namespace pliant
