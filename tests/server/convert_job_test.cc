#include "server/convert_job.h"

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/wire_arrays.h"

namespace pliant::server {
namespace {

using std::chrono::milliseconds;

constexpr RequestLimits kJobLimits = {.vertices_max = 1000};
constexpr JobKeep kKeep = {.usual = milliseconds(500), .max = milliseconds(900)};

v1::SubmitJob GoodSubmit() {
  v1::SubmitJob submit;
  submit.set_job_id("mine");
  *submit.mutable_input() = test::UnitSquare();
  submit.mutable_advance()->set_budget_visits(77);
  submit.set_priority(-3);
  submit.set_keep_ms(900);
  return submit;
}

TEST(ConvertJob, ReadsWhatASubmissionWrote) {
  const JobSubmission submission = ConvertSubmit(GoodSubmit(), kJobLimits, kKeep).value();
  EXPECT_EQ(submission.draft.key.job_id, "mine");
  EXPECT_EQ(submission.draft.priority, -3);
  EXPECT_EQ(submission.draft.keep, milliseconds(900));
  EXPECT_EQ(submission.draft.input_size, submission.input.size());
  const JobInput input = WireJobCodec(kJobLimits).read_input(submission.input).value();
  EXPECT_EQ(input.advance.visits_max, 77);
  EXPECT_EQ(std::get<Domain>(input.engine.start).points.size(), 4U);
  EXPECT_EQ(std::get<SizeMetric>(input.engine.metric.source).size, "0.2");
  Bytes cut = submission.input;
  cut.resize(cut.size() / 2);
  EXPECT_EQ(WireJobCodec(kJobLimits).read_input(cut).error().code, ErrorCode::kDataCorrupt);
}

TEST(ConvertJob, KeepsAResultAsLongAsAskedForOrUsual) {
  const auto keep_of = [](std::int64_t keep_ms) {
    v1::SubmitJob submit = GoodSubmit();
    submit.set_keep_ms(keep_ms);
    return ConvertSubmit(submit, kJobLimits, kKeep);
  };
  EXPECT_EQ(keep_of(0)->draft.keep, milliseconds(500));
  EXPECT_EQ(keep_of(1)->draft.keep, milliseconds(1));
  EXPECT_EQ(keep_of(901).error().field, "keep_ms");
  EXPECT_EQ(keep_of(-1).error().code, ErrorCode::kOutOfRange);
}

TEST(ConvertJob, NamesWhatIsWrongWithASubmission) {
  const std::vector<std::pair<std::string, std::function<void(v1::SubmitJob&)>>> spoilers = {
      {"job_id", [](v1::SubmitJob& s) { s.set_job_id("a b"); }},
      {"job_id", [](v1::SubmitJob& s) { s.set_job_id(std::string(65, 'x')); }},
      {"input.session_id", [](v1::SubmitJob& s) { s.mutable_input()->set_session_id("s"); }},
      {"input.labels", [](v1::SubmitJob& s) { (*s.mutable_input()->mutable_labels())["a"] = "b"; }},
      {"advance.commit_interval_ms",
       [](v1::SubmitJob& s) { s.mutable_advance()->set_commit_interval_ms(100); }},
      {"advance.budget_visits",
       [](v1::SubmitJob& s) { s.mutable_advance()->set_budget_visits(0); }},
      {"metric.sources", [](v1::SubmitJob& s) { s.mutable_input()->clear_metric(); }},
      {"domain", [](v1::SubmitJob& s) { s.clear_input(); }},
      {"domain.segments",
       [](v1::SubmitJob& s) {
         *s.mutable_input()->mutable_domain()->mutable_segments() = test::Ints({0, 1, 1, 9}, 2);
       }},
  };
  for (const auto& [field, spoil] : spoilers) {
    v1::SubmitJob bad = GoodSubmit();
    spoil(bad);
    const Result<JobSubmission> submission = ConvertSubmit(bad, kJobLimits, kKeep);
    ASSERT_FALSE(submission.ok()) << field;
    EXPECT_EQ(submission.error().field, field);
  }
}

TEST(ConvertJob, ShowsAJobInEachState) {
  JobInfo info{.key = {"t", "mine"},
               .priority = 5,
               .keep = milliseconds(1500),
               .create_time = Clock::WallTime(std::chrono::seconds(10))};
  v1::Job job = ToJob(info);
  EXPECT_EQ(job.job_id(), "mine");
  EXPECT_EQ(job.state(), v1::JOB_STATE_QUEUED);
  EXPECT_EQ(job.priority(), 5);
  EXPECT_EQ(job.create_time().seconds(), 10);
  EXPECT_FALSE(job.has_end_time() || job.has_expire_time() || job.has_progress());

  info.state = JobState::kRunning;
  info.progress = JobProgress{.vertex_count = 9, .elapsed = milliseconds(4)};
  info.progress->progress.active_count = 3;
  info.progress->progress.counts.visits = 8;
  job = ToJob(info);
  EXPECT_EQ(job.state(), v1::JOB_STATE_RUNNING);
  EXPECT_EQ(job.progress().active_count(), 3);
  EXPECT_EQ(job.progress().visit_count(), 8);
  EXPECT_EQ(job.progress().vertex_count(), 9);
  EXPECT_EQ(job.progress().elapsed_ms(), 4);

  JobResult result{.revision = Revision(1)};
  result.advanced.summary = {.vertex_count = 4, .triangle_count = 2, .state_hash = 99};
  result.advanced.progress.counts.visits = 12;
  result.quality.q_mean = 0.5;
  info.state = JobState::kDone;
  info.progress.reset();
  info.end_time = Clock::WallTime(std::chrono::seconds(20));
  info.outcome = std::make_shared<const Bytes>(WireJobCodec(kJobLimits).write_result(result));
  job = ToJob(info);
  EXPECT_EQ(job.state(), v1::JOB_STATE_DONE);
  EXPECT_EQ(job.result().revision(), 1);
  EXPECT_EQ(job.result().state_hash(), 99U);
  EXPECT_EQ(job.result().visit_count(), 12);
  EXPECT_EQ(job.result().stop_reason(), v1::STOP_REASON_CONVERGED);
  EXPECT_EQ(job.quality().revision(), 1);
  EXPECT_EQ(job.quality().counts().triangle_count(), 2);
  EXPECT_EQ(job.quality().q_mean(), 0.5);
  EXPECT_EQ(job.end_time().seconds(), 20);
  EXPECT_EQ(job.expire_time().seconds(), 21);
  EXPECT_EQ(job.expire_time().nanos(), 500'000'000);

  info.state = JobState::kFailed;
  info.outcome = std::make_shared<const Bytes>(
      WireJobCodec(kJobLimits)
          .write_error({ErrorCode::kCrossingSegments, "cross", "domain.segments", 1, 3}));
  job = ToJob(info);
  EXPECT_EQ(job.state(), v1::JOB_STATE_FAILED);
  EXPECT_EQ(job.error().reason(), "CROSSING_SEGMENTS");
  EXPECT_EQ(job.error().other_index(), 3);

  info.state = JobState::kCancelled;
  EXPECT_EQ(ToJob(info).state(), v1::JOB_STATE_CANCELLED);
}

}  // namespace
}  // namespace pliant::server
