// Goal: long work that is told to stop leaves everything as it was, wherever that happens, and who
// goes on gets the bits of a run that nobody disturbed.
// Method: twins, of which one is stopped at its first look, its second, and so on.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/base/stop_signal.h"
#include "core/mesh/export_mesh.h"
#include "core/pliant/remesher.h"
#include "core/threads/thread_pool.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"
#include "tests/support/stop_after.h"

namespace pliant {
namespace {

using testing::Faults;
using testing::StopAfter;

/// Blocks from a few hundred nodes on, so that a small mesh meets all that a large one does.
Helpers SmallBlocks(Executor* executor) {
  return Helpers(executor, {.nodes_min = 1'000, .nodes_per_block = 300});
}

std::unique_ptr<Remesher> Start(testing::Case from, Executor* executor = nullptr) {
  auto remesher = Remesher::Create(from.domain, std::move(from.field), {}).value();
  remesher->UseHelpers(SmallBlocks(executor));
  return remesher;
}

std::unique_ptr<Remesher> Start(double nodes, Executor* executor = nullptr) {
  return Start(testing::GaussianCase(nodes), executor);
}

void Settle(Remesher& remesher) {
  ASSERT_EQ(remesher.Step({})->stop_reason, StopReason::kConverged);
  remesher.Commit();
}

/// Stops and goes on, with a little more patience each time, until the mesh is at rest.
/// @return how often it was stopped
int StepWithStops(Remesher& remesher) {
  int stops = 0;
  for (std::int64_t patience = 1;; ++patience) {
    const StopAfter stop(1 + patience % 40);
    const Result<Progress> progress = remesher.Step({.stop = &stop});
    EXPECT_TRUE(progress.ok());
    if (progress->stop_reason != StopReason::kCancelled) return stops;
    EXPECT_GT(progress->active_count, 0) << "an unfinished build has work left";
    ++stops;
  }
}

TEST(Interrupted, AFirstBuildGoesOnToTheSameBits) {
  const auto undisturbed = Start(8'000);
  Settle(*undisturbed);
  ThreadPool pool(2);
  for (Executor* executor : {static_cast<Executor*>(nullptr), static_cast<Executor*>(&pool)}) {
    const auto stopped = Start(8'000, executor);
    EXPECT_GT(StepWithStops(*stopped), 20);
    EXPECT_EQ(Faults(stopped->mesh()), "");
    EXPECT_EQ(stopped->Commit().summary, undisturbed->Snapshot().summary);
  }
}

// Goal: wherever a first build is stopped, a commit makes a valid mesh of it that can go on.
TEST(Interrupted, AFirstBuildCanBeCommittedWhereverItStops) {
  for (std::int64_t place = 1; place < 400; place += 7) {
    SCOPED_TRACE(place);
    const auto remesher = Start(4'000);
    const StopAfter stop(place);
    if (remesher->Step({.stop = &stop})->stop_reason != StopReason::kCancelled) break;
    remesher->Commit();
    ASSERT_EQ(Faults(remesher->mesh()), "");
    ASSERT_EQ(remesher->Step({})->stop_reason, StopReason::kConverged);
    EXPECT_NEAR(remesher->mesh().vertex_count(), 4'000, 300);
  }
}

/// Updates a mesh at rest once it was stopped at every look there is, and steps.
/// @return how often it was stopped
template <class Update>
int UpdateWithStops(Remesher& remesher, const Update& update) {
  const std::uint64_t before = remesher.Snapshot().summary.state_hash;
  for (int place = 1;; ++place) {
    const StopAfter stop(place);
    remesher.ListenTo(&stop);
    const Status status = update(remesher);
    remesher.ListenTo(nullptr);
    if (status.ok()) return place - 1;
    EXPECT_EQ(status.error().code, ErrorCode::kCancelled) << status.error().message;
    EXPECT_EQ(remesher.Step({})->counts.visits, 0) << "something woke";
    EXPECT_EQ(remesher.Snapshot().summary.state_hash, before);
  }
}

/// @param undisturbed, stopped  twins
template <class Update>
void ExpectSameBitsWithStops(std::unique_ptr<Remesher> undisturbed,
                             std::unique_ptr<Remesher> stopped, const Update& update,
                             int stops_min) {
  Settle(*undisturbed);
  Settle(*stopped);
  ASSERT_TRUE(update(*undisturbed).ok());
  EXPECT_GE(UpdateWithStops(*stopped, update), stops_min);
  Settle(*undisturbed);
  Settle(*stopped);
  EXPECT_EQ(stopped->Snapshot().summary, undisturbed->Snapshot().summary);
}

template <class Update>
void ExpectSameBitsWithStops(const Update& update, int stops_min) {
  ExpectSameBitsWithStops(Start(12'000), Start(12'000), update, stops_min);
}

TEST(Interrupted, TensorsAreTakenOverWholeOrNotAtAll) {
  ExpectSameBitsWithStops(
      [](Remesher& remesher) {
        std::vector<Metric> tensors;
        for (const VertexId vertex : ExportMesh(remesher.mesh()).vertex_ids) {
          tensors.push_back(1.2 * remesher.mesh().metric(vertex));
        }
        return remesher.SetTensors({}, tensors);
      },
      /*stops_min=*/20);
}

TEST(Interrupted, AFormulaIsTakenOverWholeOrNotAtAll) {
  ExpectSameBitsWithStops(
      [](Remesher& remesher) {
        return remesher.SetMetric({.source = SizeMetric{"0.06 + 0.005*abs(x)"}});
      },
      /*stops_min=*/3);
}

TEST(Interrupted, ABackgroundMeshIsTakenOverWholeOrNotAtAll) {
  const auto other = Start(12'000);
  Settle(*other);
  BackgroundMetric background{ExportMesh(other->mesh()).data, {}};
  background.tensors.assign(background.mesh.points.size(), Metric::Isotropic(0.06));
  ExpectSameBitsWithStops(
      [&](Remesher& remesher) { return remesher.SetMetric({.source = background}); },
      /*stops_min=*/20);
}

TEST(Interrupted, AFrontIsCarriedAlongOrNotAtAll) {
  constexpr double kNodes = 3'000;
  ExpectSameBitsWithStops(
      Start(testing::ShockCase(kNodes, 0.4)), Start(testing::ShockCase(kNodes, 0.4)),
      [](Remesher& remesher) { return remesher.SetField(testing::ShockCase(kNodes, 0.42).field); },
      /*stops_min=*/200);
}

}  // namespace
}  // namespace pliant
