#include "server/job_service.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "server/limits.h"
#include "tests/support/fake_server_parts.h"
#include "tests/support/job_client.h"

namespace pliant::server {
namespace {

std::string IdOf(int i) { return std::string("job-").append(std::to_string(i)); }

class JobServiceTest : public testing::Test {
 protected:
  std::vector<std::string> Ids(std::int32_t page_size, const std::string& token,
                               std::string* next) {
    v1::ListJobsRequest request;
    request.set_page_size(page_size);
    request.set_page_token(token);
    v1::ListJobsResponse response;
    EXPECT_TRUE(client_.List(request, &response).ok());
    EXPECT_LE(response.ByteSizeLong(), static_cast<std::size_t>(kMessageBytesMax));
    *next = response.next_page_token();
    std::vector<std::string> ids;
    for (const v1::Job& job : response.jobs()) ids.push_back(job.job_id());
    return ids;
  }

  std::shared_ptr<FakeEngineScript> script_ = std::make_shared<FakeEngineScript>();
  test::InProcessServer server_{FakeFactory(script_), {.jobs = {.jobs_max = 2000}}};
  test::JobClient client_{server_};
};

TEST_F(JobServiceTest, AnswersEveryCallOnAJob) {
  ASSERT_TRUE(client_.Submit(test::SquareJob("a")).ok());
  const v1::Job job = client_.Wait("a");
  EXPECT_EQ(job.state(), v1::JOB_STATE_DONE);
  EXPECT_EQ(job.result().visit_count(), 10);
  EXPECT_EQ(job.quality().counts().vertex_count(), 3);
  EXPECT_GE(job.expire_time().seconds(), job.end_time().seconds());
  v1::MeshSnapshot mesh;
  ASSERT_TRUE(client_.Fetch("a", &mesh).ok());
  EXPECT_EQ(mesh.revision(), 1);
  EXPECT_EQ(test::NumbersOf<std::int32_t>(mesh.vertex_ids()), (std::vector<std::int32_t>{0, 2}));
  v1::Job cancelled;
  ASSERT_TRUE(client_.Cancel("a", &cancelled).ok());
  EXPECT_EQ(cancelled.state(), v1::JOB_STATE_DONE);
}

TEST_F(JobServiceTest, KnowsNoOtherJobs) {
  v1::Job job;
  v1::MeshSnapshot mesh;
  for (const grpc::Status& status :
       {client_.Get("x", &job), client_.Cancel("x", &job), client_.Fetch("x", &mesh)}) {
    EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
    EXPECT_EQ(test::ReasonOf(status), "JOB_NOT_FOUND");
  }
}

TEST_F(JobServiceTest, SaysThatAFailedJobHasNoMesh) {
  script_->create_error = Error{ErrorCode::kOpenLoop, "open", "domain.segments", 2};
  ASSERT_TRUE(client_.Submit(test::SquareJob("a")).ok());
  const v1::Job job = client_.Wait("a");
  EXPECT_EQ(job.state(), v1::JOB_STATE_FAILED);
  EXPECT_EQ(job.error().reason(), "OPEN_LOOP");
  EXPECT_EQ(job.error().index(), 2);
  v1::MeshSnapshot mesh;
  const grpc::Status status = client_.Fetch("a", &mesh);
  EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(test::ReasonOf(status), "JOB_NOT_DONE");
}

TEST_F(JobServiceTest, FetchesWithAnyNumberingAndKnownParts) {
  ASSERT_TRUE(client_.Submit(test::SquareJob("a")).ok());
  client_.Wait("a");
  v1::FetchResultRequest request;
  request.set_job_id("a");
  v1::MeshSnapshot mesh;
  request.set_numbering(v1::NUMBERING_DENSE);
  ASSERT_TRUE(client_.Fetch(request, &mesh).ok());
  EXPECT_EQ(mesh.numbering(), v1::NUMBERING_DENSE);
  request.set_numbering(v1::NUMBERING_UNSPECIFIED);
  EXPECT_EQ(test::ReasonOf(client_.Fetch(request, &mesh)), "OUT_OF_RANGE");
  request.clear_numbering();
  request.add_parts(v1::MESH_PART_RAW_METRIC);
  EXPECT_EQ(test::ReasonOf(client_.Fetch(request, &mesh)), "UNIMPLEMENTED");
}

// Goal: a page is one message of at most 1 MiB, however long reports are, and no job is lost or
// shown twice between pages. Method: 1,500 jobs, whose reports are about 500 bytes each.
TEST_F(JobServiceTest, ListsNewestFirstInPagesThatFitIntoAMessage) {
  constexpr int kCount = 1500;
  for (int i = 0; i < kCount; ++i) {
    ASSERT_TRUE(client_.Submit(test::SquareJob(IdOf(i))).ok());
  }
  for (int i = 0; i < kCount; ++i) client_.Wait(IdOf(i));
  std::string next;
  EXPECT_THAT(Ids(2, "", &next), testing::ElementsAre("job-1499", "job-1498"));
  EXPECT_THAT(Ids(2, next, &next), testing::ElementsAre("job-1497", "job-1496"));
  std::vector<std::string> all;
  next = "";
  do {
    for (const std::string& id : Ids(kPageSizeMax, next, &next)) all.push_back(id);
  } while (!next.empty());
  ASSERT_EQ(all.size(), static_cast<std::size_t>(kCount));
  for (int i = 0; i < kCount; ++i) {
    EXPECT_EQ(all[static_cast<std::size_t>(i)], IdOf(kCount - 1 - i));
  }
}

TEST_F(JobServiceTest, RefusesPagesThatAreOutOfRange) {
  v1::ListJobsRequest request;
  v1::ListJobsResponse response;
  request.set_page_size(kPageSizeMax + 1);
  EXPECT_EQ(test::ReasonOf(client_.List(request, &response)), "OUT_OF_RANGE");
  request.set_page_size(0);
  request.set_page_token("x");
  EXPECT_EQ(test::ReasonOf(client_.List(request, &response)), "OUT_OF_RANGE");
}

}  // namespace
}  // namespace pliant::server
