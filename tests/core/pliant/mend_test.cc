#include "core/pliant/mend.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/stoppable_executor.h"
#include "core/delaunay/import_mesh.h"
#include "core/mesh/export_mesh.h"
#include "core/mesh/validate.h"
#include "core/metric/function_field.h"
#include "core/pliant/quality.h"
#include "core/pliant/remesher.h"
#include "tests/support/backward_executor.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"
#include "tests/support/stop_after.h"

namespace pliant {
namespace {

std::unique_ptr<Remesher> BuiltFrom(testing::Case test_case, const Options& options = {}) {
  auto remesher = Remesher::Create(test_case.domain, std::move(test_case.field), options);
  EXPECT_EQ(remesher.value()->Step(Budget{})->stop_reason, StopReason::kConverged);
  return std::move(remesher).value();
}

/// A mesh of the given triangles over a constant metric of size 1, with a mender for it.
struct Patchwork {
  explicit Patchwork(const MeshData& data) : edit(mesh), mender(edit, Permissions{}) {
    BuildFromPlan(*PlanImport(data), edit);
    for (std::int32_t v = 0; v < mesh.vertex_slots(); ++v) {
      edit.SetMetric(VertexId(v), Metric::Isotropic(1));
    }
  }
  void Run() {
    EXPECT_TRUE(mender.Start(0, 0, alone));
    while (!mender.done()) mender.VisitNext(field);
    EXPECT_TRUE(Validate(mesh).empty());
  }

  static Metric UnitMetric(Vec2) { return Metric::Isotropic(1); }

  FunctionField<Metric (*)(Vec2)> field{&UnitMetric};
  InlineExecutor alone;
  Mesh mesh;
  MeshEdit edit;
  Mender mender;
};

/// A hexagon of circumradius 1 around a vertex that stands at `center`.
MeshData Hexagon(Vec2 center) {
  MeshData data;
  for (int k = 0; k < 6; ++k) {
    const double angle = k * std::acos(-1.0) / 3;
    data.points.push_back({std::cos(angle), std::sin(angle)});
    data.triangles.push_back({k, (k + 1) % 6, 6});
  }
  data.points.push_back(center);
  return data;
}

// Goal: what no smoothing cures is cured: in every case of the peer benchmark the worst triangle
// and the longest edge are good enough, but at the corners of the domain.
TEST(Mender, CuresTheTail) {
  for (const double n : {2000.0, 5000.0, 10000.0}) {
    for (const auto& make :
         {&testing::GaussianCase, &testing::DiagonalCase, &testing::SharpShockCase}) {
      const auto remesher = BuiltFrom(make(n));
      const Quality quality = MeasureQuality(remesher->mesh(), remesher->field());
      EXPECT_GE(quality.q_min, 0.75);
      EXPECT_LE(quality.averaged.max, 1.5);
      EXPECT_GE(quality.averaged.min, 0.6);
    }
  }
}

// Goal: a node in a place that makes a flat triangle is brought back to a good one.
TEST(Mender, MovesANodeToWhereItsTrianglesAreGood) {
  Patchwork patchwork(Hexagon({0.6, 0.3}));
  patchwork.Run();
  const Quality quality = MeasureQuality(patchwork.mesh, patchwork.field);
  EXPECT_GE(quality.q_min, 0.8);
  EXPECT_TRUE(patchwork.mesh.vertex(VertexId(6)).visit.mended);
}

// Goal: what is good enough keeps its place bit for bit, even if it is not best.
TEST(Mender, LeavesGoodNodesWhereTheyAre) {
  const Vec2 place{0.05, -0.04};
  Patchwork patchwork(Hexagon(place));
  patchwork.Run();
  EXPECT_EQ(patchwork.mesh.position(VertexId(6)), place);
  EXPECT_FALSE(patchwork.mesh.vertex(VertexId(6)).visit.mended);
}

// Goal: where the metric has changed, only just good enough is not enough; where it has not, it is,
// so that a last short step of some node does not call for mending.
TEST(Mender, AsksForMoreWhereTheMetricHasChanged) {
  const Vec2 place{0, 0.425};
  Patchwork patchwork(Hexagon(place));
  const double before = MeasureQuality(patchwork.mesh, patchwork.field).q_min;
  ASSERT_GT(before, 0.8);
  ASSERT_LT(before, 0.8 * 1.03);
  for (std::int32_t v = 0; v < 7; ++v) patchwork.edit.Visit(VertexId(v)).cold = true;
  patchwork.Run();
  EXPECT_EQ(patchwork.mesh.position(VertexId(6)), place);
  patchwork.edit.Visit(VertexId(6)).cold = false;
  patchwork.Run();
  EXPECT_GT(MeasureQuality(patchwork.mesh, patchwork.field).q_min, 0.8 * 1.03);
}

// Goal: the wrong diagonal of a rhombus is swapped for the right one.
TEST(Mender, SwapsALongDiagonal) {
  const double h = std::sqrt(3.0) / 2;
  MeshData data;
  data.points = {{-h, 0}, {0, -0.5}, {h, 0}, {0, 0.5}};
  data.triangles = {{0, 1, 2}, {0, 2, 3}};
  Patchwork patchwork(data);
  patchwork.Run();
  EXPECT_NEAR(MeasureQuality(patchwork.mesh, patchwork.field).q_min, 1, 1e-12);
}

// Goal: mending ends where it cannot help: a needle stays, and everything else with it.
TEST(Mender, EndsWhereNothingHelps) {
  MeshData data;
  data.points = {{0, 0}, {10, 0}, {10, 0.1}};
  data.triangles = {{0, 1, 2}};
  Patchwork patchwork(data);
  patchwork.Run();
  EXPECT_EQ(ExportMesh(patchwork.mesh).data.points, data.points);
}

/// Seven given vertices 0.2 apart, a node 0.9 away from them, and what lies around.
struct RowOfGiven : Patchwork {
  static constexpr std::int32_t kCount = 12;

