#include "core/transfer/components.h"

#include <gtest/gtest.h>

#include "tests/support/random_transfer.h"

namespace pliant {
namespace {

/// An 8 x 8 grid in which vertices were moved a little.
std::unique_ptr<testing::EditedMesh> GridWithMoves(std::span<const VertexId> moved) {
  auto edited = testing::ImportedMesh(testing::GridData(8, 8));
  (void)edited->edit.Commit(Revision(1));
  for (const VertexId id : moved) {
    edited->edit.MoveVertex(id, edited->mesh.position(id) + Vec2{0.1, 0.05});
  }
  return edited;
}

std::size_t PieceCount(const MeshTransfer& transfer, OverlapComponents& pieces) {
  OverlapFinder finder(transfer.region(), transfer.locator());
  for (std::size_t t = 0; t < transfer.region().after.triangles.size(); ++t) {
    finder.Find(static_cast<std::int32_t>(t));
    pieces.AddOverlaps(static_cast<std::int32_t>(t), finder);
  }
  pieces.Finish(transfer.locator());
  std::vector<bool> used(pieces.count(), false);
  for (std::size_t t = 0; t < transfer.region().after.triangles.size(); ++t) {
    used[pieces.of_after(t)] = true;
  }
  for (std::size_t t = 0; t < transfer.region().before.triangles.size(); ++t) {
    EXPECT_TRUE(used[pieces.of_before(t)]) << "old triangle " << t << " has no new one";
  }
  return static_cast<std::size_t>(std::ranges::count(used, true));
}

TEST(OverlapComponents, KeepsDistantSpotsApart) {
  const std::vector<VertexId> moved{VertexId(10), VertexId(15), VertexId(60)};
  const auto edited = GridWithMoves(moved);
  const MeshTransfer transfer(edited->mesh, edited->edit.log());
  OverlapComponents pieces(transfer.region());
  EXPECT_EQ(PieceCount(transfer, pieces), 3U);
}

// Two stars that share a vertex but no triangle: apart for cells, joined for nodal unknowns.
TEST(OverlapComponents, JoinsSpotsThatShareACornerOnlyWhereAsked) {
  const std::vector<VertexId> moved{VertexId(30), VertexId(32)};
  const auto edited = GridWithMoves(moved);
  const MeshTransfer transfer(edited->mesh, edited->edit.log());
  OverlapComponents cells(transfer.region());
  EXPECT_EQ(PieceCount(transfer, cells), 2U);
  OverlapComponents nodes(transfer.region());
  nodes.LinkCorners();
  EXPECT_EQ(PieceCount(transfer, nodes), 1U);
}

// The right column of the grid is squeezed into what was the left part of its neighbour: the old
// triangles at the far right have no new triangle over them.
TEST(OverlapComponents, JoinsOldTrianglesThatTheBoundaryWentOver) {
  auto edited = testing::ImportedMesh(testing::GridData(4, 1));
  (void)edited->edit.Commit(Revision(1));
  for (const std::int32_t v : {3, 4, 8, 9}) {
    const Vec2 p = edited->mesh.position(VertexId(v));
    edited->edit.MoveVertex(VertexId(v), {2 + 0.25 * (p.x - 2), p.y});
  }
  const MeshTransfer transfer(edited->mesh, edited->edit.log());
  OverlapComponents pieces(transfer.region());
  EXPECT_EQ(PieceCount(transfer, pieces), 1U);
}

}  // namespace
}  // namespace pliant
