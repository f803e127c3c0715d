#include "server/creation.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "server/limits.h"
#include "tests/support/fake_server_parts.h"
#include "tests/support/in_process_server.h"

namespace pliant::server {
namespace {

EngineFactory Fake() { return FakeFactory(std::make_shared<FakeEngineScript>()); }

// Sends these messages as one CreateSession.
grpc::Status Upload(test::InProcessServer& server,
                    const std::vector<v1::CreateSessionRequest>& requests) {
  grpc::ClientContext context;
  v1::CreateSessionResponse response;
  const auto writer = server.sessions->CreateSession(&context, &response);
  for (const v1::CreateSessionRequest& request : requests) writer->Write(request);
  writer->WritesDone();
  return writer->Finish();
}

v1::CreateSessionRequest CreateOf(const v1::CreateSession& create) {
  v1::CreateSessionRequest request;
  *request.mutable_create() = create;
  return request;
}

TEST(Creation, MakesAnIdOrTakesTheWishedOne) {
  test::InProcessServer server(Fake());
  std::string id;
  ASSERT_TRUE(server.Create(test::UnitSquare(), &id).ok());
  EXPECT_FALSE(id.empty());
  v1::CreateSession create = test::UnitSquare();
  create.set_session_id("mine");
  ASSERT_TRUE(server.Create(create, &id).ok());
  EXPECT_EQ(id, "mine");
  const grpc::Status again = server.Create(create, &id);
  EXPECT_EQ(again.error_code(), grpc::StatusCode::ALREADY_EXISTS);
  EXPECT_EQ(test::ReasonOf(again), "SESSION_EXISTS");
}

TEST(Creation, RefusesMessagesInTheWrongOrder) {
  test::InProcessServer server(Fake());
  EXPECT_EQ(test::ReasonOf(Upload(server, {})), "PROTOCOL_ORDER");
  EXPECT_EQ(test::ReasonOf(Upload(server, {v1::CreateSessionRequest()})), "PROTOCOL_ORDER");
  const v1::CreateSessionRequest create = CreateOf(test::UnitSquare());
  EXPECT_EQ(test::ReasonOf(Upload(server, {create, create})), "PROTOCOL_ORDER");
  v1::CreateSession blob = test::UnitSquare();
  blob.mutable_domain()->mutable_points()->set_blob_id(1);
  EXPECT_EQ(test::ReasonOf(Upload(server, {CreateOf(blob)})), "PROTOCOL_ORDER");
}

TEST(Creation, FreesTheIdOfASessionThatTheEngineRefuses) {
  const auto script = std::make_shared<FakeEngineScript>();
  script->create_error = Error{ErrorCode::kCrossingSegments, "cross", "domain.segments", 1, 3};
  test::InProcessServer server(FakeFactory(script));
  v1::CreateSession create = test::UnitSquare();
  create.set_session_id("mine");
  EXPECT_EQ(test::ReasonOf(server.Create(create, nullptr)), "CROSSING_SEGMENTS");
  script->create_error.reset();
  EXPECT_TRUE(server.Create(create, nullptr).ok());
}

TEST(Creation, RefusesAMessageBeyondTheLimit) {
  test::InProcessServer server(Fake());
  v1::CreateSession create = test::UnitSquare();
  create.mutable_domain()->mutable_holes()->set_data(std::string(kMessageBytesMax, 'x'));
  EXPECT_EQ(Upload(server, {CreateOf(create)}).error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
}

TEST(Creation, HoldsAsManySessionsAsConfigured) {
  test::InProcessServer server(Fake(), {.sessions_max = 2});
  ASSERT_TRUE(server.Create(test::UnitSquare(), nullptr).ok());
  ASSERT_TRUE(server.Create(test::UnitSquare(), nullptr).ok());
  EXPECT_EQ(test::ReasonOf(server.Create(test::UnitSquare(), nullptr)), "RESOURCE_EXHAUSTED");
}

}  // namespace
}  // namespace pliant::server
