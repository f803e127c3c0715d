#include "core/mesh/mesh_edit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "core/mesh/validate.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::DifferenceOf;
using testing::DomainMesh;
using testing::EditedMesh;
using testing::Faults;
using testing::GridData;
using testing::ImportedMesh;
using testing::RandomEditor;
using testing::Replica;

/// A 6 x 6 grid of two regions with a constrained edge line between them, and a hole.
MeshData TwoRegions() {
  MeshData data = GridData(6, 6);
  MeshData out;
  out.points = data.points;
  for (std::size_t t = 0; t < data.triangles.size(); ++t) {
    const std::size_t cell = t / 2;
    if (cell == 8 || cell == 9) continue;
    out.triangles.push_back(data.triangles[t]);
    out.triangle_tags.push_back(cell / 6 < 3 ? 1 : 2);
  }
  for (std::int32_t x = 0; x < 6; ++x) out.edges.push_back({21 + x, 22 + x});
  out.edge_tags.assign(6, 9);
  return out;
}

TEST(MeshEdit, SwapEdgeTurnsTheDiagonalAndKeepsBothSlots) {
  const auto made = ImportedMesh(GridData(1, 1));
  ASSERT_EQ(Faults(made->mesh), "");
  made->edit.SwapEdge({TriangleId(0), made->mesh.CornerOf(TriangleId(0), VertexId(1))});
  EXPECT_EQ(Faults(made->mesh), "");
  EXPECT_EQ(made->mesh.triangle_count(), 2);
  for (const std::int32_t t : {0, 1}) {
    const auto& v = made->mesh.triangle(TriangleId(t)).vertices;
    EXPECT_EQ(std::count(v.begin(), v.end(), VertexId(1)), 1);
    EXPECT_EQ(std::count(v.begin(), v.end(), VertexId(2)), 1);
  }
}

TEST(MeshEdit, SplitEdgeMakesTwoTrianglesOfOneAndInheritsTagRegionAndSegment) {
  const auto made = ImportedMesh(TwoRegions());
  ASSERT_EQ(Faults(made->mesh), "");
  const EdgeId edge = made->mesh.FindEdge(VertexId(24), VertexId(25));
  ASSERT_TRUE(edge.valid());
  const EdgeRecord before = made->mesh.edge(edge);
  const auto& corners = made->mesh.triangle(before.triangle).vertices;
  int apex = 0;
  while (std::find(before.vertices.begin(), before.vertices.end(),
                   corners[static_cast<std::size_t>(apex)]) != before.vertices.end()) {
    ++apex;
  }
  const double t = 0.5 * (before.parameters[0] + before.parameters[1]);
  const Vec2 at = made->mesh.PointOnSegment(before.segment, t);
  const VertexId middle = made->edit.SplitEdge({before.triangle, apex}, at, t);
  EXPECT_EQ(Faults(made->mesh), "");
  const auto [first, second] = made->mesh.SegmentEdges(middle);
  EXPECT_EQ(first, edge);
  for (const EdgeId piece : {first, second}) {
    EXPECT_EQ(made->mesh.edge(piece).tag, 9);
    EXPECT_EQ(made->mesh.edge(piece).segment, before.segment);
  }
  EXPECT_EQ(testing::RegionAreas(made->mesh).at(1), 16);
  EXPECT_EQ(testing::RegionAreas(made->mesh).at(2), 18);
}

TEST(MeshEdit, CompactClosesGapsAndKeepsTheOrder) {
  const auto made = ImportedMesh(GridData(5, 5));
  RandomEditor editor(*made, 11);
  for (int step = 0; step < 400; ++step) editor.Step();
  ASSERT_EQ(Faults(made->mesh), "");
  ASSERT_LT(made->mesh.vertex_count(), made->mesh.vertex_slots()) << "the test needs gaps";
  std::vector<Vec2> expected;
  for (const VertexId id : testing::LiveVertices(made->mesh)) {
    expected.push_back(made->mesh.position(id));
  }
  const double area = Area(made->mesh);
  const std::vector<VertexId> numbers = made->edit.Compact();
  EXPECT_EQ(Faults(made->mesh), "");
  EXPECT_EQ(made->mesh.vertex_slots(), made->mesh.vertex_count());
  EXPECT_EQ(made->mesh.triangle_slots(), made->mesh.triangle_count());
  EXPECT_EQ(made->mesh.edge_slots(), made->mesh.edge_count());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(made->mesh.position(VertexId::FromIndex(i)), expected[i]);
  }
  std::int32_t next = 0;
  for (const VertexId number : numbers) {
    if (!number.valid()) continue;
    EXPECT_EQ(number.value(), next++);
  }
  EXPECT_EQ(next, made->mesh.vertex_count());
  EXPECT_NEAR(Area(made->mesh), area, 1e-12 * area);
}

