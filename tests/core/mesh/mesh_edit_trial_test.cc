// MeshEdit's trials and what it does to segments (core/mesh/mesh_edit_trial.cc).

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/mesh_edit.h"
#include "core/mesh/validate.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::DifferenceOf;
using testing::Faults;

void RandomSteps(testing::RandomEditor& editor, int count) {
  for (int i = 0; i < count; ++i) editor.Step();
}

/// A trial comes after other changes of its revision, or is the first of them.
int StepsBefore(int revision, std::uint64_t seed) {
  return (static_cast<std::uint64_t>(revision) + seed) % 2 == 0 ? 20 : 0;
}

// Goal: an undone trial leaves no trace, whatever the revision changed before and changes after:
// not in the mesh, nor in what a rollback or a commit gives.
// Method: two meshes get the same random edits, and one of them trials in between.
TEST(MeshEditTrial, UndoneLeavesNoTrace) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    auto plain = testing::ImportedMesh(testing::GridData(5, 5));
    auto tried = testing::ImportedMesh(testing::GridData(5, 5));
    testing::RandomEditor plain_editor(*plain, seed);
    testing::RandomEditor tried_editor(*tried, seed);
    for (int revision = 1; revision <= 4; ++revision) {
      const int before = StepsBefore(revision, seed);
      RandomSteps(plain_editor, before);
      RandomSteps(tried_editor, before);
      testing::RandomEditor other(*tried, seed + 1000);
      MeshEdit::Trial trial = tried->edit.BeginTrial();
      RandomSteps(other, 60);
      ASSERT_EQ(Faults(tried->mesh), "");
      tried->edit.Undo(std::move(trial));
      ASSERT_EQ(DifferenceOf(plain->mesh, tried->mesh), "");
      RandomSteps(plain_editor, 20);
      RandomSteps(tried_editor, 20);
      ASSERT_EQ(DifferenceOf(plain->mesh, tried->mesh), "");
      if (revision == 3) {
        plain->edit.Rollback();
        tried->edit.Rollback();
      } else {
        const MeshDiff a = plain->edit.Commit(Revision(revision));
        const MeshDiff b = tried->edit.Commit(Revision(revision));
        ASSERT_EQ(a.vertex_ids, b.vertex_ids);
        ASSERT_EQ(a.removed_triangles, b.removed_triangles);
        ASSERT_EQ(a.summary.state_hash, b.summary.state_hash);
      }
      ASSERT_EQ(DifferenceOf(plain->mesh, tried->mesh), "");
    }
  }
}

// Goal: a trial that is kept is as if its changes had been made without it.
TEST(MeshEditTrial, KeptIsAsIfThereHadBeenNone) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    auto plain = testing::ImportedMesh(testing::GridData(5, 5));
    auto tried = testing::ImportedMesh(testing::GridData(5, 5));
    testing::RandomEditor plain_editor(*plain, seed);
    testing::RandomEditor tried_editor(*tried, seed);
    for (int revision = 1; revision <= 4; ++revision) {
      const int before = StepsBefore(revision, seed);
      RandomSteps(plain_editor, before + 30);
      RandomSteps(tried_editor, before);
      MeshEdit::Trial trial = tried->edit.BeginTrial();
      RandomSteps(tried_editor, 30);
      tried->edit.Keep(std::move(trial));
      ASSERT_EQ(DifferenceOf(plain->mesh, tried->mesh), "");
      if (revision == 3) {
        plain->edit.Rollback();
        tried->edit.Rollback();
      } else {
        ASSERT_EQ(plain->edit.Commit(Revision(revision)).summary.state_hash,
                  tried->edit.Commit(Revision(revision)).summary.state_hash);
      }
      ASSERT_EQ(DifferenceOf(plain->mesh, tried->mesh), "");
    }
  }
}

/// A side of the bottom of GridData(4, 1): from (0, 0) to (4, 0), one segment.
TEST(MeshEditTrial, CuttingASegmentKeepsEveryVertexWhereItIs) {
  auto grid = testing::ImportedMesh(testing::GridData(4, 1));
  const Mesh& mesh = grid->mesh;
  ASSERT_FALSE(mesh.vertex(VertexId(2)).fixed);
  (void)grid->edit.Commit(Revision(1));
  const auto before = testing::ImportedMesh(testing::GridData(4, 1));
  (void)before->edit.Commit(Revision(1));
  const std::size_t segments = mesh.segments().size();

  grid->edit.CutSegment(VertexId(2));
  EXPECT_EQ(mesh.segments().size(), segments + 1);
  EXPECT_TRUE(mesh.vertex(VertexId(2)).fixed);
  EXPECT_EQ(Faults(mesh), "");
  // Now it may leave the line, and the others ride along.
  grid->edit.PlaceVertex(VertexId(2), {2, -0.5});
  for (const std::int32_t v : {1, 3}) {
    const auto [edge, after] = mesh.SegmentEdges(VertexId(v));
    EXPECT_NEAR(mesh.edge(edge).parameters[1], 0.5, 1e-15);
    grid->edit.PlaceVertex(VertexId(v), mesh.PointOnSegment(mesh.edge(edge).segment, 0.5));
    EXPECT_LT(Length(mesh.position(VertexId(v)) - Vec2{v == 1 ? 1.0 : 3.0, -0.25}), 1e-15);
  }
  EXPECT_EQ(Faults(mesh), "");

  grid->edit.CutSegment(VertexId(1));
  EXPECT_EQ(Faults(mesh), "");
  grid->edit.Rollback();
  EXPECT_EQ(DifferenceOf(mesh, before->mesh), "");
  EXPECT_EQ(mesh.segments().size(), segments);
  EXPECT_EQ(Faults(mesh), "");
}

TEST(MeshEditTrial, AParameterIsWrittenIntoBothEdges) {
  auto grid = testing::ImportedMesh(testing::GridData(4, 1));
  grid->edit.SetParameter(VertexId(2), 0.6);
  grid->edit.PlaceVertex(VertexId(2), {2.4, 0});
  EXPECT_EQ(Faults(grid->mesh), "");
  const auto [before, after] = grid->mesh.SegmentEdges(VertexId(2));
  EXPECT_EQ(grid->mesh.edge(before).parameters[1], 0.6);
  EXPECT_EQ(grid->mesh.edge(after).parameters[0], 0.6);
}

}  // namespace
}  // namespace pliant
