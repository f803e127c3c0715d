#include "client/cli/job_report.h"

#include <gtest/gtest.h>

#include <chrono>

namespace pliant::cli {
namespace {

client::JobInfo Job(client::JobState state) {
  client::JobInfo job;
  job.job_id = "plate";
  job.state = state;
  job.create_time = std::chrono::system_clock::time_point(std::chrono::seconds(1'000'000'000));
  return job;
}

TEST(JobReport, ShowsARunningJobWithItsProgress) {
  client::JobInfo job = Job(client::JobState::kRunning);
  job.progress = client::AdvanceProgress{
      .active_count = 1, .visits = 2, .vertex_count = 34'567, .elapsed = std::chrono::seconds(2)};
  EXPECT_EQ(JobText(job),
            "plate  running  34,567 vertices so far  submitted 2001-09-09T01:46:40Z\n");
  const Json json = JobJson(job);
  EXPECT_EQ(json["state"], "running");
  EXPECT_EQ(json["progress"]["seconds"], 2.0);
  EXPECT_FALSE(json.contains("end_time") || json.contains("quality") || json.contains("error"));
}

TEST(JobReport, ShowsADoneJobAsRemeshReportsIt) {
  client::JobInfo job = Job(client::JobState::kDone);
  job.report = client::AdvanceReport{.summary = {.vertex_count = 1234, .triangle_count = 2345}};
  job.quality = Quality{};
  job.expire_time = job.create_time;
  EXPECT_EQ(JobText(job),
            "plate  done  1,234 vertices  2,345 triangles  submitted 2001-09-09T01:46:40Z  kept "
            "until 2001-09-09T01:46:40Z\n");
  const Json json = JobJson(job);
  for (const char* key : {"vertex_count", "state_hash", "stop", "loop", "troubles", "quality"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_TRUE(JobStatus(job).ok());
}

TEST(JobReport, GivesAnEndWithoutMeshAsAnError) {
  client::JobInfo failed = Job(client::JobState::kFailed);
  failed.error = Error{ErrorCode::kOpenLoop, "it is open", "domain.segments", 4};
  EXPECT_EQ(JobStatus(failed).error().code, ErrorCode::kOpenLoop);
  EXPECT_EQ(JobJson(failed)["error"]["code"], "OPEN_LOOP");
  EXPECT_EQ(JobJson(failed)["error"]["index"], 4);
  EXPECT_NE(JobText(failed).find("OPEN_LOOP at domain.segments[4]"), std::string::npos);
  EXPECT_EQ(JobStatus(Job(client::JobState::kCancelled)).error().code, ErrorCode::kJobNotDone);
}

}  // namespace
}  // namespace pliant::cli
