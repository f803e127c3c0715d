#include "core/pliant/loop.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::Case;
using testing::DomainMesh;
using testing::EditedMesh;
using testing::Faults;

/// A mesh, its loop and its field, every vertex awake.
struct Session {
  Session(Case from, const Options& options)
      : field(std::move(from.field)), made(DomainMesh(from.domain)), loop(made->edit, options) {
    loop.BeginUpdate(SettingsOf(options));
    WakeAll();
  }
  void WakeAll() {
    for (const VertexId id : testing::LiveVertices(made->mesh)) {
      std::int32_t hint = -1;
      made->edit.SetMetric(id, field->At(made->mesh.position(id), hint));
      loop.Wake(id);
    }
  }
  std::unique_ptr<MetricField> field;
  std::unique_ptr<EditedMesh> made;
  PliantLoop loop;
};

int AgeOf(const Mesh& mesh, VertexId id, std::uint32_t epoch) {
  const VisitState& visit = mesh.vertex(id).visit;
  return visit.epoch == epoch ? visit.age : 0;
}

/// Sum over live vertices of 3^(B - age): exact in a double for B = 12 and some thousand nodes.
double Potential(const Mesh& mesh, int age_max, std::uint32_t epoch) {
  double sum = 0;
  for (const VertexId id : testing::LiveVertices(mesh)) {
    sum += std::pow(3.0, age_max - AgeOf(mesh, id, epoch));
  }
  return sum;
}

// Goal: the two facts that the proof of termination rests on: every visit lowers the potential, and
// what it makes is at least as old as the visited node is then. Method: a metric that no mesh can
// meet, one visit at a time, everything recomputed from the mesh.
TEST(PliantLoop, EveryVisitLowersThePotentialAndNewNodesAreAsOldAsTheirMaker) {
  Options options;
  options.variant = Variant::kCooled;
  options.age_max = 12;
  options.age_cooling = 3;
  options.vertices_max = 1'500;
  Session session(testing::CheckerboardCase(), options);
  const Mesh& mesh = session.made->mesh;
  const std::uint32_t epoch = session.loop.Save().epoch;
  double potential = Potential(mesh, options.age_max, epoch);
  std::int64_t births = 0;
  for (int visits = 0; visits < 50'000; ++visits) {
    const Mesh before = mesh;
    if (session.loop.Run(*session.field, {.visits_max = 1}) != StopReason::kVisitBudget) break;
    int maker_age = -1;
    int newborn_age = -1;
    for (const VertexId id : testing::LiveVertices(mesh)) {
      const int age = AgeOf(mesh, id, epoch);
      ASSERT_LE(age, options.age_max);
      if (!before.IsLive(id)) {
        ASSERT_EQ(newborn_age, -1) << "two nodes born in one visit";
        newborn_age = age;
      } else if (age != AgeOf(before, id, epoch)) {
        ASSERT_EQ(maker_age, -1) << "two nodes aged in one visit";
        ASSERT_EQ(age, AgeOf(before, id, epoch) + 1);
        maker_age = age;
      }
    }
    if (newborn_age >= 0) {
      ++births;
      ASSERT_GE(newborn_age, maker_age);
    }
    const double now = Potential(mesh, options.age_max, epoch);
    ASSERT_LT(now, potential) << "visit " << visits;
    potential = now;
    if (visits % 50 == 0) {
      ASSERT_EQ(Faults(mesh), "");
    }
  }
  EXPECT_GT(births, 200);
  EXPECT_GT(session.loop.counts().cooled, 0);
  EXPECT_EQ(session.loop.active_count(), 0);
}

