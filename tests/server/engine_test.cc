#include "server/engine.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <vector>

#include "core/pliant/remesher.h"
#include "core/threads/thread_pool.h"

namespace pliant::server {
namespace {

EngineInput Square() {
  Domain domain{.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}},
                .segments = {{0, 1, 1}, {1, 2, 2}, {2, 3, 3}, {3, 0, 4}},
                .holes = {},
                .regions = {}};
  return {.start = std::move(domain), .metric = {.source = SizeMetric{"0.2"}}, .options = {}};
}

// Goal: a session's engine is the core's engine: the same calls give the same mesh, whatever the
// budgets of the single steps.
TEST(Engine, GivesTheSameMeshAsTheCoreInOneGo) {
  const EngineInput input = Square();
  auto remesher = *Remesher::Create(std::get<Domain>(input.start), input.metric, input.options);
  ASSERT_TRUE(remesher->Step({}).ok());
  const MeshDiff expected = remesher->Commit();

  auto engine = *RemesherFactory()(input);
  for (;;) {
    const Result<Progress> progress = engine->Step({.visits_max = 7});
    ASSERT_TRUE(progress.ok());
    if (progress->stop_reason != StopReason::kVisitBudget) break;
  }
  const MeshDiff diff = engine->Commit();
  EXPECT_EQ(diff.summary, expected.summary);
  EXPECT_EQ(engine->Snapshot().summary, expected.summary);
  EXPECT_EQ(engine->revision(), Revision(1));
  EXPECT_TRUE(engine->Validate().empty());
  EXPECT_EQ(MeasureQuality(*engine, MetricBasis::kLimited).vertex_count,
            expected.summary.vertex_count);
}

// Goal: corners that the metric does not need go once in an update, before its first step, whatever
// the budgets of the steps; and only where the session says how far they may.
TEST(Engine, SoftensTheBoundaryOnceInAnUpdate) {
  EngineInput input = Square();
  Domain& domain = std::get<Domain>(input.start);
  domain = {};
  constexpr std::int32_t kCount = 100;
  for (std::int32_t i = 0; i < kCount; ++i) {
    const double angle = 2 * 3.14159265358979 * i / kCount;
    domain.points.push_back({std::cos(angle), std::sin(angle)});
    domain.segments.push_back({i, (i + 1) % kCount, 1});
  }
  const auto edges_after = [&](double tolerance, std::int64_t visits) {
    input.options.boundary_tolerance = tolerance;
    auto engine = *RemesherFactory()(input);
    EXPECT_TRUE(engine->Step({}).ok());
    const MeshDiff first = engine->Commit();
    EXPECT_EQ(first.summary.edge_count, kCount);
    MotionRequest request;
    request.vertices = engine->Vertices();
    for (const Vec2 p : first.vertex_positions) request.positions.push_back({1.1 * p.x, p.y});
    EXPECT_TRUE(engine->Move(request).ok());
    StopReason reason = StopReason::kVisitBudget;
    while (reason == StopReason::kVisitBudget) {
      reason = engine->Step({.visits_max = visits})->stop_reason;
    }
    return engine->Commit().summary;
  };
  EXPECT_EQ(edges_after(0, 1000).edge_count, kCount);
  const MeshSummary softened = edges_after(0.03, 1000);
  EXPECT_LT(softened.edge_count, 50);
  EXPECT_EQ(edges_after(0.03, 7), softened);
}

// Goal: fields go in, follow the mesh and come out with diffs and snapshots, with rows beside them.
TEST(Engine, CarriesFieldsAndTellsThem) {
  auto engine = *RemesherFactory()(Square());
  ASSERT_TRUE(engine->Step({}).ok());
  const MeshDiff first = engine->Commit();
  EXPECT_FALSE(first.transfer.has_value());
  FieldValues values{.name = "u"};
  for (const Vec2 p : first.vertex_positions) values.values.push_back(2 * p.x - p.y);
  ASSERT_TRUE(engine->SetFields({.values = {values}}).ok());
  ASSERT_TRUE(engine->SetMetric({.source = SizeMetric{"0.1"}}).ok());
  ASSERT_TRUE(engine->Step({}).ok());
  const MeshDiff diff = engine->CommitAndTransfer();
  ASSERT_TRUE(diff.transfer.has_value());
  EXPECT_EQ(diff.transfer->vertex_ids, diff.vertex_ids);
  ASSERT_EQ(diff.fields.changed.size(), 1U);
  const MeshDiff snapshot = engine->Snapshot();
  ASSERT_EQ(snapshot.fields.changed.size(), 1U);
  const FieldRows& rows = snapshot.fields.changed[0].rows;
  ASSERT_EQ(rows.slots.size(), snapshot.vertex_ids.size());
  for (std::size_t i = 0; i < rows.slots.size(); ++i) {
    const Vec2 p = snapshot.vertex_positions[i];
    EXPECT_EQ(rows.slots[i], snapshot.vertex_ids[i].value());
    EXPECT_NEAR(rows.values[i], 2 * p.x - p.y, 1e-13);
  }
}

