// Jobs through the client library, against a real pliantd and the core in this process.

#include <gtest/gtest.h>

#include <chrono>
#include <string>

#include "client/cpp/client.h"
#include "core/pliant/remesher.h"
#include "tests/client/live/inputs.h"
#include "tests/client/live/pliantd_process.h"

namespace pliant::client {
namespace {

using std::chrono::milliseconds;

// A job that runs for minutes unless it is stopped.
const char* const kEndless = "0.0007";

class LiveJobs : public testing::Test {
 protected:
  PliantdProcess server_;
  Client client_ = Client::Connect(server_.address()).value();
};

TEST_F(LiveJobs, MakeTheMeshOfTheCoreInThisProcess) {
  JobSettings settings{.job_id = "mine", .priority = 3, .keep = milliseconds(3'600'000)};
  settings.options.variant = Variant::kPaper;
  settings.options.seed = 7;
  const Result<JobInfo> submitted = client_.SubmitJob(Square(), Size("0.02 + 0.1*x"), settings);
  ASSERT_TRUE(submitted.ok()) << submitted.error().message;
  EXPECT_EQ(submitted->job_id, "mine");
  EXPECT_EQ(submitted->state, JobState::kQueued);
  const Result<JobInfo> done = client_.WaitForJob("mine");
  ASSERT_TRUE(done.ok()) << done.error().message;
  ASSERT_EQ(done->state, JobState::kDone);

  auto remesher = Remesher::Create(Square(), Size("0.02 + 0.1*x"), settings.options).value();
  ASSERT_TRUE(remesher->Step({}).ok());
  const MeshSummary expected = remesher->Commit().summary;
  EXPECT_EQ(done->report->summary, expected);
  EXPECT_EQ(done->quality->triangle_count, expected.triangle_count);
  EXPECT_EQ(done->priority, 3);
  EXPECT_EQ(*done->expire_time - *done->end_time, milliseconds(3'600'000));
  const Result<MeshReplica> mesh = client_.FetchResult("mine", Parts::kMeshAndMetric);
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_EQ(mesh->summary(), expected);
  EXPECT_EQ(mesh->Compact().metrics.size(), static_cast<std::size_t>(expected.vertex_count));
}

TEST_F(LiveJobs, TellWhatWasWrongWithTheirInput) {
  Domain crossing = Square();
  crossing.segments = {{0, 2, 0}, {2, 1, 0}, {1, 3, 0}, {3, 0, 0}};
  const JobInfo job = client_.SubmitJob(crossing, Size("0.1")).value();
  const JobInfo failed = client_.WaitForJob(job.job_id).value();
  ASSERT_EQ(failed.state, JobState::kFailed);
  EXPECT_EQ(failed.error->code, ErrorCode::kCrossingSegments);
  EXPECT_EQ(failed.error->index, 0);
  EXPECT_EQ(client_.FetchResult(job.job_id).error().code, ErrorCode::kJobNotDone);
  EXPECT_EQ(client_.GetJob("nobody").error().code, ErrorCode::kJobNotFound);
}

TEST_F(LiveJobs, AreListedAndCancelled) {
  ASSERT_TRUE(client_.SubmitJob(Square(), Size(kEndless), {.job_id = "a"}).ok());
  ASSERT_TRUE(client_.SubmitJob(Square(), Size(kEndless), {.job_id = "b"}).ok());
  EXPECT_EQ(client_.SubmitJob(Square(), Size("1"), {.job_id = "b"}).error().code,
            ErrorCode::kJobExists);
  const std::vector<JobInfo> jobs = client_.ListJobs().value();
  ASSERT_EQ(jobs.size(), 2U);
  EXPECT_EQ(jobs[0].job_id, "b") << "the newest first";
  EXPECT_EQ(client_.WaitForJob("b", {.time_max = milliseconds(50)}).error().code,
            ErrorCode::kDeadlineExceeded);
  // Waits until it works, then for as long as it is told to.
  JobWait wait;
  wait.on_look = [](const JobInfo& job) { return !job.progress || job.progress->visits == 0; };
  EXPECT_EQ(client_.WaitForJob("a", wait).error().code, ErrorCode::kCancelled);
  for (const char* id : {"a", "b"}) {
    EXPECT_EQ(client_.CancelJob(id).value().state, JobState::kCancelled);
    EXPECT_EQ(client_.WaitForJob(id).value().state, JobState::kCancelled);
  }
}

}  // namespace
}  // namespace pliant::client
