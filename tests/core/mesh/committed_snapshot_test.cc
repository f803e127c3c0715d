#include "core/mesh/committed_snapshot.h"

#include <gtest/gtest.h>

#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::GridData;
using testing::ImportedMesh;
using testing::RandomEditor;

// Method: the snapshot of a mesh at its commit, and again after random edits without a commit.
TEST(CommittedSnapshot, DoesNotSeeWhatIsNotCommitted) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    const auto made = ImportedMesh(GridData(5, 4));
    RandomEditor editor(*made, seed);
    (void)made->edit.Commit(Revision(1));
    for (int i = 0; i < 40; ++i) editor.Step();
    (void)made->edit.Commit(Revision(2));
    const MeshDiff expected = SnapshotOf(made->mesh, Revision(2));
    for (int i = 0; i < 80; ++i) editor.Step();
    EXPECT_NE(SnapshotOf(made->mesh, Revision(2)).summary, expected.summary);
    const MeshDiff snapshot = CommittedSnapshot(made->edit, Revision(2));
    EXPECT_EQ(snapshot.summary, expected.summary);
    EXPECT_EQ(snapshot.revision, Revision(2));
    EXPECT_EQ(snapshot.base_revision, Revision::kNone);
    EXPECT_EQ(snapshot.vertex_ids, expected.vertex_ids);
    EXPECT_EQ(snapshot.vertex_positions, expected.vertex_positions);
    EXPECT_EQ(snapshot.metrics, expected.metrics);
    EXPECT_EQ(snapshot.triangle_ids, expected.triangle_ids);
    EXPECT_EQ(snapshot.triangle_vertices, expected.triangle_vertices);
    EXPECT_EQ(snapshot.triangle_regions, expected.triangle_regions);
    EXPECT_EQ(snapshot.edge_ids, expected.edge_ids);
    EXPECT_EQ(snapshot.edge_vertices, expected.edge_vertices);
    EXPECT_EQ(snapshot.edge_tags, expected.edge_tags);
  }
}

}  // namespace
}  // namespace pliant
