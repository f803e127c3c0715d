// Goal: whoever stops an update under limits does not wait until they are laid on what has become
// of the mesh; the next step lays them, and nothing is lost: what follows is what would have
// followed from the same mesh.
// Method: updates that change everything, stopped at many places, against twins: a session that was
// saved and read in between, one that went back and forth, and a mesh that has its limits laid
// anew.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/mesh/export_mesh.h"
#include "core/motion/move.h"
#include "core/pliant/quality.h"
#include "core/pliant/remesher.h"
#include "core/pliant/revision_delta.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"
#include "tests/support/stop_after.h"

namespace pliant {
namespace {

using testing::Faults;
using testing::StopAfter;

constexpr GradationOptions kLimits{.gradation = 1.3, .rotation = 0.7};

/// A size that grows faster than the limits allow, from a line on.
MetricSpec Steep(double from) {
  return {.source = SizeMetric{"0.008 + 0.9*abs(x - " + std::to_string(from) + ")"},
          .bounds = {.size_max = 0.015},
          .gradation = kLimits};
}

std::uint64_t HashAtTheEnd(Remesher& remesher) {
  const auto progress = remesher.Step({});
  EXPECT_TRUE(progress.ok());
  EXPECT_EQ(progress->stop_reason, StopReason::kConverged);
  const std::uint64_t hash = remesher.Commit().summary.state_hash;
  EXPECT_EQ(Faults(remesher.mesh()), "");
  return hash;
}

std::unique_ptr<Remesher> Start() {
  auto remesher = Remesher::Create(testing::Rectangle({0, 0}, {1, 1}), Steep(0.3), {}).value();
  HashAtTheEnd(*remesher);
  return remesher;
}

/// Another metric everywhere, stopped at a place, and committed. @return false if it was not
/// stopped
bool StopAt(Remesher& remesher, std::int64_t place) {
  EXPECT_TRUE(remesher.SetMetric(Steep(0.6)).ok());
  const StopAfter stop(place);
  const auto progress = remesher.Step({.stop = &stop});
  EXPECT_TRUE(progress.ok());
  remesher.Commit();
  EXPECT_EQ(Faults(remesher.mesh()), "");
  return progress->stop_reason == StopReason::kCancelled;
}

/// A session whose limits are due.
std::unique_ptr<Remesher> Stopped() {
  auto remesher = Start();
  EXPECT_TRUE(StopAt(*remesher, 30));
  EXPECT_FALSE(remesher->metric_report().limits) << "limits were laid";
  return remesher;
}

std::unique_ptr<Remesher> Reread(const Remesher& remesher) {
  return Remesher::Load(remesher.Save().value()).value();
}

/// Differs from limits that are laid on the same mesh anew by no more than goes unnoticed, here and
/// there.
void ExpectLimited(const Remesher& remesher) {
  const auto whole = ExportMesh(remesher.mesh());
  const auto anew = Remesher::Create(whole.data, Steep(0.6), {}).value();
  ASSERT_TRUE(anew->Step({.visits_max = 0}).ok());
  anew->Commit();
  ASSERT_EQ(anew->mesh().vertex_count(), remesher.mesh().vertex_count());
  double most = 0;
  for (std::size_t i = 0; i < whole.vertex_ids.size(); ++i) {
    const VertexId here = whole.vertex_ids[i];
    const VertexId there(static_cast<std::int32_t>(i));
    ASSERT_EQ(anew->mesh().position(there), remesher.mesh().position(here));
    most = std::max(most, RelativeChange(anew->mesh().metric(there), remesher.mesh().metric(here)));
  }
  EXPECT_LE(most, 2.1 * Options().metric_tolerance);
}

TEST(PutOffLimits, AreLaidByTheNextStepWhereverAnUpdateWasStopped) {
  const auto undisturbed = Start();
  ASSERT_TRUE(undisturbed->SetMetric(Steep(0.6)).ok());
  HashAtTheEnd(*undisturbed);
  const double q_mean = MeasureQuality(undisturbed->mesh(), undisturbed->field()).q_mean;
  int put_off = 0;
  for (std::int64_t place = 1; place < 4000; place += 1 + place / 3) {
    SCOPED_TRACE(place);
    const auto remesher = Start();
    if (!StopAt(*remesher, place)) break;
    put_off += remesher->metric_report().limits ? 0 : 1;
    const auto twin = Reread(*remesher);
    EXPECT_EQ(HashAtTheEnd(*remesher), HashAtTheEnd(*twin))
        << "a session that was read goes another way";
    ExpectLimited(*remesher);
    EXPECT_GT(MeasureQuality(remesher->mesh(), remesher->field()).q_mean, q_mean - 0.005);
    EXPECT_NEAR(
        remesher->mesh().vertex_count() / static_cast<double>(undisturbed->mesh().vertex_count()),
        1, 0.02);
  }
  EXPECT_GE(put_off, 3);
}

TEST(PutOffLimits, AreThereAgainAfterTheWayBackAndForth) {
  const auto straight = Stopped();
  const auto winding = Stopped();
  const std::uint64_t due_hash = winding->Snapshot().summary.state_hash;
  auto back = winding->TakeUndo();
  ASSERT_TRUE(back.has_value());
  const Bytes forth_bytes = WriteDelta(winding->InverseOf(*back)).value();
  ASSERT_TRUE(winding->Apply(*back, Revision(1)).ok());
  EXPECT_TRUE(winding->metric_report().limits);
  const auto first = Reread(*winding);
  ASSERT_TRUE(first->Step({}).ok());
  EXPECT_TRUE(first->Commit().empty()) << "the first revision was at rest";
  const Result<RevisionDelta> forth = winding->ReadDelta(forth_bytes);
  ASSERT_TRUE(forth.ok()) << forth.error().message;
  const auto again = winding->Apply(*forth, Revision(5));
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(winding->Snapshot().summary.state_hash, due_hash);
  EXPECT_FALSE(winding->metric_report().limits);
  EXPECT_EQ(HashAtTheEnd(*winding), HashAtTheEnd(*straight));
}

TEST(PutOffLimits, ThatWereLaidAreDueAgainAfterARollback) {
  const auto straight = Stopped();
  const auto hesitant = Stopped();
  ASSERT_TRUE(hesitant->Step({.visits_max = 500}).ok());
  hesitant->Rollback();
  EXPECT_EQ(HashAtTheEnd(*hesitant), HashAtTheEnd(*straight));
}

// Nothing has happened then: the revision is as it was, and so is what follows.
TEST(PutOffLimits, StayDueIfLayingThemIsStoppedToo) {
  const auto straight = Stopped();
  const auto hesitant = Stopped();
  const std::uint64_t hash = hesitant->Snapshot().summary.state_hash;
  int stops = 0;
  for (std::int64_t place = 1;; ++place) {
    const StopAfter stop(place);
    const auto progress = hesitant->Step({.stop = &stop});
    ASSERT_TRUE(progress.ok());
    if (progress->counts.visits > 0 || progress->stop_reason != StopReason::kCancelled) break;
    EXPECT_GT(progress->active_count, 0);
    if (hesitant->metric_report().limits) break;  // They are laid now, and the loop was stopped.
    EXPECT_EQ(hesitant->Commit().summary.state_hash, hash);
    ++stops;
  }
  EXPECT_GE(stops, 4);
  hesitant->Rollback();
  EXPECT_EQ(HashAtTheEnd(*hesitant), HashAtTheEnd(*straight));
}

TEST(PutOffLimits, AreLaidBeforeAnythingElseIsTold) {
  const auto tell_all = [](Remesher& remesher) {
    std::vector<Metric> tensors;
    for (const VertexId vertex : ExportMesh(remesher.mesh()).vertex_ids) {
      tensors.push_back(1.3 * remesher.mesh().metric(vertex));
    }
    return remesher.SetTensors({}, tensors);
  };
  const auto tell_one = [](Remesher& remesher) {
    const VertexId some = ExportMesh(remesher.mesh()).vertex_ids[700];
    return remesher.SetTensors(std::array{some}, std::array{3 * remesher.mesh().metric(some)});
  };
  const auto loosen = [](Remesher& remesher) {
    MetricLimits limits = remesher.limits();
    limits.gradation.gradation = 2;
    return remesher.SetLimits(limits);
  };
  const auto stretch = [](Remesher& remesher) {
    MotionRequest request;
    request.tags.push_back({{1, 2, 3, 4}, AffineMap{1.1, 0, 0, 1, {0, 0}}});
    const auto report = MoveVertices(remesher, request);
    return report.ok() ? Status() : Status(report.error());
  };
  const auto replace = [](Remesher& remesher) { return remesher.SetMetric(Steep(0.4)); };
  for (const std::function<Status(Remesher&)>& update :
       {std::function<Status(Remesher&)>(tell_all), {tell_one}, {loosen}, {stretch}, {replace}}) {
    const auto remesher = Stopped();
    const auto twin = Reread(*remesher);
    for (Remesher* one : {remesher.get(), twin.get()}) ASSERT_TRUE(update(*one).ok());
    EXPECT_EQ(HashAtTheEnd(*remesher), HashAtTheEnd(*twin));
    EXPECT_TRUE(remesher->metric_report().limits);
    EXPECT_GT(MeasureQuality(remesher->mesh(), remesher->field()).q_mean, 0.95);
  }
}

// Goal: who goes on without a commit gets the bits of a run that nobody disturbed, also where the
// limits were stopped while they were laid again.
TEST(PutOffLimits, DoNotShowWhereNobodyCommits) {
  const auto undisturbed = Start();
  ASSERT_TRUE(undisturbed->SetMetric(Steep(0.6)).ok());
  const std::uint64_t hash = HashAtTheEnd(*undisturbed);
  const auto stopped = Start();
  ASSERT_TRUE(stopped->SetMetric(Steep(0.6)).ok());
  int stops = 0;
  for (std::int64_t patience = 1;; ++patience) {
    const StopAfter stop(1 + patience % 40);
    const auto progress = stopped->Step({.stop = &stop});
    ASSERT_TRUE(progress.ok());
    if (progress->stop_reason != StopReason::kCancelled) break;
    ++stops;
  }
  EXPECT_GT(stops, 8);
  EXPECT_EQ(stopped->Commit().summary.state_hash, hash);
}

TEST(PutOffLimits, OfAFirstBuildAreLaidByTheNextStep) {
  for (const std::int64_t place : {20, 60, 120}) {
    const auto remesher =
        Remesher::Create(testing::Rectangle({0, 0}, {1, 1}), Steep(0.6), {}).value();
    const StopAfter stop(place);
    ASSERT_EQ(remesher->Step({.stop = &stop})->stop_reason, StopReason::kCancelled);
    remesher->Commit();
    const auto twin = Reread(*remesher);
    EXPECT_EQ(HashAtTheEnd(*remesher), HashAtTheEnd(*twin));
    ExpectLimited(*remesher);
  }
}

// Tensors at vertices are known from the limits only: they are laid at the commit, as ever.
TEST(PutOffLimits, TensorsAreNotPutOff) {
  const auto remesher = Start();
  std::vector<Metric> tensors;
  for (const VertexId vertex : ExportMesh(remesher->mesh()).vertex_ids) {
    tensors.push_back(1.5 * remesher->mesh().metric(vertex));
  }
  ASSERT_TRUE(remesher->SetTensors({}, tensors).ok());
  const StopAfter stop(10);
  ASSERT_EQ(remesher->Step({.stop = &stop})->stop_reason, StopReason::kCancelled);
  remesher->Commit();
  EXPECT_TRUE(remesher->metric_report().limits);
}

}  // namespace
}  // namespace pliant
