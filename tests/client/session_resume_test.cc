// What an editor does when its stream is lost, or cannot be had at once.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <future>
#include <string>
#include <thread>
#include <vector>

#include "client/cpp/client.h"
#include "client/cpp/session.h"
#include "tests/client/fake_server.h"
#include "tests/client/session_support.h"

namespace pliant::client {
namespace {

using testing::HasSubstr;

TEST(Session, ALostStreamIsOpenedAgainAndTheCommandRepeated) {
  const History history(3);
  FakeServer server;
  std::vector<std::int64_t> mirror_revisions;
  std::vector<std::int64_t> advance_ids;
  server.on_edit = [&](EditScript& script, int stream) {
    if (stream == 1) {
      script.Open(Revision{0});
      const v1::EditRequest advance = script.Next();
      script.SendDiff(history.Diff(1));
      script.Advanced(advance, history.Diff(1));
      advance_ids.push_back(script.Next().update_id());
      return grpc::Status(grpc::StatusCode::UNAVAILABLE, "the cable was pulled");
    }
    mirror_revisions.push_back(script.Open(Revision{3}).open().mirror_revision());
    script.SendDiff(history.Diff(2));
    script.SendDiff(history.Diff(3));
    const v1::EditRequest repeated = script.Next();
    advance_ids.push_back(repeated.update_id());
    script.Advanced(repeated, history.Diff(3));
    script.Next();
    return grpc::Status::OK;
  };
  const auto session = Open(server);
  ASSERT_TRUE(session->Advance().ok());
  const auto resumed = session->Advance();
  ASSERT_TRUE(resumed.ok()) << resumed.error().message;
  EXPECT_EQ(resumed->revision, Revision{3});
  EXPECT_EQ(mirror_revisions, (std::vector<std::int64_t>{1}));
  EXPECT_EQ(advance_ids, (std::vector<std::int64_t>{2, 2}));
  ExpectSame(session->replica(), history.models[3]);
}

grpc::Status PulledCable() { return {grpc::StatusCode::UNAVAILABLE, "the cable was pulled"}; }

TEST(Session, AStreamThatIsLostAgainAndAgainIsMadeAgain) {
  const History history(1);
  FakeServer server;
  std::vector<std::int64_t> advance_ids;
  server.on_edit = [&](EditScript& script, int stream) {
    script.Open(Revision{0});
    if (stream == 3) return PulledCable();
    const v1::EditRequest request = script.Next();
    advance_ids.push_back(request.update_id());
    if (stream <= 4) return PulledCable();
    script.SendDiff(history.Diff(1));
    script.Advanced(request, history.Diff(1));
    script.Next();
    return grpc::Status::OK;
  };
  const auto report = Open(server)->Advance();
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report->revision, Revision{1});
  EXPECT_EQ(advance_ids, (std::vector<std::int64_t>{1, 1, 1, 1}));
}

TEST(Session, AServerThatStaysAwayIsAnErrorUntilReopen) {
  const History history(1);
  FakeServer server;
  std::atomic<bool> is_away = true;
  std::atomic<int> tries = 0;
  server.on_edit = [&](EditScript& script, int) {
    ++tries;
    script.Open(Revision{0});
    const v1::EditRequest request = script.Next();
    if (is_away) return PulledCable();
    script.SendDiff(history.Diff(1));
    script.Advanced(request, history.Diff(1));
    script.Next();
    return grpc::Status::OK;
  };
  const auto session = Open(server, std::chrono::milliseconds(300));
  const auto lost = session->Advance();
  ASSERT_FALSE(lost.ok());
  EXPECT_EQ(lost.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(lost.error().message, HasSubstr(server.address()));
  EXPECT_GT(tries, 2);
  EXPECT_LT(tries, 12) << "pauses grow";
  EXPECT_THAT(session->Advance().error().message, HasSubstr("Reopen"));
  is_away = false;
  ASSERT_TRUE(session->Reopen().ok());
  EXPECT_TRUE(session->Advance().ok());
}

TEST(Session, CancelEndsTheWaitForALostServer) {
  FakeServer server;
  std::promise<void> is_lost;
  server.on_edit = [&](EditScript& script, int stream) {
    if (stream == 4) is_lost.set_value();
    if (stream > 1) return PulledCable();
    script.Open(Revision{0});
    script.Next();
    return PulledCable();
  };
  const auto session = Open(server);
  const auto start = std::chrono::steady_clock::now();
  std::thread other([&] {
    is_lost.get_future().wait();
    session->Cancel();
  });
  EXPECT_EQ(session->Advance().error().code, ErrorCode::kUnavailable);
  other.join();
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

// The answer to an advance is lost that has taken the stage: nothing is lost but the answer.
TEST(Session, AStageThatAnAdvanceHasTakenIsNotLost) {
  const History history(1);
  FakeServer server;
  server.on_edit = [&](EditScript& script, int stream) {
    if (stream == 1) {
      script.Open(Revision{0});
      script.Accept(script.Next());
      script.Next();
      return PulledCable();
    }
    script.Open(Revision{1}, /*last_update_id=*/2);
    script.SendDiff(history.Diff(1));
    script.Advanced(script.Next(), history.Diff(1));
    script.Next();
    return grpc::Status::OK;
  };
  const auto session = Open(server);
  ASSERT_TRUE(session->UpdateMetric({.source = SizeMetric{"0.1"}}).ok());
  const auto report = session->Advance();
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report->revision, Revision{1});
  EXPECT_EQ(session->replica().revision(), Revision{1});
}

// A server that began anew does not have what was staged: committing the rest would be half a step.
TEST(Session, AStageThatTheServerHasLostIsNotCommittedInPart) {
  FakeServer server;
  int commands_after = 0;
  server.on_edit = [&](EditScript& script, int stream) {
    script.Open(Revision{0});
    if (stream == 1) {
      script.Accept(script.Next());
      script.Next();
      return grpc::Status(grpc::StatusCode::UNAVAILABLE, "the server was killed");
    }
    if (script.Next().update_id() != 0) ++commands_after;
    return grpc::Status::OK;
  };
  {
    const auto session = Open(server);
    ASSERT_TRUE(session->UpdateMetric({.source = SizeMetric{"0.1"}}).ok());
    const auto lost = session->Advance();
    ASSERT_FALSE(lost.ok());
    EXPECT_EQ(lost.error().code, ErrorCode::kUpdateRejected);
  }
  server.Stop();
  EXPECT_EQ(commands_after, 0);
}

TEST(Session, ASessionThatIsBusyForAMomentIsTriedAgain) {
  FakeServer server;
  int tries = 0;
  server.on_edit = [&](EditScript& script, int stream) {
    tries = stream;
    if (stream <= 2) {
      v1::ErrorDetail detail;
      detail.set_reason("SESSION_BUSY");
      v1::ErrorStatus details;
      details.add_details()->PackFrom(detail);
      return grpc::Status(grpc::StatusCode::ABORTED, "busy", details.SerializeAsString());
    }
    script.Open(Revision{0});
    script.Next();
    return grpc::Status::OK;
  };
  Open(server);
  EXPECT_EQ(tries, 3);
}

TEST(Session, AnAnnouncedEndOfTheStreamSaysWhy) {
  FakeServer server;
  server.on_edit = [&](EditScript& script, int) {
    script.Open(Revision{0});
    script.Next();
    v1::EditResponse response;
    response.mutable_closing()->mutable_error()->set_reason("UNAVAILABLE");
    response.mutable_closing()->mutable_error()->set_message("the server shuts down");
    script.Send(response);
    return grpc::Status::OK;
  };
  const auto session = Open(server, /*reconnect_max=*/{});
  const auto report = session->Advance();
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(report.error().message, HasSubstr("shuts down"));
}

}  // namespace
}  // namespace pliant::client
