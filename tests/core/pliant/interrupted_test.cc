// Goal: long work that is told to stop leaves everything as it was, wherever that happens, and who
// goes on gets the bits of a run that nobody disturbed.
// Method: twins, of which one is stopped at its first look, its second, and so on.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/stop_signal.h"
#include "core/mesh/export_mesh.h"
#include "core/motion/move.h"
#include "core/motion/replace_domain.h"
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

// Method: tensors for all vertices, so that the end of the update looks at the whole mesh, and does
//         that with threads, too. Without a cancel the count of looks shows that the end is asked.
TEST(Interrupted, AnUpdateGoesOnToTheSameBits) {
  ThreadPool pool(2);
  const auto update = [](Remesher& remesher) {
    std::vector<Metric> tensors;
    for (const VertexId vertex : ExportMesh(remesher.mesh()).vertex_ids) {
      tensors.push_back(1.3 * remesher.mesh().metric(vertex));
    }
    ASSERT_TRUE(remesher.SetTensors({}, tensors).ok());
  };
  const auto undisturbed = Start(8'000);
  Settle(*undisturbed);
  update(*undisturbed);
  Settle(*undisturbed);
  for (Executor* executor : {static_cast<Executor*>(nullptr), static_cast<Executor*>(&pool)}) {
    const auto stopped = Start(8'000, executor);
    Settle(*stopped);
    update(*stopped);
    EXPECT_GT(StepWithStops(*stopped), 8);
    EXPECT_EQ(Faults(stopped->mesh()), "");
    EXPECT_EQ(stopped->Commit().summary, undisturbed->Snapshot().summary);
  }
}

// Goal: an update that is stopped while its end looks for what is left bad is not at rest, and can
// be committed and gone on with. Method: no visits are left to stop at but those of the end.
TEST(Interrupted, TheEndOfAnUpdateIsCommittedWhereverItStops) {
  const auto remesher = Start(4'000);
  Settle(*remesher);
  const VertexId some = ExportMesh(remesher->mesh()).vertex_ids[2'000];
  const Metric tensor = 1.5 * remesher->mesh().metric(some);
  int stops = 0;
  for (;; ++stops) {
    ASSERT_TRUE(remesher->SetTensors(std::array{some}, std::array{tensor}).ok());
    const StopAfter stop(stops + 1);
    const Result<Progress> progress = remesher->Step({.stop = &stop});
    if (progress->stop_reason != StopReason::kCancelled) break;
    EXPECT_GT(progress->active_count, 0);
    remesher->Rollback();
  }
  EXPECT_GE(stops, 3) << "the loop, what it leaves bad, and that again once it has settled";
  remesher->Commit();
  EXPECT_EQ(Faults(remesher->mesh()), "");
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

/// A size that grows faster than most limits allow, from a line on.
MetricSpec Steep(double from, const GradationOptions& limits) {
  return {.source = SizeMetric{"0.01 + 0.9*abs(x - " + std::to_string(from) + ")"},
          .bounds = {.size_max = 0.02},
          .gradation = limits};
}

std::unique_ptr<Remesher> StartWith(const MetricSpec& spec) {
  return Remesher::Create(testing::Rectangle({0, 0}, {1, 1}), spec, {}).value();
}

constexpr GradationOptions kLoose{.gradation = 1.5};
constexpr GradationOptions kAll{
    .gradation = 1.2, .rotation = 0.7, .geometry = 1, .gap_element_count = 2, .smoothing_count = 2};

/// @param from, to  a session follows one and is then given the other
void ExpectSameBitsOfLimits(const MetricSpec& from, const MetricSpec& to, int stops_min) {
  ExpectSameBitsWithStops(
      StartWith(from), StartWith(from), [&](Remesher& remesher) { return remesher.SetMetric(to); },
      stops_min);
}

TEST(Interrupted, LimitsAreLaidWholeOrNotAtAll) {
  ExpectSameBitsOfLimits(Steep(0.3, {}), Steep(0.3, kLoose), /*stops_min=*/10);
  ExpectSameBitsOfLimits(Steep(0.3, {}), Steep(0.3, kAll), /*stops_min=*/12);
}

TEST(Interrupted, AMetricWithLimitsIsTakenOverWholeOrNotAtAll) {
  ExpectSameBitsOfLimits(Steep(0.3, kAll), Steep(0.305, kAll), /*stops_min=*/10);
  ExpectSameBitsOfLimits(Steep(0.3, kAll), Steep(0.6, kAll), /*stops_min=*/10);
  ExpectSameBitsOfLimits(Steep(0.3, kAll), Steep(0.4, kLoose), /*stops_min=*/10);
  ExpectSameBitsOfLimits(Steep(0.3, kAll), Steep(0.3, {}), /*stops_min=*/1);
}

TEST(Interrupted, TensorsUnderLimitsAreTakenOverWholeOrNotAtAll) {
  for (const std::size_t stride : {std::size_t{1}, std::size_t{50}}) {
    ExpectSameBitsWithStops(
        StartWith(Steep(0.3, kAll)), StartWith(Steep(0.3, kAll)),
        [&](Remesher& remesher) {
          std::vector<VertexId> vertices;
          std::vector<Metric> tensors;
          const std::vector<VertexId> live = ExportMesh(remesher.mesh()).vertex_ids;
          for (std::size_t i = 0; i < live.size(); i += stride) {
            vertices.push_back(live[i]);
            tensors.push_back(1.5 * remesher.mesh().metric(live[i]));
          }
          return remesher.SetTensors(vertices, tensors);
        },
        /*stops_min=*/8);
  }
}

/// Every vertex inside goes a little way, each another one.
MotionRequest Shake(const Mesh& mesh) {
  MotionRequest request;
  for (const VertexId vertex : ExportMesh(mesh).vertex_ids) {
    if (mesh.vertex(vertex).edge.valid() || mesh.vertex(vertex).fixed) continue;
    const double phase = 10.0 * vertex.value();
    request.vertices.push_back(vertex);
    const double size = 1 / std::sqrt(mesh.metric(vertex).m11);
    request.positions.push_back(mesh.position(vertex) +
                                0.1 * size * Vec2{std::sin(phase), std::cos(phase)});
  }
  return request;
}

TEST(Interrupted, NodesAreMovedWholeOrNotAtAll) {
  ExpectSameBitsWithStops(
      StartWith(Steep(0.3, {})), StartWith(Steep(0.3, {})),
      [](Remesher& remesher) {
        const Result<MotionReport> report = MoveVertices(remesher, Shake(remesher.mesh()));
        return report.ok() ? Status() : Status(report.error());
      },
      /*stops_min=*/8);
}

/// The left side of the square goes inwards, and a layer at it.
MotionRequest Push(double by) {
  MotionRequest request;
  request.tags = {{{4}, Translation{{by, 0}}}};
  request.follow_length = 3;
  return request;
}

// Goal: the same for a boundary whose layer goes with it; the second motion finds tensors that the
//       first one's layer brought along and that are no metric yet.
TEST(Interrupted, ABoundaryIsMovedWholeOrNotAtAll) {
  const auto push = [](double by) {
    return [by](Remesher& remesher) {
      const Result<MotionReport> report = MoveVertices(remesher, Push(by));
      return report.ok() ? Status() : Status(report.error());
    };
  };
  ExpectSameBitsWithStops(StartWith(Steep(0, kLoose)), StartWith(Steep(0, kLoose)), push(0.1), 5);
  const auto undisturbed = StartWith(Steep(0, {}));
  const auto stopped = StartWith(Steep(0, {}));
  for (const auto& remesher : {undisturbed.get(), stopped.get()}) {
    Settle(*remesher);
    ASSERT_TRUE(push(0.05)(*remesher).ok());
  }
  ASSERT_TRUE(push(0.04)(*undisturbed).ok());
  for (int place = 1;; ++place) {
    const StopAfter stop(place);
    stopped->ListenTo(&stop);
    const Status status = push(0.04)(*stopped);
    stopped->ListenTo(nullptr);
    if (status.ok()) break;
    ASSERT_EQ(status.error().code, ErrorCode::kCancelled) << status.error().message;
    ASSERT_EQ(Faults(stopped->mesh()), "");
  }
  Settle(*undisturbed);
  Settle(*stopped);
  EXPECT_EQ(stopped->Snapshot().summary, undisturbed->Snapshot().summary);
}

/// The unit square with a hole.
Domain WithHole(std::span<const Vec2> corners) {
  Domain domain = testing::Rectangle({0, 0}, {1, 1});
  const auto first = static_cast<std::int32_t>(domain.points.size());
  const auto count = static_cast<std::int32_t>(corners.size());
  domain.points.insert(domain.points.end(), corners.begin(), corners.end());
  for (std::int32_t i = 0; i < count; ++i) {
    domain.segments.push_back({first + i, first + (i + 1) % count, 9});
  }
  domain.holes.push_back({0.52, 0.5});
  return domain;
}

// Method: a small hole, which leaves most of the mesh alone, and one that takes most of it, so that
//         the stop also comes while its triangles are being taken out.
TEST(Interrupted, ADomainIsReplacedWholeOrNotAtAll) {
  const auto expect = [](const Domain& other, int stops_min) {
    ExpectSameBitsWithStops(
        StartWith(Steep(0.3, {})), StartWith(Steep(0.3, {})),
        [&](Remesher& remesher) {
          const Result<DomainReport> report = ReplaceDomain(remesher, other);
          return report.ok() ? Status() : Status(report.error());
        },
        stops_min);
  };
  expect(WithHole(std::array{Vec2{0.4, 0.4}, Vec2{0.7, 0.45}, Vec2{0.5, 0.7}}), 8);
  expect(WithHole(std::array{Vec2{0.05, 0.05}, Vec2{0.95, 0.06}, Vec2{0.9, 0.95}, Vec2{0.1, 0.9}}),
         20);
}

}  // namespace
}  // namespace pliant