// Goal: rows are there where they are asked for and nowhere else; nothing else depends on it.
TEST(Engine, MakesTransferRowsOnlyWhenAsked) {
  std::vector<MeshDiff> diffs;
  for (const bool with_rows : {false, true}) {
    auto engine = *RemesherFactory()(Square());
    ASSERT_TRUE(engine->Step({}).ok());
    const MeshDiff first = engine->Commit();
    const std::vector<double> ones(first.vertex_ids.size(), 1.0);
    ASSERT_TRUE(engine->SetFields({.values = {{.name = "u", .values = ones}}}).ok());
    ASSERT_TRUE(engine->SetMetric({.source = SizeMetric{"0.1"}}).ok());
    ASSERT_TRUE(engine->Step({}).ok());
    diffs.push_back(with_rows ? engine->CommitAndTransfer() : engine->Commit());
    EXPECT_EQ(diffs.back().transfer.has_value(), with_rows);
  }
  EXPECT_EQ(diffs[0].summary, diffs[1].summary);
  ASSERT_EQ(diffs[0].fields.changed.size(), 1U);
  EXPECT_EQ(diffs[0].fields.changed[0].rows.values, diffs[1].fields.changed[0].rows.values);
}

// Goal: the metric of a solution, by values and by the name of a field, gives the same mesh.
// Goal: values that are too large are named as what was sent, not as the tensors made of them.
TEST(Engine, NamesTheSolutionWhoseMetricNoMeshCanFollow) {
  auto engine = *RemesherFactory()(Square());
  ASSERT_TRUE(engine->Step({}).ok());
  static_cast<void>(engine->Commit());
  std::vector<double> values(static_cast<std::size_t>(engine->vertex_count()));
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = i % 2 == 0 ? 1e200 : -1e200;
  const Status refused =
      engine->SetSolution({.values = values, .target = {.target = TargetError{1e-3}}}, {});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "metric.solution.field") << refused.error().message;
  EXPECT_NE(refused.error().message.find("solution"), std::string::npos);
}

