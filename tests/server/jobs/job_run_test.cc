#include "server/jobs/job_run.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "core/mesh/snapshot_bytes.h"
#include "tests/support/job_harness.h"

namespace pliant::server {
namespace {

// One run, slice by slice, and what it said.
struct RunHarness {
  explicit RunHarness(FakeEngineScript first, std::string_view input = "")
      : script(std::make_shared<FakeEngineScript>(std::move(first))) {
    script->clock = &clock;
    const JobInfo info{.key = {"t", "a"}, .number = 3};
    store.Create(info, BytesOf(input), [](const Status&) {});
    run = std::make_unique<JobRun>(
        JobRun::Environment{
            .clock = &clock,
            .log = &log,
            .store = &store,
            .factory = FakeFactory(script),
            .codec = TextCodec(),
            .on_progress = [this](std::int64_t, const JobProgress& p) { progress = p; },
            .on_end = [this](std::int64_t, JobEnd e) { end = std::move(e), ++end_count; },
            .on_stopped = [this](std::int64_t) { ++stopped_count; }},
        JobBoard::Start{.info = info, .stop = stop});
  }
  Task::Outcome Slice() { return run->RunSlice(clock.Now() + std::chrono::milliseconds(2)); }
  int RunAll() {
    int slices = 1;
    while (Slice() == Task::Outcome::kMore) ++slices;
    return slices;
  }
  [[nodiscard]] std::string Outcome() const { return TextOf(end->outcome); }

  ManualClock clock;
  Log log{LogLevel::kError, LogFormat::kText};
  MemoryJobStore store;
  std::shared_ptr<FakeEngineScript> script;
  std::shared_ptr<StopFlag> stop = std::make_shared<StopFlag>();
  std::optional<JobProgress> progress;
  std::optional<JobEnd> end;
  int end_count = 0;
  int stopped_count = 0;
  std::unique_ptr<JobRun> run;
};

TEST(JobRun, EndsWithAMeshAReportAndItsQuality) {
  RunHarness harness({.visits_needed = 10});
  harness.RunAll();
  EXPECT_EQ(harness.end_count, 1);
  EXPECT_EQ(harness.end->state, JobState::kDone);
  EXPECT_EQ(harness.Outcome(), "revision 1 visits 10 active 0 troubles 1 vertices 3");
  const MeshDiff mesh = ReadMeshSnapshot(harness.end->mesh).value();
  EXPECT_EQ(mesh.revision, Revision(1));
  EXPECT_EQ(mesh.vertex_ids.size(), 2U);
  EXPECT_EQ(harness.Slice(), Task::Outcome::kIdle) << "once is enough";
  EXPECT_EQ(harness.end_count, 1);
}

// Goal: a long job shares its worker. Method: 10,000 visits of a microsecond are five slices of
// 2 ms, beside those that build, commit and measure.
TEST(JobRun, WorksInSlicesAndTellsHowFarItIs) {
  RunHarness harness({.visits_needed = 10'000});
  EXPECT_EQ(harness.Slice(), Task::Outcome::kMore);  // Builds.
  EXPECT_EQ(harness.Slice(), Task::Outcome::kMore);
  EXPECT_EQ(harness.progress->progress.counts.visits, 2000);
  EXPECT_EQ(harness.progress->elapsed, std::chrono::milliseconds(2));
  EXPECT_EQ(harness.RunAll(), 4 + 2);
  EXPECT_EQ(harness.end->state, JobState::kDone);
}

TEST(JobRun, KeepsToItsBudgets) {
  RunHarness visits({.visits_needed = 10'000}, "budget 2500");
  visits.RunAll();
  EXPECT_EQ(visits.Outcome(), "revision 1 visits 2500 active 7500 troubles 0 vertices 3");
  RunHarness time({.visits_needed = 10'000}, "time");
  time.RunAll();
  EXPECT_EQ(time.Outcome(), "revision 1 visits 5000 active 5000 troubles 0 vertices 3 late");
}

TEST(JobRun, StopsInTheSliceAfterItIsTold) {
  RunHarness harness({.visits_needed = INT64_MAX / 2});
  for (int i = 0; i < 5; ++i) EXPECT_EQ(harness.Slice(), Task::Outcome::kMore);
  harness.stop->Set(true);
  EXPECT_EQ(harness.Slice(), Task::Outcome::kIdle);
  EXPECT_EQ(harness.stopped_count, 1);
  EXPECT_EQ(harness.end_count, 0);
  EXPECT_EQ(harness.Slice(), Task::Outcome::kIdle);
  EXPECT_EQ(harness.stopped_count, 1);
}

// Goal: the measurement shares its worker too, and stops when it is told. Method: parts of a
// millisecond, two to a slice.
TEST(JobRun, MeasuresInSlices) {
  for (const bool is_stopped : {false, true}) {
    RunHarness harness({.visits_needed = 10});
    harness.script->measurement_part_count = 10;
    int part_count = 0;
    harness.script->during_measurement = [&] {
      harness.clock.Advance(std::chrono::milliseconds(1));
      if (++part_count == 3 && is_stopped) harness.stop->Set(true);
    };
    const int slices = harness.RunAll();
    EXPECT_EQ(harness.stopped_count, is_stopped ? 1 : 0);
    EXPECT_EQ(harness.end_count, is_stopped ? 0 : 1);
    EXPECT_EQ(part_count, is_stopped ? 3 : 10);
    // Build, loop and commit, then the measurement.
    EXPECT_EQ(slices, 3 + (is_stopped ? 3 : 5));
  }
}

TEST(JobRun, FailsWithTheErrorOfItsInputOrItsEngine) {
  RunHarness input({}, "bad");
  input.RunAll();
  EXPECT_EQ(input.end->state, JobState::kFailed);
  EXPECT_EQ(input.Outcome(), "DATA_CORRUPT input");
  EXPECT_TRUE(input.end->mesh.empty());
  RunHarness create({.create_error = Error{ErrorCode::kOpenLoop, "open", "domain.segments"}});
  create.RunAll();
  EXPECT_EQ(create.Outcome(), "OPEN_LOOP domain.segments");
  RunHarness step({.step_error = Error{ErrorCode::kExpressionValue, "nan", "metric.size"}});
  step.RunAll();
  EXPECT_EQ(step.Outcome(), "EXPRESSION_VALUE metric.size");
  EXPECT_EQ(step.end_count, 1);
}

// Goal: promise Isolated: a bug ends this job, with a reference, and nothing else.
TEST(JobRun, EndsABugWithAReference) {
  for (const bool in_step : {true, false}) {
    FakeEngineScript script;
    (in_step ? script.throw_in_step : script.throw_in_commit) = true;
    RunHarness harness(script);
    harness.RunAll();
    EXPECT_EQ(harness.end->state, JobState::kFailed);
    EXPECT_THAT(harness.Outcome(), testing::MatchesRegex("INTERNAL a-[0-9]+"));
    EXPECT_EQ(harness.end_count, 1);
    EXPECT_EQ(harness.Slice(), Task::Outcome::kIdle);
  }
}

}  // namespace
}  // namespace pliant::server
