// Goal: nodes taken away in bulk, where a metric becomes much coarser, leave a lattice, a valid
// mesh and whatever must not go.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/metric/function_field.h"
#include "core/pliant/loop.h"
#include "core/pliant/quality.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::DifferenceOf;
using testing::Faults;

/// A mesh that has converged for a constant size, and then is to be for twice that.
struct Coarser {
  explicit Coarser(int fine_nodes, const Options& options = {})
      : field(std::move(testing::DiscCase(fine_nodes, testing::DiscState::kOff).field)),
        made(testing::DomainMesh(testing::DiscCase(fine_nodes, testing::DiscState::kOff).domain)),
        loop(made->edit, options) {
    Begin(options);
    loop.Run(*field, {});
    (void)made->edit.Commit(Revision{1});
    field = std::move(testing::DiscCase(fine_nodes / 4, testing::DiscState::kOff).field);
  }
  /// Begins an update with every vertex awake.
  void Begin(const Options& options) {
    loop.BeginUpdate(SettingsOf(options));
    loop.ResetCounts();
    for (const VertexId id : testing::LiveVertices(made->mesh)) {
      std::int32_t hint = -1;
      made->edit.SetMetric(id, field->At(made->mesh.position(id), hint));
      loop.Wake(id);
    }
  }
  std::unique_ptr<MetricField> field;
  std::unique_ptr<testing::EditedMesh> made;
  PliantLoop loop;
};

// Method: the same update with and without; both must end with as many nodes and as good a mesh,
// the one with less than three quarters of the visits.
TEST(ThinOut, SavesVisitsWhereTheMetricBecomesTwiceAsCoarse) {
  std::int64_t visits[2] = {};
  Quality quality[2];
  for (const bool thins : {false, true}) {
    Coarser session(8'000);
    const std::int32_t before = session.made->mesh.vertex_count();
    session.Begin({});
    if (thins) {
      session.loop.ThinOut(testing::LiveVertices(session.made->mesh));
      EXPECT_LT(session.made->mesh.vertex_count(), 0.4 * before);
      EXPECT_EQ(session.loop.counts().deletions, before - session.made->mesh.vertex_count());
      EXPECT_EQ(session.loop.counts().visits, 0);
      EXPECT_EQ(Faults(session.made->mesh), "");
    }
    EXPECT_EQ(session.loop.Run(*session.field, {}), StopReason::kConverged);
    EXPECT_EQ(Faults(session.made->mesh), "");
    visits[thins ? 1 : 0] = session.loop.counts().visits;
    quality[thins ? 1 : 0] = MeasureQuality(session.made->mesh, *session.field);
  }
  EXPECT_LT(4 * visits[1], 3 * visits[0]);
  const auto nodes = static_cast<double>(quality[0].vertex_count);
  EXPECT_NEAR(static_cast<double>(quality[1].vertex_count), nodes, 0.02 * nodes);
  EXPECT_GT(quality[1].q_mean, quality[0].q_mean - 0.002);
  EXPECT_GT(quality[1].averaged.share_125, quality[0].averaged.share_125 - 0.005);
}

/// Rows of equilateral triangles, `count` vertices in each row and column, of edge length 1.
MeshData Lattice(std::int32_t count) {
  MeshData data;
  for (std::int32_t row = 0; row < count; ++row) {
    for (std::int32_t column = 0; column < count; ++column) {
      data.points.push_back({column + 0.5 * row, 0.5 * std::sqrt(3.0) * row});
    }
  }
  for (std::int32_t row = 0; row + 1 < count; ++row) {
    for (std::int32_t column = 0; column + 1 < count; ++column) {
      const std::int32_t a = row * count + column;
      data.triangles.push_back({a, a + 1, a + count});
      data.triangles.push_back({a + 1, a + count + 1, a + count});
    }
  }
  return data;
}

// Method: inside a lattice of 41 rows every second vertex of every second row is left, or of their
// likes one further: nowhere two neighbours, nowhere more than one step off.
TEST(ThinOut, LeavesALatticeOfTwiceTheWidth) {
  constexpr std::int32_t kCount = 41;
  const auto made = testing::ImportedMesh(Lattice(kCount));
  PliantLoop loop(made->edit, {});
  loop.BeginUpdate(SettingsOf({}));
  for (const VertexId id : testing::LiveVertices(made->mesh)) {
    made->edit.SetMetric(id, Metric::Isotropic(2));
    loop.Wake(id);
  }
  loop.ThinOut(testing::LiveVertices(made->mesh));
  EXPECT_EQ(Faults(made->mesh), "");
  std::int32_t left[2][2] = {};
  std::int32_t all = 0;
  for (const VertexId id : testing::LiveVertices(made->mesh)) {
    const std::int32_t row = id.value() / kCount;
    const std::int32_t column = id.value() % kCount;
    if (row < 3 || row >= kCount - 3 || column < 3 || column >= kCount - 3) continue;
    ++left[row % 2][column % 2];
    ++all;
  }
  EXPECT_NEAR(all, 35 * 35 / 4, 35);
  int classes = 0;
  for (const auto& row : left) {
    for (const std::int32_t count : row) classes += count > 0 ? 1 : 0;
  }
  EXPECT_EQ(classes, 1);
}

TEST(ThinOut, IsUndoneByARollback) {
  Coarser session(2'000);
  const Mesh before = session.made->mesh;
  session.Begin({});
  session.loop.ThinOut(testing::LiveVertices(session.made->mesh));
  EXPECT_LT(session.made->mesh.vertex_count(), before.vertex_count());
  session.made->edit.Rollback();
  EXPECT_EQ(DifferenceOf(session.made->mesh, before), "");
}

// Method: every third vertex inside is frozen; permissions that refuse something refuse all of it.
TEST(ThinOut, LeavesWhatMustNotGo) {
  for (const bool may_insert : {true, false}) {
    Options options;
    Coarser session(2'000, options);
    const Mesh& mesh = session.made->mesh;
    options.permissions.insert = may_insert;
    session.loop.SetOptions(options);
    session.Begin(options);
    std::vector<VertexId> kept;
    for (const VertexId id : testing::LiveVertices(mesh)) {
      const VertexRecord& record = mesh.vertex(id);
      if (id.value() % 3 == 0) session.made->edit.SetHold(id, MeshEdit::Hold::kFrozen);
      if (record.fixed || record.edge.valid() || record.frozen) kept.push_back(id);
    }
    const std::int32_t before = mesh.vertex_count();
    session.loop.ThinOut(testing::LiveVertices(mesh));
    EXPECT_EQ(mesh.vertex_count() < before, may_insert);
    for (const VertexId id : kept) EXPECT_TRUE(mesh.IsLive(id)) << id.value();
    EXPECT_EQ(Faults(mesh), "");
  }
}

}  // namespace
}  // namespace pliant
