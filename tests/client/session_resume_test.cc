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
#include "tests/client/silent_proxy.h"

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

// What gRPC itself answers to calls that reach a server after it has begun to shut down.
grpc::Status Closing() { return {grpc::StatusCode::CANCELLED, "CANCELLED"}; }

TEST(Session, AStreamThatIsLostAgainAndAgainIsMadeAgain) {
  const History history(1);
  FakeServer server;
  std::vector<std::int64_t> advance_ids;
  server.on_edit = [&](EditScript& script, int stream) {
    if (stream == 2) return Closing();
    script.Open(Revision{0});
    if (stream == 4) return PulledCable();
    const v1::EditRequest request = script.Next();
    advance_ids.push_back(request.update_id());
    if (stream <= 3) return Closing();
    if (stream <= 5) return PulledCable();
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

// Another editor has come in between, with numbers after ours: what was staged may have become a
// part of its revision, or nothing.
TEST(Session, AStageThatAnotherEditorHasHadIsSentAgain) {
  const History history(1);
  FakeServer server;
  std::vector<std::string> commands;
  server.on_edit = [&](EditScript& script, int stream) {
    script.Open(Revision{0}, /*last_update_id=*/stream == 1 ? 0 : 5, /*staged_count=*/stream - 1);
    script.Accept(script.Next());
    const v1::EditRequest second = script.Next();
    if (stream == 1) return PulledCable();
    commands.push_back(std::to_string(second.update_id()) + (second.has_advance() ? "" : "!"));
    script.SendDiff(history.Diff(1));
    script.Advanced(second, history.Diff(1));
    script.Next();
    return grpc::Status::OK;
  };
  const auto session = Open(server);
  ASSERT_TRUE(session->UpdateMetric({.source = SizeMetric{"0.1"}}).ok());
  const Status lost = session->UpdateMetric({.source = SizeMetric{"0.2"}});
  ASSERT_FALSE(lost.ok());
  EXPECT_EQ(lost.error().code, ErrorCode::kUpdateRejected);
  EXPECT_THAT(lost.error().message, HasSubstr("another editor"));
  ASSERT_TRUE(session->Advance().ok());
  EXPECT_EQ(commands, (std::vector<std::string>{"7"})) << "a discard goes first";
}

// What an advance that was due has left to be staged is not forgotten: lost with the connection, it
// is sent again, and no commit goes without it.
TEST(Session, AStageThatIsUnderWayIsSentAgainWhenItIsLost) {
  const History history(1);
  FakeServer server;
  server.on_edit = [&](EditScript& script, int stream) {
    const bool is_first = stream == 1;
    script.Open(Revision{0}, /*last_update_id=*/is_first ? 0 : 2, /*staged_count=*/0);
    script.Accept(script.Next());
    if (is_first) {
      script.Advanced(script.Next(), {}, v1::STOP_REASON_STAGING);
      script.Next();
    }
    return PulledCable();
  };
  const auto session = Open(server);
  session->SetAnswers(Answers::kWithAdvance);
  ASSERT_TRUE(session->UpdateMetric({.source = SizeMetric{"0.1"}}).ok());
  const auto due = session->Advance({.time_max = std::chrono::milliseconds(1)});
  ASSERT_TRUE(due.ok()) << due.error().message;
  EXPECT_EQ(due->stop, AdvanceStop::kStaging);
  EXPECT_EQ(due->revision, due->base_revision);
  const auto lost = session->Advance();
  ASSERT_FALSE(lost.ok());
  EXPECT_EQ(lost.error().code, ErrorCode::kUpdateRejected);
}

// A server that shuts down ends an advance; who asked for no limit gets all of it from the next.
TEST(Session, AnAdvanceGoesOnWhereTheNextServerIsThere) {
  const History history(2);
  FakeServer server;
  std::atomic<int> streams = 0;
  server.on_edit = [&](EditScript& script, int stream) {
    streams = stream;
    script.Open(Revision{stream - 1}, /*last_update_id=*/stream - 1);
    const v1::EditRequest advance = script.Next();
    const MeshDiff diff = history.Diff(static_cast<std::size_t>(stream));
    script.SendDiff(diff);
    const bool is_last = stream == 2 || advance.advance().has_budget_visits();
    script.Advanced(advance, diff,
                    stream == 1 ? v1::STOP_REASON_SERVER_CLOSING : v1::STOP_REASON_CONVERGED);
    if (is_last) script.Next();
    return PulledCable();
  };
  int change_count = 0;
  const auto report = Open(server)->Advance({}, {}, [&](const MeshDiff&) { ++change_count; });
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report->base_revision, Revision{0});
  EXPECT_EQ(report->revision, Revision{2});
  EXPECT_EQ(report->stop, AdvanceStop::kConverged);
  EXPECT_EQ(report->visits, 20);
  EXPECT_EQ(change_count, 2);
  EXPECT_EQ(streams, 2);
}

TEST(Session, AnAdvanceWithALimitEndsWithTheServer) {
  const History history(1);
  FakeServer server;
  server.on_edit = [&](EditScript& script, int) {
    script.Open(Revision{0});
    const v1::EditRequest advance = script.Next();
    script.SendDiff(history.Diff(1));
    script.Advanced(advance, history.Diff(1), v1::STOP_REASON_SERVER_CLOSING);
    return PulledCable();
  };
  const auto report = Open(server)->Advance({.visits_max = 100});
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report->stop, AdvanceStop::kServerClosing);
}

// What was committed is told also where no server comes back.
TEST(Session, AnAdvanceThatCannotGoOnTellsWhatItDid) {
  const History history(1);
  FakeServer server;
  server.on_edit = [&](EditScript& script, int stream) {
    if (stream > 1) return PulledCable();
    script.Open(Revision{0});
    const v1::EditRequest advance = script.Next();
    script.SendDiff(history.Diff(1));
    script.Advanced(advance, history.Diff(1), v1::STOP_REASON_SERVER_CLOSING);
    return PulledCable();
  };
  const auto report = Open(server, std::chrono::milliseconds(200))->Advance();
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report->stop, AdvanceStop::kServerClosing);
  EXPECT_EQ(report->revision, Revision{1});
}

// Goal: a connection that dies without a word is noticed while an advance waits, and made again.
TEST(Session, AConnectionThatFallsSilentIsMadeAgain) {
  const History history(1);
  FakeServer server;
  SilentProxy proxy(server.address());
  server.on_edit = [&](EditScript& script, int stream) {
    script.Open(Revision{0});
    const v1::EditRequest advance = script.Next();
    if (stream == 1) {
      proxy.FallSilent();
      script.Next();  // Until the server is stopped: nobody ends this stream.
      return grpc::Status::OK;
    }
    script.SendDiff(history.Diff(1));
    script.Advanced(advance, history.Diff(1));
    script.Next();
    return grpc::Status::OK;
  };
  const auto session = Open(proxy.address(), {.keepalive_interval = std::chrono::milliseconds(300),
                                              .keepalive_timeout = std::chrono::milliseconds(300)});
  const auto report = session->Advance();
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report->revision, Revision{1});
  server.Stop();
}

}  // namespace
}  // namespace pliant::client
