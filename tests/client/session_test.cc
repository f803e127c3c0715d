#include "client/cpp/session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include "client/cpp/client.h"
#include "tests/client/fake_server.h"
#include "tests/client/model_mesh.h"
#include "tests/client/session_support.h"

namespace pliant::client {
namespace {

using testing::HasSubstr;

TEST(Session, AdvancesAndFollowsTheMesh) {
  const History history(3);
  FakeServer server;
  std::vector<v1::EditRequest> seen;
  server.on_edit = [&](EditScript& script, int) {
    seen.push_back(script.Open(Revision{0}, /*last_update_id=*/40));
    for (std::size_t revision = 1; revision <= 3; ++revision) {
      seen.push_back(script.Next());
      script.SendDiff(history.Diff(revision));
      script.Advanced(seen.back(), history.Diff(revision));
    }
    script.Next();
    return grpc::Status::OK;
  };
  const auto session = Open(server);
  AdvanceOptions options;
  options.visits_max = 1000;
  options.time_max = std::chrono::milliseconds(50);
  for (std::size_t revision = 1; revision <= 3; ++revision) {
    const Result<AdvanceReport> report =
        session->Advance(revision == 1 ? options : AdvanceOptions());
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_EQ(report->stop, AdvanceStop::kConverged);
    EXPECT_EQ(report->revision, Revision{static_cast<std::int64_t>(revision)});
    ASSERT_NO_FATAL_FAILURE(ExpectSame(session->replica(), history.models[revision]));
  }
  EXPECT_EQ(seen[0].open().session_id(), "s1");
  EXPECT_EQ(seen[1].update_id(), 41) << "ids go on where the session's last editor stopped";
  EXPECT_EQ(seen[1].advance().budget_visits(), 1000);
  EXPECT_EQ(seen[1].advance().budget_ms(), 50);
  EXPECT_FALSE(seen[1].advance().has_progress_interval_ms());
  EXPECT_EQ(seen[2].update_id(), 42);
  EXPECT_FALSE(seen[2].advance().has_budget_visits());
}

TEST(Session, OpensWithASnapshotThatComesInChunks) {
  ModelMesh large;
  large.revision = Revision{17};
  for (std::int32_t i = 0; i < 200'000; ++i) large.vertices[VertexId(i)] = {1.0 * i, -1.0 * i};
  FakeServer server;
  server.on_edit = [&](EditScript& script, int) {
    script.Open(Revision{17});
    script.SendSnapshot(DiffOf({}, large));
    script.Next();
    return grpc::Status::OK;
  };
  ExpectSame(Open(server)->replica(), large);
}

TEST(Session, ARefusedUpdateIsItsErrorAndTheStreamGoesOn) {
  FakeServer server;
  server.on_edit = [&](EditScript& script, int) {
    script.Open(Revision{0});
    v1::ErrorDetail error;
    error.set_reason("NOT_FINITE");
    error.set_field("metric.tensors");
    error.set_index(17);
    error.set_other_index(-1);
    error.set_message("tensor 17 has a NaN");
    script.Reject(script.Next(), error);
    const v1::EditRequest metric = script.Next();
    EXPECT_EQ(metric.metric().sources(0).size().size(), "0.1 + x");
    script.Accept(metric);
    const v1::EditRequest discard = script.Next();
    EXPECT_TRUE(discard.has_discard());
    script.Accept(discard);
    script.Next();
    return grpc::Status::OK;
  };
  const auto session = Open(server);
  const std::vector<Metric> tensors(20);
  const Status refused = session->UpdateTensors({}, tensors);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kNotFinite);
  EXPECT_EQ(refused.error().field, "metric.tensors");
  EXPECT_EQ(refused.error().index, 17);
  EXPECT_EQ(refused.error().message, "tensor 17 has a NaN");
  EXPECT_TRUE(
      session->UpdateMetric({.source = SizeMetric{"0.1 + x"}, .time = 0, .bounds = {}}).ok());
  EXPECT_TRUE(session->Discard().ok());
}

TEST(Session, ReportsProgressAndCancelsFromTheCallback) {
  const History history(1);
  FakeServer server;
  std::int64_t cancelled = 0;
  server.on_edit = [&](EditScript& script, int) {
    script.Open(Revision{0});
    const v1::EditRequest advance = script.Next();
    EXPECT_EQ(advance.advance().progress_interval_ms(), 20);
    for (int i = 1; i <= 3; ++i) {
      v1::EditResponse progress;
      progress.mutable_progress()->set_visit_count(100 * i);
      script.Send(progress, advance);
    }
    cancelled = script.Next().cancel().advance_update_id() - advance.update_id();
    script.SendDiff(history.Diff(1));
    script.Advanced(advance, history.Diff(1));
    script.Next();
    return grpc::Status::OK;
  };
  const auto session = Open(server);
  session->Cancel();  // Nothing runs: nothing may be sent.
  std::vector<std::int64_t> visits;
  AdvanceOptions options;
  options.progress_interval = std::chrono::milliseconds(20);
  const Result<AdvanceReport> report = session->Advance(options, [&](const AdvanceProgress& p) {
    visits.push_back(p.visits);
    if (visits.size() == 3) session->Cancel();
  });
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(visits, (std::vector<std::int64_t>{100, 200, 300}));
  EXPECT_EQ(cancelled, 0) << "the cancel names the advance";
}

TEST(Session, AWrongHashIsAMismatchAndResyncGetsASnapshot) {
  const History history(2);
  FakeServer server;
  std::vector<std::int64_t> mirror_revisions;
  server.on_edit = [&](EditScript& script, int stream) {
    const Revision revision{stream == 1 ? 0 : 2};
    mirror_revisions.push_back(script.Open(revision).open().mirror_revision());
    if (stream == 2) {
      script.SendSnapshot(history.Snapshot(2));
    } else {
      const v1::EditRequest first = script.Next();
      script.SendDiff(history.Diff(1));
      script.Advanced(first, history.Diff(1));
      const v1::EditRequest second = script.Next();
      MeshDiff wrong = history.Diff(2);
      wrong.summary.state_hash ^= 1;
      script.SendDiff(wrong);
      script.Advanced(second, wrong);
    }
    script.Next();
    return grpc::Status::OK;
  };
  const auto session = Open(server);
  ASSERT_TRUE(session->Advance().ok());
  const auto mismatch = session->Advance();
  ASSERT_FALSE(mismatch.ok());
  EXPECT_EQ(mismatch.error().code, ErrorCode::kReplicaMismatch);
  ExpectSame(session->replica(), history.models[1]);
  EXPECT_EQ(session->Discard().error().code, ErrorCode::kUnavailable) << "until it is opened again";
  EXPECT_THAT(session->UpdateMetric({}).error().message, HasSubstr("Reopen"));

  ASSERT_TRUE(session->Resync().ok());
  ExpectSame(session->replica(), history.models[2]);
  EXPECT_EQ(mirror_revisions, (std::vector<std::int64_t>{0, 0}));
}

// Goal: a lost stream is opened again at the replica's revision, and the command that had no answer
//       is repeated under its number, so that it is not applied twice.
/// A step of two updates that is sent ahead: one whose tensors are too large for its message, and
/// one of a formula.
void SendStep(Session& session) {
  const std::vector<Metric> tensors(5'000, Metric::Isotropic(0.5));
  std::vector<VertexId> vertices;
  for (std::int32_t i = 0; i < 5'000; ++i) vertices.emplace_back(i);
  ASSERT_TRUE(session.UpdateTensors(vertices, tensors).ok());
  ASSERT_TRUE(session.UpdateMetric({.source = SizeMetric{"0.1"}}).ok());
}

/// What SendStep and an advance lead to.
std::vector<v1::EditRequest> ReceiveStep(EditScript& script) {
  std::vector<v1::EditRequest> step;
  do {
    step.push_back(script.Next());
  } while (step.back().command_case() != v1::EditRequest::COMMAND_NOT_SET &&
           !step.back().has_advance());
  return step;
}

std::string TextOf(const std::vector<v1::EditRequest>& requests) {
  std::string text;
  for (const v1::EditRequest& request : requests) text += request.SerializeAsString();
  return text;
}

// Goal: with kWithAdvance a step is on its way as a whole before the server says anything; the
//       next step may then wait for every answer again.
TEST(Session, SendsAStepAheadOfItsAnswers) {
  const History history(1);
  FakeServer server;
  server.on_edit = [&](EditScript& script, int) {
    script.Open(Revision{0});
    const std::vector<v1::EditRequest> step = ReceiveStep(script);
    EXPECT_EQ(step.size(), 4U) << "chunk, tensors, formula, advance";
    EXPECT_TRUE(step[0].has_chunk());
    script.Accept(step[1]);
    script.Accept(step[2]);
    script.SendDiff(history.Diff(1));
    script.Advanced(step[3], history.Diff(1));
    script.Accept(script.Next());
    script.Next();
    return grpc::Status::OK;
  };
  const auto session = Open(server);
  session->SetAnswers(Answers::kWithAdvance);
  ASSERT_NO_FATAL_FAILURE(SendStep(*session));
  const Result<AdvanceReport> report = session->Advance();
  ASSERT_TRUE(report.ok()) << report.error().message;
  ExpectSame(session->replica(), history.models[1]);
  session->SetAnswers(Answers::kAtOnce);
  EXPECT_TRUE(session->UpdateMetric({.source = SizeMetric{"0.2"}}).ok());
}

// Goal: a commit under a number that another editor has used is not taken for that of a step of
//       which an update was refused for its number.
TEST(Session, TheCommitOfAnotherIsNotThatOfARefusedStep) {
  const History history(1);
  FakeServer server;
  server.on_edit = [&](EditScript& script, int) {
    script.Open(Revision{0});
    const std::vector<v1::EditRequest> step = ReceiveStep(script);
    v1::ErrorDetail error;
    error.set_reason("PROTOCOL_ORDER");
    script.Reject(step[1], error);
    script.Accept(step[2]);
    script.SendDiff(history.Diff(1));
    script.Advanced(step[3], history.Diff(1));
    script.Next();
    return grpc::Status::OK;
  };
  const auto session = Open(server);
  session->SetAnswers(Answers::kWithAdvance);
  ASSERT_NO_FATAL_FAILURE(SendStep(*session));
  const auto report = session->Advance();
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().code, ErrorCode::kProtocolOrder);
  ExpectSame(session->replica(), history.models[1]);
}

TEST(Session, TheAdvanceOfAStepSentAheadSaysWhichUpdateWasRefused) {
  const History history(1);
  FakeServer server;
  server.on_edit = [&](EditScript& script, int) {
    script.Open(Revision{0});
    const auto reject = [&](const v1::EditRequest& request, const std::string& reason) {
      v1::ErrorDetail error;
      error.set_reason(reason);
      error.set_index(3);
      script.Reject(request, error);
    };
    const std::vector<v1::EditRequest> step = ReceiveStep(script);
    reject(step[1], "NOT_FINITE");
    reject(step[2], "EXPRESSION_VALUE");
    reject(step[3], "UPDATE_REJECTED");
    const v1::EditRequest update = script.Next();
    reject(update, "NOT_FINITE");
    script.Accept(script.Next());  // The discard, after which nothing is left of the refusal.
    const v1::EditRequest advance = script.Next();
    script.SendDiff(history.Diff(1));
    script.Advanced(advance, history.Diff(1));
    reject(script.Next(), "UPDATE_REJECTED");
    script.Next();
    return grpc::Status::OK;
  };
  const auto session = Open(server);
  session->SetAnswers(Answers::kWithAdvance);
  ASSERT_NO_FATAL_FAILURE(SendStep(*session));
  const auto refused = session->Advance();
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kNotFinite);
  EXPECT_EQ(refused.error().index, 3);
  EXPECT_TRUE(session->UpdateMetric({.source = SizeMetric{"0.1"}}).ok()) << "it was only sent";
  EXPECT_TRUE(session->Discard().ok());
  EXPECT_TRUE(session->Advance().ok());
  const auto later = session->Advance();
  ASSERT_FALSE(later.ok());
  EXPECT_EQ(later.error().code, ErrorCode::kUpdateRejected);
}

// Goal: a server that hears of nothing but updates is not sent so many that it stops reading.
TEST(Session, ReadsTheOldestAnswersWhenManyUpdatesAreOnTheirWay) {
  constexpr int kUpdates = 100;
  FakeServer server;
  int unanswered_max = 0;
  server.on_edit = [&](EditScript& script, int) {
    script.Open(Revision{0});
    std::vector<v1::EditRequest> requests;
    for (int i = 0; i < 33; ++i) requests.push_back(script.Next());
    for (int i = 0; i < kUpdates; ++i) {
      script.Accept(requests[static_cast<std::size_t>(i)]);
      if (std::ssize(requests) < kUpdates) requests.push_back(script.Next());
      unanswered_max = std::max(unanswered_max, static_cast<int>(std::ssize(requests)) - i - 1);
    }
    script.Accept(script.Next());
    script.Next();
    return grpc::Status::OK;
  };
  {
    const auto session = Open(server);
    session->SetAnswers(Answers::kWithAdvance);
    for (int i = 0; i < kUpdates; ++i) {
      ASSERT_TRUE(session->UpdateMetric({.source = SizeMetric{"0.1"}}).ok());
    }
    EXPECT_TRUE(session->Discard().ok());
  }
  server.Stop();
  EXPECT_EQ(unanswered_max, 33);
}

// Goal: what was sent ahead and has no answer when the stream breaks is sent again, byte for byte:
//       the server applies none of it twice.
TEST(Session, AStepSentAheadIsRepeatedAsItWas) {
  const History history(1);
  FakeServer server;
  std::vector<std::vector<v1::EditRequest>> steps;
  server.on_edit = [&](EditScript& script, int stream) {
    script.Open(Revision{0});
    steps.push_back(ReceiveStep(script));
    if (stream == 1) return grpc::Status(grpc::StatusCode::UNAVAILABLE, "the cable was pulled");
    script.Accept(steps[1][1]);
    script.Accept(steps[1][2]);
    script.SendDiff(history.Diff(1));
    script.Advanced(steps[1][3], history.Diff(1));
    script.Next();
    return grpc::Status::OK;
  };
  const auto session = Open(server);
  session->SetAnswers(Answers::kWithAdvance);
  ASSERT_NO_FATAL_FAILURE(SendStep(*session));
  const auto report = session->Advance();
  ASSERT_TRUE(report.ok()) << report.error().message;
  ASSERT_EQ(steps.size(), 2U);
  EXPECT_EQ(steps[0].size(), 4U);
  EXPECT_EQ(TextOf(steps[0]), TextOf(steps[1]));
}

/// A server that loses the first stream, once `receive` has read what it wants of it, and accepts
/// the first command of the next one.
std::function<grpc::Status(EditScript&, int)> LoseFirst(
    const std::function<void(EditScript&)>& receive, std::vector<v1::EditRequest>& next) {
  return [receive, &next](EditScript& script, int stream) {
    script.Open(Revision{0});
    if (stream == 1) {
      receive(script);
      return grpc::Status(grpc::StatusCode::UNAVAILABLE, "the cable was pulled");
    }
    next.push_back(script.Next());
    script.Accept(next.back());
    script.Next();
    return grpc::Status::OK;
  };
}

// Goal: where the stream cannot be made again nobody knows how much of the step is staged; Reopen
//       empties the stage, so that the step can be sent anew and is not half there already.
TEST(Session, ReopenEmptiesTheStageOfAStepThatWasLostOnItsWay) {
  FakeServer server;
  std::vector<v1::EditRequest> first;
  server.on_edit = LoseFirst([](EditScript& script) { ReceiveStep(script); }, first);
  {
    const auto session = Open(server, /*reconnect_max=*/{});
    session->SetAnswers(Answers::kWithAdvance);
    ASSERT_NO_FATAL_FAILURE(SendStep(*session));
    EXPECT_EQ(session->Advance().error().code, ErrorCode::kUnavailable);
    EXPECT_THAT(session->UpdateMetric({}).error().message, HasSubstr("Reopen"));
    EXPECT_TRUE(session->Reopen().ok());
  }
  server.Stop();
  ASSERT_EQ(first.size(), 1U);
  EXPECT_TRUE(first[0].has_discard());
}

// Goal: an update whose sender was told that it is well is not forgotten without a word, also where
//       answers are awaited at once by the time the stream is lost.
TEST(Session, ReopenTellsOfAnUpdateThatWasSentAhead) {
  FakeServer server;
  std::vector<v1::EditRequest> first;
  server.on_edit = LoseFirst([](EditScript& script) { script.Next(); }, first);
  {
    const auto session = Open(server, /*reconnect_max=*/{});
    session->SetAnswers(Answers::kWithAdvance);
    ASSERT_TRUE(session->UpdateMetric({}).ok());
    session->SetAnswers(Answers::kAtOnce);
    EXPECT_EQ(session->Reopen().error().code, ErrorCode::kUpdateRejected);
  }
  server.Stop();
  ASSERT_EQ(first.size(), 1U);
  EXPECT_TRUE(first[0].has_discard());
}

}  // namespace
}  // namespace pliant::client