TEST(MeshEdit, DoesNotReuseACommittedIdWithinTheRevisionThatRemovesIt) {
  const auto made = ImportedMesh(GridData(4, 4));
  (void)made->edit.Commit(Revision(1));
  RandomEditor editor(*made, 3);
  std::map<VertexId, Vec2> committed;
  for (const VertexId id : testing::LiveVertices(made->mesh)) {
    committed[id] = made->mesh.position(id);
  }
  std::vector<VertexId> removed;
  for (int step = 0; step < 300; ++step) {
    editor.Step();
    for (const auto& [id, position] : committed) {
      if (!made->mesh.IsLive(id)) removed.push_back(id);
    }
    for (const VertexId id : removed) ASSERT_FALSE(made->mesh.IsLive(id)) << id;
  }
  EXPECT_FALSE(removed.empty()) << "the test needs removals";
}

/// Edits at random and compares with oracles after every edit and at every commit and rollback.
void RunCampaign(const MeshData& data, std::uint64_t seed, int steps) {
  const auto made = ImportedMesh(data);
  ASSERT_EQ(Faults(made->mesh), "");
  const std::map<std::int32_t, double> areas = testing::RegionAreas(made->mesh);
  const std::map<std::int32_t, double> lengths = testing::TagLengths(made->mesh);
  RandomEditor editor(*made, seed);
  for (int i = 0; i < 30; ++i) editor.Step();

  Replica replica;
  std::int64_t revision = 1;
  ASSERT_EQ(replica.Apply(made->edit.Commit(Revision(revision))), "");
  Mesh committed = made->mesh;
  std::map<std::string, int> done;
  for (int step = 0; step < steps; ++step) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed << " step " << step
                                      << "; replay: core_tests --gtest_filter='MeshEdit.*Random*'");
    const std::string what = editor.Step();
    ++done[what];
    ASSERT_EQ(Faults(made->mesh), "") << "after " << what;
    if (editor.rng().Below(25) != 0) continue;
    if (editor.rng().Below(2) == 0) {
      made->edit.Rollback();
      ASSERT_EQ(DifferenceOf(made->mesh, committed), "") << "after rollback";
      ASSERT_TRUE(made->edit.log().empty());
    } else {
      const MeshDiff diff = made->edit.Commit(Revision(++revision));
      ASSERT_EQ(replica.Apply(diff), "");
      ASSERT_EQ(replica.DifferenceTo(made->mesh), "");
      ASSERT_EQ(diff.summary, SnapshotOf(made->mesh, Revision(revision)).summary);
      committed = made->mesh;
    }
    ASSERT_EQ(Faults(made->mesh), "");
  }
  for (const char* edit : {"swap", "split", "move", "slide", "remove", "metric"}) {
    EXPECT_GE(done[edit], 1) << edit << " never succeeds";
  }
  for (const auto& [region, area] : areas) {
    EXPECT_NEAR(testing::RegionAreas(made->mesh)[region], area, 1e-9 * area) << region;
  }
  for (const auto& [tag, length] : lengths) {
    EXPECT_NEAR(testing::TagLengths(made->mesh)[tag], length, 1e-9 * length) << tag;
  }
}

// Goal: no sequence of edits leaves an inconsistent mesh, loses a piece of a segment, or makes a
// diff that does not lead a replica to the same mesh; a rollback restores every bit.
// Method: random edits of a mesh with a hole, two regions and an internal constraint; oracles are
// Validate, a copy of the mesh, and a replica that only writes what diffs say.
TEST(MeshEdit, RandomEditsStayConsistentAndReversible) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) RunCampaign(TwoRegions(), seed, 2'000);
}

TEST(MeshEdit, RandomEditsOfATinyMeshStayConsistentAndReversible) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) RunCampaign(GridData(1, 1), seed, 1'000);
}

TEST(MeshEdit, RollbackWithoutChangesAndTwiceInARowIsHarmless) {
  const auto made = ImportedMesh(GridData(3, 3));
  (void)made->edit.Commit(Revision(1));
  const Mesh committed = made->mesh;
  made->edit.Rollback();
  EXPECT_EQ(DifferenceOf(made->mesh, committed), "");
  RandomEditor editor(*made, 5);
  for (int i = 0; i < 50; ++i) editor.Step();
  EXPECT_NE(DifferenceOf(made->mesh, committed), "");
  made->edit.Rollback();
  made->edit.Rollback();
  EXPECT_EQ(DifferenceOf(made->mesh, committed), "");
}

// Goal: the same edits after a rollback give the same slots, so that redo is bit for bit.
TEST(MeshEdit, RedoAfterRollbackTakesTheSameSlots) {
  const auto once = ImportedMesh(TwoRegions());
  const auto twice = ImportedMesh(TwoRegions());
  (void)once->edit.Commit(Revision(1));
  (void)twice->edit.Commit(Revision(1));
  RandomEditor undone(*twice, 99);
  for (int i = 0; i < 200; ++i) undone.Step();
  twice->edit.Rollback();
  RandomEditor a(*once, 42);
  RandomEditor b(*twice, 42);
  for (int i = 0; i < 300; ++i) {
    ASSERT_EQ(a.Step(), b.Step());
    ASSERT_EQ(DifferenceOf(once->mesh, twice->mesh), "") << "step " << i;
  }
}

}  // namespace
}  // namespace pliant
