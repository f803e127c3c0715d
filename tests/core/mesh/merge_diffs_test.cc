#include "core/mesh/merge_diffs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::GridData;
using testing::ImportedMesh;
using testing::RandomEditor;

/// The revisions of a mesh that a random editor works on, some of them without a change.
std::vector<MeshDiff> RandomRevisions(testing::EditedMesh& made, std::uint64_t seed, int count) {
  RandomEditor editor(made, seed);
  std::vector<MeshDiff> diffs;
  for (int revision = 1; revision <= count; ++revision) {
    const std::uint64_t edits = revision == 1 ? 0 : editor.rng().Below(60);
    for (std::uint64_t i = 0; i < edits; ++i) editor.Step();
    diffs.push_back(made.edit.Commit(Revision(revision)));
  }
  return diffs;
}

/// One kind of element of a client that writes what it is told; counts what it cannot remove.
template <class Id, class Value>
struct Column {
  std::map<Id, Value> rows;
  int missing = 0;

  void Apply(const std::vector<Id>& removed, const std::vector<Id>& ids,
             const std::vector<Value>& values) {
    for (const Id id : removed) missing += rows.erase(id) == 0;
    for (std::size_t i = 0; i < ids.size(); ++i) rows[ids[i]] = values[i];
  }
};

struct Jumper {
  Column<VertexId, Vec2> vertices;
  Column<TriangleId, std::array<VertexId, 3>> triangles;
  Column<EdgeId, std::array<VertexId, 2>> edges;
  std::map<VertexId, Metric> metrics;

  void Apply(const MeshDiff& diff) {
    vertices.Apply(diff.removed_vertices, diff.vertex_ids, diff.vertex_positions);
    triangles.Apply(diff.removed_triangles, diff.triangle_ids, diff.triangle_vertices);
    edges.Apply(diff.removed_edges, diff.edge_ids, diff.edge_vertices);
    for (const VertexId id : diff.removed_vertices) metrics.erase(id);
    for (std::size_t i = 0; i < diff.metrics.size(); ++i) {
      metrics[diff.metric_vertex_ids[i]] = diff.metrics[i];
    }
  }
  [[nodiscard]] int missing() const { return vertices.missing + triangles.missing + edges.missing; }
};

// Goal: a merged diff does what its parts do, and removes nothing that a client has not.
// Method: a client follows random revisions in random jumps of merged diffs; one that takes the
// snapshot at the end must have the same.
TEST(MergeDiffs, DoesWhatItsPartsDo) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    const auto made = ImportedMesh(GridData(5, 4));
    const std::vector<MeshDiff> diffs = RandomRevisions(*made, seed, 20);
    Rng rng(seed);
    Jumper jumper;
    for (std::size_t next = 0; next < diffs.size();) {
      const std::size_t end = std::min(diffs.size(), next + 1 + rng.Below(6));
      MeshDiff merged = diffs[next];
      for (std::size_t i = next + 1; i < end; ++i) merged = MergeDiffs(merged, diffs[i]);
      jumper.Apply(merged);
      ASSERT_EQ(jumper.missing(), 0);
      ASSERT_EQ(merged.revision, diffs[end - 1].revision);
      ASSERT_EQ(merged.summary, diffs[end - 1].summary);
      next = end;
    }
    Jumper fresh;
    fresh.Apply(SnapshotOf(made->mesh, Revision(20)));
    EXPECT_EQ(jumper.vertices.rows, fresh.vertices.rows);
    EXPECT_EQ(jumper.triangles.rows, fresh.triangles.rows);
    EXPECT_EQ(jumper.edges.rows, fresh.edges.rows);
    EXPECT_EQ(jumper.metrics, fresh.metrics);
  }
}

