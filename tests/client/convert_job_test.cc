#include "client/cpp/convert_job.h"

#include <gtest/gtest.h>

#include <chrono>

namespace pliant::client {
namespace {

using std::chrono::seconds;

TEST(ConvertJob, WritesWhatWasAskedForAndNoMore) {
  JobSettings settings{.job_id = "mine", .priority = -4, .keep = std::chrono::milliseconds(9)};
  settings.advance.visits_max = 5;
  const v1::SubmitJob submit = ToWire(settings);
  EXPECT_EQ(submit.job_id(), "mine");
  EXPECT_EQ(submit.priority(), -4);
  EXPECT_EQ(submit.keep_ms(), 9);
  EXPECT_EQ(submit.advance().budget_visits(), 5);
  EXPECT_FALSE(submit.advance().has_budget_ms());
  EXPECT_FALSE(submit.advance().has_progress_interval_ms());
  EXPECT_FALSE(submit.has_input());
}

TEST(ConvertJob, ReadsAJobInEachState) {
  v1::Job job;
  job.set_job_id("a");
  job.set_state(v1::JOB_STATE_RUNNING);
  job.set_priority(2);
  job.mutable_create_time()->set_seconds(10);
  job.mutable_progress()->set_visit_count(17);
  JobInfo info = FromWire(job).value();
  EXPECT_EQ(info.state, JobState::kRunning);
  EXPECT_EQ(info.priority, 2);
  EXPECT_EQ(info.progress->visits, 17);
  EXPECT_EQ(info.create_time.time_since_epoch(), seconds(10));
  EXPECT_FALSE(info.end_time || info.expire_time || info.report || info.quality || info.error);
  EXPECT_FALSE(HasEnded(info.state));

  job.clear_progress();
  job.set_state(v1::JOB_STATE_FAILED);
  job.mutable_end_time()->set_nanos(500'000'000);
  job.mutable_expire_time()->set_seconds(30);
  job.mutable_error()->set_reason("OPEN_LOOP");
  job.mutable_error()->set_index(3);
  info = FromWire(job).value();
  EXPECT_EQ(info.error->code, ErrorCode::kOpenLoop);
  EXPECT_EQ(info.error->index, 3);
  EXPECT_EQ(info.end_time->time_since_epoch(), std::chrono::milliseconds(500));
  EXPECT_EQ(info.expire_time->time_since_epoch(), seconds(30));
  EXPECT_TRUE(HasEnded(info.state));

  job.clear_error();
  job.set_state(v1::JOB_STATE_DONE);
  job.mutable_result()->set_state_hash(99);
  job.mutable_quality()->set_q_mean(0.5);
  job.mutable_quality()->mutable_angle_deg()->mutable_counts()->Resize(60, 0);
  job.mutable_quality()->mutable_averaged()->mutable_histogram()->mutable_counts()->Resize(60, 0);
  job.mutable_quality()->mutable_angle_deg()->set_high(180);
  job.mutable_quality()->mutable_averaged()->mutable_histogram()->set_high(2);
  const Result<JobInfo> done = FromWire(job);
  ASSERT_TRUE(done.ok()) << done.error().message;
  EXPECT_EQ(done->report->summary.state_hash, 99U);
  EXPECT_EQ(done->quality->q_mean, 0.5);

  job.set_state(v1::JOB_STATE_UNSPECIFIED);
  EXPECT_EQ(FromWire(job).error().field, "job.state");
}

}  // namespace
}  // namespace pliant::client
