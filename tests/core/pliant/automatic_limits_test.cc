// Goal: usual limits come into force where a metric cannot be met, hold on, and leave everything
// else as it is. Method: metrics that jump or cross beside smooth ones, with and without
// `automatic`, interrupted, loaded and rolled back on the way.

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/metric/metric_spec.h"
#include "core/pliant/quality.h"
#include "core/pliant/remesher.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"
#include "tests/support/remesher_testing.h"

namespace pliant {
namespace {

using testing::LeastQuality;

constexpr char kJump[] = "x < 0.5 ? 0.01 : 0.2";
constexpr char kSmooth[] = "0.03 + 0.05*x";

MetricSpec SizeOf(const char* size, bool automatic = true) {
  MetricSpec spec{.source = SizeMetric{size}};
  spec.gradation.automatic = automatic;
  return spec;
}

/// A checkerboard of two directions.
MetricSpec Crossing() {
  const std::string is_odd = "sin(12*x)*sin(12*y) < 0";
  return {.source = ExpressionMetric{is_odd + " ? 160000 : 400", "0", is_odd + " ? 400 : 160000"}};
}

std::unique_ptr<Remesher> Start(const MetricSpec& spec, const Options& options = {}) {
  auto made = Remesher::Create(testing::Rectangle({0, 0}, {1, 1}), spec, options);
  EXPECT_TRUE(made.ok()) << made.error().message;
  return std::move(*made);
}

/// Steps to the end. @return the places where the metric is not met
std::size_t TroublesAtTheEnd(Remesher& remesher, std::int64_t visits_max = 1'000'000'000) {
  for (;;) {
    const auto progress = remesher.Step({.visits_max = visits_max});
    EXPECT_TRUE(progress.ok());
    if (progress->stop_reason == StopReason::kVisitBudget) continue;
    EXPECT_EQ(progress->stop_reason, StopReason::kConverged);
    EXPECT_EQ(progress->active_count, 0);
    EXPECT_EQ(testing::Faults(remesher.mesh()), "");
    return remesher.FindTroubles().size();
  }
}

std::uint64_t Hash(const MeshDiff& diff) { return diff.summary.state_hash; }

TEST(AutomaticLimits, HoldWhereAMetricJumps) {
  const auto as_it_is = Start(SizeOf(kJump, false));
  EXPECT_GT(TroublesAtTheEnd(*as_it_is), 0U);
  EXPECT_FALSE(as_it_is->metric_report().limits);
  EXPECT_LT(LeastQuality(*as_it_is), kTroubleQuality);

  const auto limited = Start(SizeOf(kJump));
  EXPECT_EQ(TroublesAtTheEnd(*limited), 0U);
  EXPECT_TRUE(limited->metric_report().limits);
  EXPECT_GT(limited->metric_report().gradation_count, 0);
  EXPECT_GT(LeastQuality(*limited), 0.7);
}

TEST(AutomaticLimits, HoldWhereDirectionsCross) {
  const auto limited = Start(Crossing());
  EXPECT_EQ(TroublesAtTheEnd(*limited), 0U);
  EXPECT_GT(limited->metric_report().limited_complexity, limited->metric_report().raw_complexity);
  EXPECT_GT(LeastQuality(*limited), 0.6);
}

TEST(AutomaticLimits, LeaveAloneWhatCanBeMet) {
  const auto with = Start(SizeOf(kSmooth));
  const auto without = Start(SizeOf(kSmooth, false));
  EXPECT_EQ(TroublesAtTheEnd(*with), 0U);
  EXPECT_EQ(TroublesAtTheEnd(*without), 0U);
  EXPECT_FALSE(with->metric_report().limits);
  EXPECT_EQ(Hash(with->Commit()), Hash(without->Commit()));
}

TEST(AutomaticLimits, AddNothingToWhatWasChosen) {
  MetricSpec spec = SizeOf(kJump);
  spec.gradation.rotation = 0.7;  // Cures no jump.
  const auto chosen = Start(spec);
  EXPECT_GT(TroublesAtTheEnd(*chosen), 0U);
  EXPECT_EQ(chosen->metric_report().gradation_count, 0);

  const auto paper = Start(SizeOf(kJump), {.variant = Variant::kPaper});
  ASSERT_TRUE(paper->Step({}).ok());
  EXPECT_FALSE(paper->metric_report().limits) << "the paper knows no limits";
}

TEST(AutomaticLimits, JoinLimitsThatHoldAlready) {
  MetricSpec spec = SizeOf(kJump);
  spec.gradation.geometry = 0.1;
  const auto remesher = Start(spec);
  EXPECT_EQ(TroublesAtTheEnd(*remesher), 0U);
  EXPECT_GT(remesher->metric_report().gradation_count, 0);
  EXPECT_GT(remesher->metric_report().geometry_count, 0);

  remesher->Commit();
  spec.source = SizeMetric{kSmooth};
  const auto updated = Start(spec);
  TroublesAtTheEnd(*updated);
  updated->Commit();
  EXPECT_EQ(updated->metric_report().gradation_count, 0);
  spec.source = SizeMetric{kJump};
  ASSERT_TRUE(updated->SetMetric(spec).ok());
  EXPECT_EQ(TroublesAtTheEnd(*updated), 0U);
  EXPECT_GT(updated->metric_report().gradation_count, 0) << "of an update too";
}

TEST(AutomaticLimits, HoldOnUntilTheyAreSwitchedOff) {
  const auto remesher = Start(SizeOf(kJump));
  TroublesAtTheEnd(*remesher);
  remesher->Commit();
  ASSERT_TRUE(remesher->SetMetric(SizeOf(kSmooth)).ok());
  EXPECT_EQ(TroublesAtTheEnd(*remesher), 0U);
  remesher->Commit();
  EXPECT_TRUE(remesher->metric_report().limits);

  auto loaded = Remesher::Load(*remesher->Save());
  ASSERT_TRUE(loaded.ok());
  for (Remesher* one : {remesher.get(), loaded->get()}) {
    ASSERT_TRUE(one->SetMetric(SizeOf("0.05")).ok());
    TroublesAtTheEnd(*one);
  }
  EXPECT_EQ(Hash(remesher->Commit()), Hash((*loaded)->Commit()));
  EXPECT_TRUE((*loaded)->metric_report().limits) << "they also hold on in a session that slept";

  ASSERT_TRUE(remesher->SetMetric(SizeOf("0.06", false)).ok());
  TroublesAtTheEnd(*remesher);
  remesher->Commit();
  EXPECT_FALSE(remesher->metric_report().limits);
}

TEST(AutomaticLimits, DoNotDependOnHowAnUpdateIsCut) {
  const auto whole = Start(SizeOf(kSmooth));
  TroublesAtTheEnd(*whole);
  whole->Commit();
  auto in_pieces = Remesher::Load(*whole->Save());
  ASSERT_TRUE(in_pieces.ok());
  ASSERT_TRUE(whole->SetMetric(SizeOf(kJump)).ok());
  ASSERT_TRUE((*in_pieces)->SetMetric(SizeOf(kJump)).ok());
  EXPECT_EQ(TroublesAtTheEnd(*whole), 0U);
  EXPECT_EQ(TroublesAtTheEnd(**in_pieces, 37), 0U);
  EXPECT_EQ(Hash(whole->Commit()), Hash((*in_pieces)->Commit()));
}

// What mending has come upon belongs to the session's state: a step may end in the middle of it.
TEST(AutomaticLimits, GiveTheSameBitsToASessionThatSleptInBetween) {
  const auto awake = Start(SizeOf(kSmooth));
  TroublesAtTheEnd(*awake);
  awake->Commit();
  ASSERT_TRUE(awake->SetMetric(SizeOf(kJump)).ok());
  int sleeps = 0;
  std::unique_ptr<Remesher> sleeper;
  for (;;) {
    const auto progress = awake->Step({.visits_max = 400});
    ASSERT_TRUE(progress.ok());
    awake->Commit();
    if (sleeper != nullptr) {
      ASSERT_TRUE(sleeper->Step({.visits_max = 400}).ok());
      ASSERT_EQ(Hash(awake->Snapshot()), Hash(sleeper->Commit())) << "after " << sleeps;
    }
    if (progress->stop_reason != StopReason::kVisitBudget) break;
    auto loaded = Remesher::Load(*awake->Save());
    ASSERT_TRUE(loaded.ok());
    sleeper = std::move(*loaded);
    ++sleeps;
  }
  EXPECT_GT(sleeps, 10);
  EXPECT_TRUE(awake->metric_report().limits) << "though several commits shared the update";
}

TEST(AutomaticLimits, HoldForTensorsAtVertices) {
  const auto remesher = Start(SizeOf("0.02"));
  TroublesAtTheEnd(*remesher);
  remesher->Commit();
  const Bytes before = *remesher->Save();
  std::vector<VertexId> vertices = testing::LiveVertices(remesher->mesh());
  std::vector<Metric> tensors;
  for (const VertexId v : vertices) {
    const double size = remesher->mesh().position(v).x < 0.5 ? 0.004 : 0.2;
    tensors.push_back({1 / (size * size), 0, 1 / (size * size)});
  }
  ASSERT_TRUE(remesher->SetTensors(vertices, tensors).ok());
  EXPECT_EQ(TroublesAtTheEnd(*remesher), 0U);
  EXPECT_TRUE(remesher->metric_report().limits);

  remesher->Rollback();
  EXPECT_FALSE(remesher->metric_report().limits);
  EXPECT_TRUE(*remesher->Save() == before);

  ASSERT_TRUE(remesher->SetTensors(vertices, tensors).ok());
  EXPECT_EQ(TroublesAtTheEnd(*remesher), 0U);
  remesher->Commit();
  const auto undo = remesher->TakeUndo();
  ASSERT_TRUE(undo.has_value());
  ASSERT_TRUE(remesher->Apply(*undo, undo->revision).ok());
  EXPECT_FALSE(remesher->metric_report().limits);
}

}  // namespace
}  // namespace pliant
