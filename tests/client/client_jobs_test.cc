// The calls on jobs where a server misbehaves or goes away; against a real one they are tested in
// live/live_jobs_test.cc.
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "client/cpp/client.h"
#include "pliant/v1/job.grpc.pb.h"
#include "tests/client/fake_server.h"

namespace pliant::client {
namespace {

using std::chrono::milliseconds;

/// Says about jobs what a test says.
class FakeJobs final : public v1::JobService::Service, public v1::ServerService::Service {
 public:
  FakeJobs() {
    int port = 0;
    grpc::ServerBuilder builder;
    builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
    builder.RegisterService(static_cast<v1::JobService::Service*>(this));
    builder.RegisterService(static_cast<v1::ServerService::Service*>(this));
    server_ = builder.BuildAndStart();
    address_ = "127.0.0.1:" + std::to_string(port);
  }
  ~FakeJobs() override { server_->Shutdown(std::chrono::system_clock::now()); }
  [[nodiscard]] const std::string& address() const { return address_; }

  std::function<grpc::Status(int call, v1::Job&)> on_get;
  std::function<void(const v1::ListJobsRequest&, v1::ListJobsResponse&)> on_list;
  int get_count = 0;

 private:
  grpc::Status GetServerInfo(grpc::ServerContext*, const v1::GetServerInfoRequest*,
                             v1::GetServerInfoResponse*) override {
    return grpc::Status::OK;
  }
  grpc::Status GetJob(grpc::ServerContext*, const v1::GetJobRequest* request,
                      v1::GetJobResponse* response) override {
    response->mutable_job()->set_job_id(request->job_id());
    return on_get(++get_count, *response->mutable_job());
  }
  grpc::Status ListJobs(grpc::ServerContext*, const v1::ListJobsRequest* request,
                        v1::ListJobsResponse* response) override {
    on_list(*request, *response);
    return grpc::Status::OK;
  }
  grpc::Status FetchResult(grpc::ServerContext*, const v1::FetchResultRequest*,
                           grpc::ServerWriter<v1::FetchResultResponse>*) override {
    return grpc::Status::OK;
  }

  std::string address_;
  std::unique_ptr<grpc::Server> server_;
};

class ClientJobsTest : public testing::Test {
 protected:
  FakeJobs server_;
  Client client_ = Client::Connect(server_.address()).value();
};

TEST_F(ClientJobsTest, WaitThroughTheRestartOfAServer) {
  server_.on_get = [](int call, v1::Job& job) -> grpc::Status {
    job.set_state(call < 5 ? v1::JOB_STATE_RUNNING : v1::JOB_STATE_CANCELLED);
    if (call == 2 || call == 3) return {grpc::StatusCode::UNAVAILABLE, "restarting"};
    return grpc::Status::OK;
  };
  int look_count = 0;
  JobWait wait;
  wait.on_look = [&](const JobInfo&) { return ++look_count > 0; };
  EXPECT_EQ(client_.WaitForJob("a", wait).value().state, JobState::kCancelled);
  EXPECT_EQ(look_count, 2);
  EXPECT_EQ(server_.get_count, 5);
}

TEST_F(ClientJobsTest, WaitNoLongerForAServerThatStaysAway) {
  server_.on_get = [](int, v1::Job&) -> grpc::Status {
    return {grpc::StatusCode::UNAVAILABLE, "gone"};
  };
  EXPECT_EQ(client_.WaitForJob("a", {.reconnect_max = milliseconds(0)}).error().code,
            ErrorCode::kUnavailable);
  EXPECT_EQ(server_.get_count, 1);
  server_.on_get = [](int, v1::Job&) -> grpc::Status {
    return {grpc::StatusCode::NOT_FOUND, "no such job"};
  };
  EXPECT_FALSE(client_.WaitForJob("a").ok()) << "a refusal is not waited through";
  EXPECT_EQ(server_.get_count, 2);
}

TEST_F(ClientJobsTest, JoinPagesToOneList) {
  server_.on_list = [](const v1::ListJobsRequest& request, v1::ListJobsResponse& response) {
    const bool is_first = request.page_token().empty();
    v1::Job& job = *response.add_jobs();
    job.set_job_id(is_first ? "b" : "a");
    job.set_state(v1::JOB_STATE_QUEUED);
    if (is_first) response.set_next_page_token("7");
  };
  const std::vector<JobInfo> jobs = client_.ListJobs().value();
  ASSERT_EQ(jobs.size(), 2U);
  EXPECT_EQ(jobs[1].job_id, "a");
}

TEST_F(ClientJobsTest, RefuseADownloadWithoutAMesh) {
  EXPECT_EQ(client_.FetchResult("a").error().code, ErrorCode::kInternal);
}

}  // namespace
}  // namespace pliant::client
