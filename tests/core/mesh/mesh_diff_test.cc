#include "core/mesh/mesh_diff.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <vector>

#include "core/mesh/star.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::GridData;
using testing::ImportedMesh;

std::array<VertexId, 3> Corners(int a, int b, int c) {
  return {VertexId(a), VertexId(b), VertexId(c)};
}

TEST(CanonicalTriangle, BeginsWithTheSmallestAndKeepsTheOrientation) {
  for (const auto& corners : {Corners(3, 7, 5), Corners(7, 5, 3), Corners(5, 3, 7)}) {
    EXPECT_EQ(CanonicalTriangle(corners), Corners(3, 7, 5));
  }
  for (const auto& corners : {Corners(3, 5, 7), Corners(5, 7, 3), Corners(7, 3, 5)}) {
    EXPECT_EQ(CanonicalTriangle(corners), Corners(3, 5, 7));
  }
}

// Goal: every field of an element, and its kind, reach the hash, and swapped ones do not cancel.
TEST(ElementHash, DiffersForEveryFieldThatDiffers) {
  std::set<std::uint64_t> seen;
  const auto fresh = [&](std::uint64_t hash) { return seen.insert(hash).second; };
  EXPECT_TRUE(fresh(VertexHash(VertexId(0), {0, 0})));
  EXPECT_TRUE(fresh(VertexHash(VertexId(1), {0, 0})));
  EXPECT_TRUE(fresh(VertexHash(VertexId(0), {0, 1})));
  EXPECT_TRUE(fresh(VertexHash(VertexId(0), {1, 0})));
  EXPECT_TRUE(fresh(VertexHash(VertexId(0), {-0.0, 0})));
  EXPECT_TRUE(fresh(TriangleHash(TriangleId(0), Corners(0, 1, 2), 0)));
  EXPECT_TRUE(fresh(TriangleHash(TriangleId(1), Corners(0, 1, 2), 0)));
  EXPECT_TRUE(fresh(TriangleHash(TriangleId(0), Corners(0, 2, 1), 0)));
  EXPECT_TRUE(fresh(TriangleHash(TriangleId(0), Corners(0, 1, 2), -1)));
  EXPECT_TRUE(fresh(EdgeHash(EdgeId(0), {VertexId(0), VertexId(1)}, 2)));
  EXPECT_TRUE(fresh(EdgeHash(EdgeId(0), {VertexId(1), VertexId(0)}, 2)));
  EXPECT_TRUE(fresh(EdgeHash(EdgeId(0), {VertexId(0), VertexId(1)}, 3)));
  EXPECT_TRUE(fresh(EdgeHash(EdgeId(1), {VertexId(0), VertexId(1)}, 2)));
}

TEST(SnapshotOf, HoldsEveryLiveElementInOrder) {
  const auto made = ImportedMesh(GridData(2, 1));
  const MeshDiff snapshot = SnapshotOf(made->mesh, Revision(5));
  EXPECT_EQ(snapshot.base_revision, Revision::kNone);
  EXPECT_EQ(snapshot.revision, Revision(5));
  EXPECT_EQ(snapshot.vertex_ids.size(), 6U);
  EXPECT_EQ(snapshot.metric_vertex_ids.size(), 6U);
  EXPECT_EQ(snapshot.triangle_ids.size(), 4U);
  EXPECT_EQ(snapshot.edge_ids.size(), 6U);
  EXPECT_EQ(snapshot.triangle_vertices[0], Corners(0, 1, 4));
  EXPECT_EQ(snapshot.summary.triangle_count, 4);
  EXPECT_FALSE(snapshot.empty());
}

TEST(MeshDiff, OfNothingIsEmptyAndKeepsTheHash) {
  const auto made = ImportedMesh(GridData(2, 2));
  const MeshDiff first = made->edit.Commit(Revision(1));
  const MeshDiff second = made->edit.Commit(Revision(2));
  EXPECT_TRUE(second.empty());
  EXPECT_TRUE(second.metric_vertex_ids.empty());
  EXPECT_EQ(second.summary, first.summary);
  EXPECT_EQ(second.base_revision, Revision(1));
}

TEST(MeshDiff, LeavesOutWhatEndedAsItBegan) {
  const auto made = ImportedMesh(GridData(2, 2));
  (void)made->edit.Commit(Revision(1));
  const VertexId center(4);
  const Vec2 home = made->mesh.position(center);
  made->edit.MoveVertex(center, {1.25, 1.25});
  made->edit.MoveVertex(center, home);
  made->edit.SetMetric(center, {2, 0, 2});
  made->edit.SetMetric(center, {1, 0, 1});
  made->edit.Visit(center).age = 7;
  // Two swaps turn a diagonal all the way; the slots may have changed places, so four do not.
  for (int i = 0; i < 4; ++i) {
    const TriangleId t(0);
    const auto& neighbors = made->mesh.triangle(t).neighbors;
    const auto side = std::find(neighbors.begin(), neighbors.end(), TriangleId(1));
    made->edit.SwapEdge({t, static_cast<int>(side - neighbors.begin())});
  }
  const MeshDiff diff = made->edit.Commit(Revision(2));
  EXPECT_TRUE(diff.empty());
  EXPECT_TRUE(diff.metric_vertex_ids.empty());
}

TEST(MeshDiff, LeavesOutWhatWasCreatedAndDestroyed) {
  const auto made = ImportedMesh(GridData(2, 2));
  const MeshDiff first = made->edit.Commit(Revision(1));
  const VertexId born = made->edit.SplitEdge({TriangleId(0), 0}, {1, 0.5}, 0);
  Star star;
  star.Gather(made->mesh, born);
  // The split triangles again: the two triangles of the edge, in their old slots.
  const auto& ring = star.ring();
  std::vector<NewTriangle> restored;
  for (std::size_t k = 0; k < 4; k += 2) {
    const std::size_t corner = ring[0] == VertexId(1) || ring[0] == VertexId(4) ? k : k + 1;
    restored.push_back({{ring[corner], ring[(corner + 1) % 4], ring[(corner + 2) % 4]}, 0});
  }
  std::vector<TriangleId> cavity(star.triangles().begin(), star.triangles().end());
  std::sort(cavity.begin(), cavity.end());  // The new slots come last and are given up.
  made->edit.ReplaceCavity(cavity, restored);
  made->edit.RemoveVertex(born);
  ASSERT_EQ(testing::Faults(made->mesh), "");
  const MeshDiff diff = made->edit.Commit(Revision(2));
  EXPECT_TRUE(diff.vertex_ids.empty());
  EXPECT_TRUE(diff.removed_vertices.empty());
  EXPECT_TRUE(diff.removed_triangles.empty());
  EXPECT_EQ(diff.summary.triangle_count, first.summary.triangle_count);
  for (const TriangleId id : diff.triangle_ids) EXPECT_LT(id, TriangleId(8));
}

TEST(MeshDiff, TellsMinusZeroFromZeroBecauseReplicasCopyBits) {
  const auto made = ImportedMesh(GridData(1, 1));
  (void)made->edit.Commit(Revision(1));
  made->edit.MoveVertex(VertexId(0), {-0.0, 0.0});
  const MeshDiff diff = made->edit.Commit(Revision(2));
  ASSERT_EQ(diff.vertex_ids.size(), 1U);
  EXPECT_TRUE(std::signbit(diff.vertex_positions[0].x));
  EXPECT_EQ(diff.summary, SnapshotOf(made->mesh, Revision(2)).summary);
}

}  // namespace
}  // namespace pliant