TEST(MergeDiffs, TheOrderOfMergingDoesNotMatter) {
  const auto made = ImportedMesh(GridData(5, 4));
  const std::vector<MeshDiff> d = RandomRevisions(*made, /*seed=*/7, 4);
  const MeshDiff left = MergeDiffs(MergeDiffs(d[1], d[2]), d[3]);
  const MeshDiff right = MergeDiffs(d[1], MergeDiffs(d[2], d[3]));
  EXPECT_EQ(left.vertex_ids, right.vertex_ids);
  EXPECT_EQ(left.removed_triangles, right.removed_triangles);
  EXPECT_EQ(left.triangle_ids, right.triangle_ids);
  EXPECT_EQ(left.triangle_vertices, right.triangle_vertices);
  EXPECT_EQ(left.created_triangles, right.created_triangles);
  EXPECT_EQ(left.created_edges, right.created_edges);
  EXPECT_EQ(left.metric_vertex_ids, right.metric_vertex_ids);
}

// Goal: what came and went in between is absent, and what went and came again is written.
TEST(MergeDiffs, LeavesOutWhatCameAndWent) {
  MeshDiff first;
  first.base_revision = Revision(3);
  first.revision = Revision(4);
  first.removed_vertices = {VertexId(5), VertexId(6)};
  first.vertex_ids = {VertexId(1), VertexId(2), VertexId(8)};
  first.vertex_positions = {{1, 0}, {2, 0}, {8, 0}};
  first.created_vertices = {VertexId(2), VertexId(8)};
  first.metric_vertex_ids = {VertexId(2), VertexId(7), VertexId(8)};
  first.metrics = {Metric::Isotropic(1), Metric::Isotropic(2), Metric::Isotropic(3)};
  MeshDiff second;
  second.base_revision = Revision(4);
  second.revision = Revision(9);
  second.removed_vertices = {VertexId(1), VertexId(2), VertexId(7)};
  second.vertex_ids = {VertexId(6), VertexId(9)};
  second.vertex_positions = {{6, 1}, {9, 1}};
  second.created_vertices = {VertexId(6), VertexId(9)};
  const MeshDiff merged = MergeDiffs(first, second);
  EXPECT_EQ(merged.base_revision, Revision(3));
  EXPECT_EQ(merged.revision, Revision(9));
  EXPECT_EQ(merged.removed_vertices, (std::vector{VertexId(1), VertexId(5), VertexId(7)}));
  EXPECT_EQ(merged.vertex_ids, (std::vector{VertexId(6), VertexId(8), VertexId(9)}));
  EXPECT_EQ(merged.vertex_positions[0].y, 1);
  EXPECT_EQ(merged.vertex_positions[1].x, 8);
  EXPECT_EQ(merged.created_vertices, (std::vector{VertexId(8), VertexId(9)}));
  EXPECT_EQ(merged.metric_vertex_ids, (std::vector{VertexId(8)}));
  EXPECT_EQ(merged.metrics[0], Metric::Isotropic(3));
}

TEST(MergeDiffs, AFirstCommitCreatesEverything) {
  const auto made = ImportedMesh(GridData(5, 4));
  const std::vector<MeshDiff> d = RandomRevisions(*made, /*seed=*/3, 12);
  MeshDiff merged = d[0];
  for (std::size_t i = 1; i < d.size(); ++i) merged = MergeDiffs(merged, d[i]);
  EXPECT_TRUE(merged.removed_vertices.empty());
  EXPECT_TRUE(merged.removed_triangles.empty());
  const MeshDiff snapshot = SnapshotOf(made->mesh, Revision(12));
  EXPECT_EQ(merged.vertex_ids, snapshot.vertex_ids);
  EXPECT_EQ(merged.triangle_vertices, snapshot.triangle_vertices);
  EXPECT_EQ(merged.metric_vertex_ids, snapshot.metric_vertex_ids);
}

TEST(BytesOf, CountsTheColumns) {
  MeshDiff diff;
  const std::size_t empty = BytesOf(diff);
  diff.vertex_ids.resize(10, VertexId(0));
  diff.vertex_positions.resize(10);
  EXPECT_EQ(BytesOf(diff), empty + 200);
}

}  // namespace
}  // namespace pliant