TEST(Engine, FollowsASolutionByValuesAndByName) {
  std::vector<std::uint64_t> hashes;
  for (const bool by_name : {false, true}) {
    auto engine = *RemesherFactory()(Square());
    ASSERT_TRUE(engine->Step({}).ok());
    const MeshDiff first = engine->Commit();
    FieldValues values{.name = "u"};
    for (const Vec2 p : first.vertex_positions) values.values.push_back(p.x * p.x * p.x);
    ASSERT_TRUE(engine->SetFields({.values = {values}}).ok());
    SolutionRequest request{.name = "u", .target = {.target = TargetComplexity{300}}};
    EXPECT_EQ(engine->SetSolution(request, {}).error().code, ErrorCode::kOutOfRange)
        << "the field is only staged";
    (void)engine->Commit();
    if (!by_name) request.values = values.values;
    ASSERT_TRUE(engine->SetSolution(request, {}).ok());
    ASSERT_TRUE(engine->Step({}).ok());
    const MeshDiff diff = engine->Commit();
    EXPECT_NEAR(diff.summary.triangle_count * 0.433 / 300, 1, 0.15);
    hashes.push_back(diff.summary.state_hash);
    request.values = std::vector<double>(3, 1.0);
    EXPECT_EQ(engine->SetSolution(request, {}).error().code, ErrorCode::kArrayLength);
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

// Goal: a solution's metric holds together with a function of place.
TEST(Engine, FollowsASolutionBesideAFunction) {
  auto engine = *RemesherFactory()(Square());
  ASSERT_TRUE(engine->Step({}).ok());
  const MeshDiff first = engine->Commit();
  SolutionRequest request{.name = {}, .target = {.target = TargetComplexity{100}}};
  request.values.emplace();
  for (const Vec2 p : first.vertex_positions) request.values->push_back(p.x * p.x * p.x);
  const FunctionsSpec fine{.parts = {SizeMetric{"y < 0.2 ? 0.02 : 1"}}};
  MetricLimits limits = engine->limits();
  limits.gradation.automatic = false;
  ASSERT_TRUE(engine->SetSolution(request, {limits, fine}).ok());
  ASSERT_NE(engine->functions(), nullptr);
  EXPECT_EQ(*engine->functions(), fine);
  ASSERT_TRUE(engine->Step({}).ok());
  const std::int32_t fine_count = engine->Commit().summary.vertex_count;
  EXPECT_GT(fine_count, 400);
  request.values.reset();
  EXPECT_EQ(engine->SetSolution(request, {}).error().code, ErrorCode::kOutOfRange);
  ASSERT_TRUE(engine->SetFunctions({.parts = {SizeMetric{"1"}}}, limits).ok());
  ASSERT_TRUE(engine->Step({}).ok());
  const std::int32_t count = engine->Commit().summary.vertex_count;
  EXPECT_GT(count, 80) << "the solution's tensors are still there";
  EXPECT_LT(count, fine_count / 2);
}

// Goal: threads are used for a mesh that is large enough, and no bit depends on them.
TEST(Engine, GivesTheSameMeshWithThreads) {
  EngineInput input = Square();
  input.metric.source = SizeMetric{"0.0029"};
  ThreadPool threads(3);
  std::vector<std::uint64_t> hashes;
  int threads_used = 1;
  for (ThreadPool* helpers : {static_cast<ThreadPool*>(nullptr), &threads}) {
    auto engine = *RemesherFactory(helpers)(input);
    while (engine->Step({.visits_max = 50'000})->stop_reason == StopReason::kVisitBudget) {
      EXPECT_TRUE(engine->step_threads() == 1 || helpers != nullptr);
      threads_used = std::max(threads_used, engine->step_threads());
    }
    hashes.push_back(engine->Commit().summary.state_hash);
    EXPECT_EQ(engine->step_threads(), 1) << "updates run on one thread";
  }
  EXPECT_EQ(threads_used, 3);
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(Engine, PassesTheCoresRefusalsOn) {
  EngineInput input = Square();
  std::get<Domain>(input.start).segments.pop_back();
  const auto engine = RemesherFactory()(input);
  ASSERT_FALSE(engine.ok());
  EXPECT_EQ(engine.error().code, ErrorCode::kOpenLoop);
}

/// What is measured of a mesh of some thousand triangles, with a metric by `update`.
template <class Update>
Quality MeasuredWith(ThreadPool* threads, const Update& update) {
  EngineInput input = Square();
  input.metric = {.source = SizeMetric{"0.03 + 0.02*x"}};
  auto engine = *RemesherFactory(threads)(input);
  EXPECT_TRUE(engine->Step({}).ok());
  (void)engine->Commit();
  EXPECT_TRUE(update(*engine).ok());
  EXPECT_TRUE(engine->Step({}).ok());
  (void)engine->Commit();
  return MeasureQuality(*engine, MetricBasis::kLimited);
}

// Goal: whoever helps, the bits are the same, and no field is asked by several threads that cannot
// be; the thread sanitizer sees the latter.
TEST(Engine, MeasuresTheSameWithThreads) {
  ThreadPool threads(4);
  const auto expect_same = [&](const auto& update) {
    EXPECT_EQ(MeasuredWith(&threads, update), MeasuredWith(nullptr, update));
  };
  expect_same(
      [](Engine& engine) { return engine.SetMetric({.source = SizeMetric{"0.03 + 0.02*y"}}); });
  expect_same([](Engine& engine) {
    const std::vector<VertexId> vertices = engine.Vertices();
    const std::vector<Metric> tensors(vertices.size(), Metric::Isotropic(0.03));
    return engine.SetTensors(vertices, tensors, {});
  });
  expect_same([](Engine& engine) {
    MetricSpec limited{.source = SizeMetric{"0.02 + 0.1*y"}};
    limited.gradation.gradation = 1.1;
    return engine.SetMetric(limited);
  });
}

}  // namespace
}  // namespace pliant::server