TEST(PliantLoop, CountsWhatItDoes) {
  Session session(testing::GaussianCase(500), {});
  EXPECT_EQ(session.loop.Run(*session.field, {}), StopReason::kConverged);
  const LoopCounts& counts = session.loop.counts();
  EXPECT_EQ(counts.insertions - counts.deletions, session.made->mesh.vertex_count() - 4);
  EXPECT_GT(counts.moves, 0);
  EXPECT_GT(counts.swaps, 0);
  EXPECT_GE(counts.visits, counts.insertions);
  session.loop.ResetCounts();
  EXPECT_EQ(session.loop.counts(), LoopCounts{});
}

TEST(PliantLoop, AConvergedMeshWokenAgainHardlyChanges) {
  Session session(testing::GaussianCase(1000), {});
  session.loop.Run(*session.field, {});
  const std::int32_t count = session.made->mesh.vertex_count();
  session.loop.ResetCounts();
  session.loop.BeginUpdate(SettingsOf({}));
  session.WakeAll();
  EXPECT_EQ(session.loop.Run(*session.field, {}), StopReason::kConverged);
  EXPECT_LT(session.loop.counts().visits, 4 * count);
  EXPECT_NEAR(session.made->mesh.vertex_count(), count, 0.02 * count);
}

TEST(PliantLoop, StopsWithinAFewVisitsOfACancel) {
  Session session(testing::GaussianCase(5000), {});
  const StopFlag stop(true);
  EXPECT_EQ(session.loop.Run(*session.field, {.stop = &stop}), StopReason::kCancelled);
  EXPECT_LE(session.loop.counts().visits, 256);
}

TEST(PliantLoop, ThePaperVariantGivesUpAtItsLimit) {
  Options options;
  options.variant = Variant::kPaper;
  options.visits_per_vertex_max = 5;
  Session session(testing::GaussianCase(1000), options);
  EXPECT_EQ(session.loop.Run(*session.field, {}), StopReason::kVisitLimit);
  EXPECT_GE(session.loop.counts().visits, 5 * 4);
  EXPECT_EQ(Faults(session.made->mesh), "");
}

// A saved state and the mesh of that moment go on as if nothing had happened.
TEST(PliantLoop, RestoresItsStateWithTheMesh) {
  for (const Variant variant : {Variant::kCooled, Variant::kPaper}) {
    Options options;
    options.variant = variant;
    Session session(testing::GaussianCase(800), options);
    session.loop.Run(*session.field, {.visits_max = 700});
    (void)session.made->edit.Commit(Revision(1));
    const PliantLoop::State state = session.loop.Save();
    session.loop.Run(*session.field, {.visits_max = 500});
    const Mesh expected = session.made->mesh;
    session.made->edit.Rollback();
    session.loop.Restore(state);
    session.loop.Run(*session.field, {.visits_max = 500});
    EXPECT_EQ(testing::DifferenceOf(session.made->mesh, expected), "");
  }
}

TEST(PliantLoop, HopsBoundTheReachOfAnUpdate) {
  for (const std::int32_t hops : {1, 2, 4}) {
    Options options;
    options.hops_max = hops;
    options.variant = Variant::kCooled;
    Session session(testing::DiscCase(2000, testing::DiscState::kOff), options);
    session.loop.Run(*session.field, {});
    const Mesh before = session.made->mesh;
    session.loop.BeginUpdate(SettingsOf(options));
    const std::uint32_t epoch = session.loop.Save().epoch;
    const VertexId node(100);
    session.made->edit.SetMetric(node, 3 * before.metric(node));
    session.loop.Wake(node);
    session.loop.Run(*session.field, {});
    for (const VertexId id : testing::LiveVertices(session.made->mesh)) {
      const VisitState& visit = session.made->mesh.vertex(id).visit;
      if (visit.epoch != epoch || visit.age == 0) continue;
      EXPECT_LE(visit.hop, hops) << id;
      const Vec2 way = session.made->mesh.position(id) - before.position(node);
      EXPECT_LT(Length(way), (hops + 2) * 0.05) << "edges are about 0.024 long";
    }
  }
}

