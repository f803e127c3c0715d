#include "server/session_stream.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>

#include "server/limits.h"
#include "tests/support/fake_server_parts.h"
#include "tests/support/in_process_server.h"

namespace pliant::server {
namespace {

class SessionStreamTest : public testing::Test {
 protected:
  SessionStreamTest() { EXPECT_TRUE(server_.Create(test::UnitSquare(), &id_).ok()); }

  std::shared_ptr<FakeEngineScript> script_ = std::make_shared<FakeEngineScript>();
  test::InProcessServer server_{FakeFactory(script_)};
  std::string id_;
};

TEST_F(SessionStreamTest, AnswersEverythingAfterAHalfClose) {
  test::EditClient edit(server_, id_);
  edit.Advance(1);
  edit.Size(2, "0.1");
  edit.Advance(3);
  EXPECT_TRUE(edit.Finish().ok());
  test::EditClient next(server_, id_, /*mirror=*/2);
  EXPECT_EQ(next.Next().opened().last_update_id(), 3);
  EXPECT_TRUE(next.Finish().ok());
}

TEST_F(SessionStreamTest, EndsAStreamThatDoesNotBeginWithOpen) {
  test::EditClient edit(server_);
  edit.Advance(1);
  const grpc::Status status = edit.End();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::FAILED_PRECONDITION);
  EXPECT_EQ(test::ReasonOf(status), "PROTOCOL_ORDER");
}

TEST_F(SessionStreamTest, EndsAStreamThatOpensTwice) {
  test::EditClient edit(server_, id_);
  v1::EditRequest request;
  request.mutable_open()->set_session_id(id_);
  edit.Send(request);
  EXPECT_EQ(test::ReasonOf(edit.End()), "PROTOCOL_ORDER");
}

TEST_F(SessionStreamTest, EndsAStreamWithAnUpdateWithoutANumberOrWithoutACommand) {
  {
    test::EditClient edit(server_, id_);
    edit.Advance(0);
    EXPECT_EQ(test::ReasonOf(edit.End()), "PROTOCOL_ORDER");
  }
  test::EditClient edit(server_, id_);
  edit.Send(v1::EditRequest());
  EXPECT_EQ(test::ReasonOf(edit.End()), "PROTOCOL_ORDER");
}

TEST_F(SessionStreamTest, RefusesASessionThatIsNotThere) {
  test::EditClient edit(server_, "nobody");
  const grpc::Status status = edit.End();
  EXPECT_EQ(status.error_code(), grpc::StatusCode::NOT_FOUND);
  EXPECT_EQ(test::ReasonOf(status), "SESSION_NOT_FOUND");
}

TEST_F(SessionStreamTest, RefusesASecondEditorAndFreesTheSessionWithTheFirst) {
  test::EditClient first(server_, id_);
  EXPECT_TRUE(first.Next().has_opened());
  {
    test::EditClient second(server_, id_);
    const grpc::Status status = second.End();
    EXPECT_EQ(status.error_code(), grpc::StatusCode::ABORTED);
    EXPECT_EQ(test::ReasonOf(status), "SESSION_BUSY");
  }
  EXPECT_TRUE(first.Finish().ok());
  // The client has seen the end of the first stream, so the session must be free now.
  test::EditClient third(server_, id_);
  EXPECT_TRUE(third.Next().has_opened());
  EXPECT_TRUE(third.Finish().ok());
}

TEST_F(SessionStreamTest, FreesTheSessionOfAClientThatVanishes) {
  auto first = std::make_unique<test::EditClient>(server_, id_);
  EXPECT_TRUE(first->Next().has_opened());
  first->Cancel();
  first->End();
  for (;;) {
    // The server hears of it a moment later.
    test::EditClient second(server_, id_);
    if (second.Next().has_opened()) break;
    EXPECT_EQ(second.End().error_code(), grpc::StatusCode::ABORTED);
    std::this_thread::yield();
  }
}

TEST_F(SessionStreamTest, RefusesAnUpdateWhoseBlobIsMissingAndGoesOn) {
  test::EditClient edit(server_, id_);
  edit.Advance(1);
  v1::EditRequest request;
  request.set_update_id(2);
  v1::VertexMetric& vertices = *request.mutable_metric()->add_sources()->mutable_vertices();
  vertices.set_revision(1);
  vertices.mutable_tensors()->set_blob_id(9);
  edit.Send(request);
  const v1::EditResponse rejected = edit.Until(2).back();
  ASSERT_TRUE(rejected.has_rejected());
  EXPECT_EQ(rejected.rejected().error().reason(), "PROTOCOL_ORDER");
  EXPECT_EQ(rejected.rejected().error().field(), "metric.sources[0].vertices.tensors");
  EXPECT_TRUE(edit.Finish().ok());
}

// Goal: promise Bounded, at the number of unanswered commands: more than fit are still all
// answered, because the stream is simply not read meanwhile.
TEST_F(SessionStreamTest, AnswersMoreCommandsThanItsInboxHolds) {
  test::EditClient edit(server_, id_);
  const std::int64_t count = 5 * static_cast<std::int64_t>(kInboxCommandsMax);
  std::thread writer([&] {
    for (std::int64_t i = 1; i <= count; ++i) edit.Advance(i);
  });
  const std::vector<v1::EditResponse> last = edit.Until(count);
  writer.join();
  EXPECT_EQ(last.back().revision(), count);
  EXPECT_EQ(last.size(), static_cast<std::size_t>(2 * count + 1)) << "opened, diff and result each";
  EXPECT_TRUE(edit.Finish().ok());
}

TEST_F(SessionStreamTest, EndsWithTheSession) {
  test::EditClient edit(server_, id_);
  EXPECT_TRUE(edit.Next().has_opened());
  grpc::ClientContext context;
  v1::DeleteSessionRequest request;
  request.set_session_id(id_);
  v1::DeleteSessionResponse response;
  ASSERT_TRUE(server_.sessions->DeleteSession(&context, request, &response).ok());
  const v1::EditResponse closing = edit.Next();
  EXPECT_EQ(closing.closing().error().reason(), "SESSION_NOT_FOUND");
  EXPECT_EQ(test::ReasonOf(edit.End()), "SESSION_NOT_FOUND");
}

}  // namespace
}  // namespace pliant::server