  RowOfGiven() : Patchwork(Data()) {
    for (std::int32_t v = 0; v + 1 < kCount; ++v) {
      if (!mesh.vertex(VertexId(v)).fixed) edit.Fix(VertexId(v));
    }
  }
  static MeshData Data() {
    MeshData data;
    for (int k = -3; k <= 3; ++k) data.points.push_back({0.2 * k, 0.005 * k * k});
    for (const Vec2 p : {Vec2{1, 0.9}, {0.5, 1.85}, {-0.5, 1.85}, {-1, 0.9}, {0, 0.9}}) {
      data.points.push_back(p);
    }
    for (int k = 0; k + 1 < kCount; ++k) {
      data.triangles.push_back({k, (k + 1) % (kCount - 1), kCount - 1});
    }
    return data;
  }
};

// Goal: between given vertices that are crowded and a node that is too far from them nodes come in,
// which the loop leaves alone; a limit of vertices and a client who forbids it are respected.
TEST(Mender, PutsNodesBesideCrowdedVertices) {
  RowOfGiven free;
  const double before = MeasureQuality(free.mesh, free.field).q_min;
  ASSERT_LT(before, 0.36);
  free.Run();
  EXPECT_GT(free.mesh.vertex_count(), RowOfGiven::kCount);
  EXPECT_LE(free.mesh.vertex_count(), RowOfGiven::kCount + 4);
  EXPECT_TRUE(free.mesh.vertex(VertexId(RowOfGiven::kCount)).visit.mended);
  EXPECT_GT(MeasureQuality(free.mesh, free.field).q_min, before + 0.1);

  RowOfGiven limited;
  limited.mender.LimitVertices(RowOfGiven::kCount);
  limited.Run();
  EXPECT_EQ(limited.mesh.vertex_count(), RowOfGiven::kCount);
  RowOfGiven forbidden;
  forbidden.mender.Permit(Permissions{.insert = false});
  forbidden.Run();
  EXPECT_EQ(forbidden.mesh.vertex_count(), RowOfGiven::kCount);
}

// Goal: a client that forbids moves gets none from mending either.
TEST(Mender, RespectsPermissions) {
  Patchwork patchwork(Hexagon({0.6, 0.3}));
  Mender mender(patchwork.edit, Permissions{.move = false});
  EXPECT_TRUE(mender.Start(0, 0, patchwork.alone));
  EXPECT_TRUE(mender.done());
}

// Goal: an update looks only where something has changed.
TEST(Mender, LooksOnlyAtWhatHasChangedAfterACommit) {
  Patchwork patchwork(Hexagon({0.6, 0.3}));
  patchwork.edit.Commit(Revision{1});
  EXPECT_TRUE(patchwork.mender.Start(0, 0, patchwork.alone));
  EXPECT_TRUE(patchwork.mender.done());
  patchwork.edit.MoveVertex(VertexId(6), {0.6, 0.2});
  EXPECT_TRUE(patchwork.mender.Start(0, 0, patchwork.alone));
  EXPECT_FALSE(patchwork.mender.done());
}

// Goal: what was put elsewhere without a visit of the loop is not looked at, because whoever
// carries it along has looked; what the loop has reached is.
TEST(Mender, LooksOnlyAtWhatTheLoopHasReached) {
  Patchwork patchwork(Hexagon({0.6, 0.3}));
  patchwork.edit.Commit(Revision{1});
  patchwork.edit.Visit(VertexId(6)).epoch = 4;
  EXPECT_TRUE(patchwork.mender.Start(4, 5, patchwork.alone));
  EXPECT_TRUE(patchwork.mender.done());
  EXPECT_TRUE(patchwork.mender.Start(4, 4, patchwork.alone));
  EXPECT_FALSE(patchwork.mender.done());
}

// Goal: where a whole mesh has changed, somebody who wants the update to end is asked every few
// thousand vertices, and then nobody waits; who looks again finds what he would have found, by any
// executor. Method: stopped at every look, against one that nobody disturbed.
TEST(Mender, CanBeStoppedWhileItLooks) {
  const auto make = [] {
    auto patchwork = std::make_unique<Patchwork>(testing::GridData(250, 250));
    patchwork->edit.Commit(Revision{1});
    for (std::int32_t v = 0; v < patchwork->mesh.vertex_slots(); ++v) {
      patchwork->edit.SetMetric(VertexId(v), Metric::Isotropic(v % 100 == 7 ? 2 : 1));
    }
    return patchwork;
  };
  const auto undisturbed = make();
  ASSERT_TRUE(undisturbed->mender.Start(0, 0, undisturbed->alone));
  ASSERT_FALSE(undisturbed->mender.done());
  const auto stopped = make();
  testing::BackwardExecutor backward;
  int stops = 0;
  for (;; ++stops) {
    const testing::StopAfter stop(stops + 1);
    StoppableExecutor executor(backward, &stop);
    if (stopped->mender.Start(0, 0, executor)) break;
    ASSERT_TRUE(stopped->mender.done());
  }
  EXPECT_GE(stops, stopped->mesh.vertex_slots() / Chunks::kLength);
  EXPECT_EQ(stopped->mender.state().waiting, undisturbed->mender.state().waiting);
}

// Goal: before the first commit all triangles are looked at, or those at vertices reached since an
// epoch, by any executor alike: the vertices that wait are the same.
// Method: a strip of more than one chunk of triangles, of which every tenth is flat.
TEST(Mender, LooksAtPartsOfTheMeshAlike) {
  constexpr std::int32_t kTriangles = 20000;
  MeshData strip;
  for (std::int32_t k = 0; k < kTriangles + 2; ++k) {
    strip.points.push_back({0.5 * k, k % 2 == 0 ? 0 : (k % 20 == 11 ? 0.1 : 0.866)});
  }
  for (std::int32_t k = 0; k < kTriangles; ++k) {
    strip.triangles.push_back(k % 2 == 0 ? std::array{k, k + 2, k + 1}
                                         : std::array{k, k + 1, k + 2});
  }
  Patchwork patchwork(strip);
  EXPECT_TRUE(patchwork.mender.Start(0, 0, patchwork.alone));
  const std::size_t all = patchwork.mender.waiting_count();
  EXPECT_GT(all, 2000U);
  testing::BackwardExecutor reversed;
  Mender other(patchwork.edit, Permissions{});
  EXPECT_TRUE(other.Start(0, 0, reversed));
  EXPECT_EQ(other.state().waiting, patchwork.mender.state().waiting);

  patchwork.edit.Visit(VertexId(19991)).epoch = 3;
  Mender late(patchwork.edit, Permissions{});
  EXPECT_TRUE(late.Start(0, 3, reversed));
  EXPECT_GT(late.waiting_count(), 0U);
  EXPECT_LT(late.waiting_count(), 10U);
}

// Goal: what is mended stays: updates that wake every node again without a change of the metric
// leave the worst triangle and the longest edge as good as they were.
TEST(Mender, IsNotUndoneByTheLoop) {
  auto remesher = BuiltFrom(testing::ShockCase(4000));
  remesher->Commit();
  for (int round = 0; round < 5; ++round) {
    std::vector<VertexId> vertices;
    std::vector<Metric> tensors;
    for (std::int32_t v = 0; v < remesher->mesh().vertex_slots(); ++v) {
      if (!remesher->mesh().IsLive(VertexId(v)) || v % 5 != round) continue;
      vertices.emplace_back(v);
      // More than the tolerance, so that the nodes wake, and back again.
      tensors.push_back((round % 2 == 0 ? 1.06 : 0.94) * remesher->mesh().metric(VertexId(v)));
    }
    ASSERT_TRUE(remesher->SetTensors(vertices, tensors).ok());
    ASSERT_EQ(remesher->Step(Budget{})->stop_reason, StopReason::kConverged);
    remesher->Commit();
    const Quality quality = MeasureQuality(remesher->mesh(), remesher->field());
    EXPECT_GE(quality.q_min, 0.7) << "round " << round;
    EXPECT_LE(quality.averaged.max, 1.55) << "round " << round;
  }
}

}  // namespace
}  // namespace pliant