// Goal: where a metric becomes twice as fine everywhere, nodes come in bulk between those of the
// lattice, which stays one. Method: one update with HalveLongEdges and one without; both must end,
// with a valid mesh of as many nodes, the first with less than half of the visits.
TEST(PliantLoop, HalvingSavesMostVisitsWhereTheMetricBecomesTwiceAsFine) {
  std::int64_t visits[2] = {};
  std::int32_t nodes[2] = {};
  for (const bool halves : {false, true}) {
    Session session(testing::DiscCase(1'000, testing::DiscState::kOff), {});
    session.loop.Run(*session.field, {});
    const std::int32_t before = session.made->mesh.vertex_count();
    session.field = std::move(testing::DiscCase(4'000, testing::DiscState::kOff).field);
    session.loop.BeginUpdate(SettingsOf({}));
    session.loop.ResetCounts();
    session.WakeAll();
    if (halves) {
      session.loop.HalveLongEdges(*session.field, testing::LiveVertices(session.made->mesh));
      EXPECT_GT(session.made->mesh.vertex_count(), 3.7 * before);
      EXPECT_EQ(session.loop.counts().insertions, session.made->mesh.vertex_count() - before);
      EXPECT_EQ(Faults(session.made->mesh), "");
    }
    EXPECT_EQ(session.loop.Run(*session.field, {}), StopReason::kConverged);
    EXPECT_EQ(Faults(session.made->mesh), "");
    visits[halves ? 1 : 0] = session.loop.counts().visits;
    nodes[halves ? 1 : 0] = session.made->mesh.vertex_count();
  }
  EXPECT_LT(2 * visits[1], visits[0]);
  EXPECT_NEAR(nodes[1], nodes[0], 0.02 * nodes[0]);
}

// Goal: halving keeps to what bounds the loop. Method: a vertex limit just above the mesh, and
// permissions without insertion.
TEST(PliantLoop, HalvingKeepsToTheVertexLimitAndToPermissions) {
  for (const bool may_insert : {true, false}) {
    Options options;
    Session session(testing::DiscCase(500, testing::DiscState::kOff), options);
    session.loop.Run(*session.field, {});
    const std::int32_t before = session.made->mesh.vertex_count();
    options.permissions.insert = may_insert;
    options.vertices_max = before + 100;
    session.loop.SetOptions(options);
    session.field = std::move(testing::DiscCase(2'000, testing::DiscState::kOff).field);
    session.loop.BeginUpdate(SettingsOf(options));
    session.WakeAll();
    session.loop.HalveLongEdges(*session.field, testing::LiveVertices(session.made->mesh));
    EXPECT_EQ(session.made->mesh.vertex_count(), before + (may_insert ? 100 : 0));
    EXPECT_EQ(Faults(session.made->mesh), "");
  }
}

// Goal: an update that wakes a whole mesh at rest leaves the bits of most nodes as they are: steps
// that are far too short to go on with are not taken. Method: every node of a committed mesh is
// woken with the metric that it has; if all steps are taken, all nodes move.
TEST(PliantLoop, AnUpdateLeavesMostNodesAtRestWhereTheyAre) {
  Session session(testing::GaussianCase(1'000), {});
  session.loop.Run(*session.field, {});
  const Mesh& mesh = session.made->mesh;
  const std::vector<VertexId> nodes = testing::LiveVertices(mesh);
  (void)session.made->edit.Commit(Revision{1});
  std::vector<Vec2> before;
  for (const VertexId id : nodes) before.push_back(mesh.position(id));
  session.loop.BeginUpdate(SettingsOf({}));
  session.WakeAll();
  session.loop.Run(*session.field, {});
  EXPECT_GE(session.loop.counts().visits, std::ssize(nodes));
  std::int64_t moved = 0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    moved += mesh.IsLive(nodes[i]) && mesh.position(nodes[i]) == before[i] ? 0 : 1;
  }
  EXPECT_LT(2 * moved, std::ssize(nodes));
}

}  // namespace
}  // namespace pliant
