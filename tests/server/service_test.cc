#include "server/service.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <future>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "server/limits.h"
#include "tests/support/fake_server_parts.h"
#include "tests/support/in_process_server.h"

namespace pliant::server {
namespace {

using testing::Contains;

class ServiceTest : public testing::Test {
 protected:
  void Create(const std::string& id) {
    v1::CreateSession create = test::UnitSquare();
    create.set_session_id(id);
    ASSERT_TRUE(server_.Create(create, nullptr).ok());
  }
  v1::ListSessionsResponse List(std::int32_t page_size, const std::string& token,
                                grpc::Status* status) {
    grpc::ClientContext context;
    v1::ListSessionsRequest request;
    request.set_page_size(page_size);
    request.set_page_token(token);
    v1::ListSessionsResponse response;
    *status = server_.sessions->ListSessions(&context, request, &response);
    return response;
  }

  std::shared_ptr<FakeEngineScript> script_ = std::make_shared<FakeEngineScript>();
  test::InProcessServer server_{FakeFactory(script_)};
};

TEST_F(ServiceTest, ListsSessionsInPages) {
  for (const char* id : {"b", "a", "c"}) Create(id);
  grpc::Status status;
  const v1::ListSessionsResponse first = List(2, "", &status);
  ASSERT_TRUE(status.ok());
  ASSERT_EQ(first.sessions_size(), 2);
  EXPECT_EQ(first.sessions(0).session_id(), "b");
  const v1::ListSessionsResponse second = List(2, first.next_page_token(), &status);
  ASSERT_EQ(second.sessions_size(), 1);
  EXPECT_EQ(second.sessions(0).session_id(), "c");
  EXPECT_EQ(second.next_page_token(), "");
}

TEST_F(ServiceTest, RefusesPagesThatAreOutOfRange) {
  grpc::Status status;
  List(kPageSizeMax, "", &status);
  EXPECT_TRUE(status.ok());
  List(kPageSizeMax + 1, "", &status);
  EXPECT_EQ(test::ReasonOf(status), "OUT_OF_RANGE");
  List(-1, "", &status);
  EXPECT_EQ(test::ReasonOf(status), "OUT_OF_RANGE");
  for (const char* token : {"x", "1x", "-1", "0", "99999999999999999999"}) {
    List(1, token, &status);
    EXPECT_EQ(test::ReasonOf(status), "OUT_OF_RANGE") << token;
  }
}

TEST_F(ServiceTest, DescribesAndDeletesASession) {
  Create("a");
  v1::GetSessionRequest get;
  get.set_session_id("a");
  v1::GetSessionResponse got;
  {
    grpc::ClientContext context;
    ASSERT_TRUE(server_.sessions->GetSession(&context, get, &got).ok());
  }
  EXPECT_EQ(got.session().revision(), 0);
  EXPECT_GT(got.session().create_time().seconds(), 0);
  v1::DeleteSessionRequest remove;
  remove.set_session_id("a");
  v1::DeleteSessionResponse removed;
  {
    grpc::ClientContext context;
    ASSERT_TRUE(server_.sessions->DeleteSession(&context, remove, &removed).ok());
  }
  {
    grpc::ClientContext context;
    EXPECT_EQ(test::ReasonOf(server_.sessions->DeleteSession(&context, remove, &removed)),
              "SESSION_NOT_FOUND");
  }
  grpc::ClientContext context;
  EXPECT_EQ(test::ReasonOf(server_.sessions->GetSession(&context, get, &got)), "SESSION_NOT_FOUND");
}

TEST_F(ServiceTest, MeasuresTheCommittedRevision) {
  Create("a");
  v1::GetQualityRequest request;
  request.set_session_id("a");
  v1::GetQualityResponse response;
  {
    grpc::ClientContext context;
    EXPECT_EQ(test::ReasonOf(server_.sessions->GetQuality(&context, request, &response)),
              "REVISION_NOT_FOUND");
  }
  test::EditClient edit(server_, "a");
  edit.Advance(1);
  edit.Until(1);
  {
    grpc::ClientContext context;
    ASSERT_TRUE(server_.sessions->GetQuality(&context, request, &response).ok());
  }
  EXPECT_EQ(response.quality().revision(), 1);
  EXPECT_EQ(response.quality().counts().vertex_count(), 3);
  request.set_basis(v1::METRIC_BASIS_RAW);
  grpc::ClientContext context;
  ASSERT_TRUE(server_.sessions->GetQuality(&context, request, &response).ok());
  EXPECT_EQ(response.quality().basis(), v1::METRIC_BASIS_RAW);
}

// Goal: who loses interest in a measurement stops it, and the session goes on. Method: one that has
// no end, so that the advance after it is answered only if it was given up.
TEST_F(ServiceTest, GivesAMeasurementUpWhenItsClientDoes) {
  Create("a");
  test::EditClient edit(server_, "a");
  edit.Advance(1);
  edit.Until(1);
  script_->measurement_part_count = std::numeric_limits<int>::max();
  std::promise<void> began;
  script_->during_measurement = [&began, tells = true]() mutable {
    if (std::exchange(tells, false)) began.set_value();
  };
  grpc::ClientContext context;
  std::thread reader([&] {
    v1::GetQualityRequest request;
    request.set_session_id("a");
    v1::GetQualityResponse response;
    const grpc::Status status = server_.sessions->GetQuality(&context, request, &response);
    EXPECT_EQ(status.error_code(), grpc::StatusCode::CANCELLED);
  });
  began.get_future().wait();
  context.TryCancel();
  reader.join();
  edit.Advance(2);
  edit.Until(2);
}

TEST_F(ServiceTest, TellsItsVersionCapabilitiesAndLimits) {
  grpc::ClientContext context;
  v1::GetServerInfoResponse response;
  ASSERT_TRUE(server_.info->GetServerInfo(&context, {}, &response).ok());
  EXPECT_FALSE(response.version().empty());
  EXPECT_THAT(response.capabilities(), Contains("metric.expression"));
  EXPECT_THAT(response.capabilities(), Contains("jobs"));
  EXPECT_EQ(response.limits().at("jobs"), static_cast<std::int64_t>(kJobsMaxDefault));
  EXPECT_EQ(response.limits().at("job_keep_ms"), kJobKeepMsMax);
  EXPECT_EQ(response.limits().at("message_bytes"), kMessageBytesMax);
  EXPECT_EQ(response.limits().at("sessions"), static_cast<std::int64_t>(kSessionsMaxDefault));
}

}  // namespace
}  // namespace pliant::server
