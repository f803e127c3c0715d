#include "server/session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <vector>

#include "server/limits.h"
#include "tests/support/session_harness.h"

namespace pliant::server {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(Session, CommitsItsFirstRevisionAtTheFirstAdvance) {
  SessionHarness harness;
  ASSERT_TRUE(harness.start_status->ok());
  EXPECT_EQ(harness.session->info().revision, Revision::kNone);
  const auto editor = harness.Edit({OpenCommand{}, Advance(1)});
  EXPECT_THAT(editor->Log(), ElementsAre("opened", "diff 1", "advanced 1"));
  EXPECT_EQ(editor->done_count, 2);
  EXPECT_EQ(BodyOf<DiffEvent>(*editor, 1).diff->revision, Revision(1));
  EXPECT_EQ(BodyOf<DiffEvent>(*editor, 1).applied_update_id, 1);
  const auto& advanced = BodyOf<AdvancedEvent>(*editor, 2);
  EXPECT_EQ(advanced.progress.stop_reason, StopReason::kConverged);
  EXPECT_EQ(advanced.progress.counts.visits, 10);
  EXPECT_EQ(harness.session->info().revision, Revision(1));
  EXPECT_EQ(harness.session->info().last_update_id, 1);
  EXPECT_EQ(harness.session->info().labels.at("case"), "7");
}

// Goal: a client takes over the diff while the session looks for troubles, which comes with the
// answer; and they are those of what the commit has changed.
TEST(Session, TellsTheDiffBeforeItLooksForTroubles) {
  SessionHarness harness;
  const auto editor = std::make_shared<FakeEditor>();
  std::vector<std::string> told;
  harness.script->during_troubles = [&] { told = editor->Log(); };
  editor->commands = {OpenCommand{}, Advance(1)};
  ASSERT_TRUE(harness.session->Attach(editor).ok());
  harness.session->Wake();
  harness.RunAll();
  EXPECT_THAT(told, ElementsAre("opened", "diff 1"));
  const auto& advanced = BodyOf<AdvancedEvent>(*editor, 2);
  ASSERT_EQ(advanced.troubles.size(), 1u);
  EXPECT_EQ(advanced.troubles[0].vertex_count, advanced.progress.counts.visits);
}

TEST(Session, TellsItsCreatorWhyItsEngineRefused) {
  SessionHarness harness({.create_error = Error{ErrorCode::kOpenLoop, "open", "domain.segments"}});
  ASSERT_FALSE(harness.start_status->ok());
  EXPECT_EQ(harness.start_status->error().code, ErrorCode::kOpenLoop);
}

// Goal: promise Atomic. An advance after a refused update commits nothing, and the next step works.
TEST(Session, NeverCommitsHalfOfAStep) {
  SessionHarness harness;
  const auto editor = harness.Edit({OpenCommand{}, Advance(1)});
  editor->events.clear();
  editor->commands = {
      kMetric(2, 1.0),
      UpdateCommand{3, BadUpdate{{ErrorCode::kNotFinite, "NaN", "metric.tensors", 17}}}, Advance(4),
      kMetric(5, 2.0), Advance(6)};
  harness.session->Wake();
  harness.RunAll();
  EXPECT_THAT(editor->Log(), ElementsAre("accepted 2", "rejected 3", "rejected 4", "accepted 5",
                                         "diff 6", "advanced 6"));
  EXPECT_EQ(BodyOf<RejectedEvent>(*editor, 1).error.index, 17);
  EXPECT_EQ(BodyOf<RejectedEvent>(*editor, 2).error.code, ErrorCode::kUpdateRejected);
  EXPECT_EQ(editor->events[4].revision, Revision(2)) << "the refused step committed no revision";
  EXPECT_EQ(harness.script->rollback_count, 1) << "update 2 was undone";
  EXPECT_EQ(BodyOf<AdvancedEvent>(*editor, 5).progress.counts.visits, 5) << "update 5 alone";
}

TEST(Session, LetsAClientDiscardInsteadOfAdvance) {
  SessionHarness harness;
  const auto editor = harness.Edit({OpenCommand{}, Advance(1),
                                    UpdateCommand{2, BadUpdate{{ErrorCode::kNotFinite, "NaN"}}},
                                    UpdateCommand{3, DiscardUpdate{}}, Advance(4)});
  EXPECT_THAT(editor->Log(), ElementsAre("opened", "diff 1", "advanced 1", "rejected 2",
                                         "accepted 3", "diff 4", "advanced 4"));
}

TEST(Session, KeepsTheStageWhenOnlyTheAdvanceIsBad) {
  SessionHarness harness;
  const auto editor =
      harness.Edit({OpenCommand{}, Advance(1), kMetric(2, 1.0),
                    UpdateCommand{3, BadAdvance{{ErrorCode::kOutOfRange, "-1"}}}, Advance(4)});
  EXPECT_THAT(editor->Log(), ElementsAre("opened", "diff 1", "advanced 1", "accepted 2",
                                         "rejected 3", "diff 4", "advanced 4"));
  EXPECT_EQ(BodyOf<AdvancedEvent>(*editor, 6).progress.counts.visits, 5) << "update 2 is in it";
}

// Goal: an update that was staged over a connection that broke is still staged for the next.
TEST(Session, KeepsWhatIsStagedWhenAConnectionBreaks) {
  SessionHarness harness;
  const auto first = harness.Edit({OpenCommand{}, Advance(1), kMetric(2, 1.0)});
  harness.session->Detach(first.get());
  const auto second = harness.Edit({OpenCommand{.mirror_revision = Revision(1)}, Advance(3)});
  EXPECT_EQ(BodyOf<OpenedEvent>(*second, 0).staged_count, 1);
  EXPECT_EQ(BodyOf<AdvancedEvent>(*second, 2).progress.counts.visits, 5);
}

TEST(Session, SendsAMirrorWhatItMissed) {
  SessionHarness harness;
  harness.session->Detach(harness.Edit({OpenCommand{}, Advance(1), Advance(2)}).get());
  auto editor = harness.Edit({OpenCommand{.mirror_revision = Revision(2)}});
  EXPECT_THAT(editor->Log(), ElementsAre("opened"));
  harness.session->Detach(editor.get());
  editor = harness.Edit({OpenCommand{.mirror_revision = Revision(1)}});
  EXPECT_THAT(editor->Log(), ElementsAre("opened", "diff"));
  EXPECT_EQ(BodyOf<DiffEvent>(*editor, 1).diff->base_revision, Revision(1));
  harness.session->Detach(editor.get());
  // No mirror, and one of a revision that never was or is no longer known.
  for (const std::int64_t revision : {0, 77}) {
    editor = harness.Edit({OpenCommand{.mirror_revision = Revision(revision)}});
    EXPECT_THAT(editor->Log(), ElementsAre("opened", "snapshot"));
    EXPECT_EQ(BodyOf<SnapshotEvent>(*editor, 1).snapshot->revision, Revision(2));
    harness.session->Detach(editor.get());
  }
  editor = harness.Edit({OpenCommand{.mirror = Mirror::kNone}, Advance(3)});
  EXPECT_THAT(editor->Log(), ElementsAre("opened", "advanced 3"));
}

TEST(Session, TellsSubscribersWhatIsCommittedAndWhenItEnds) {
  SessionHarness harness;
  const auto early = std::make_shared<FakeSubscriber>();
  ASSERT_TRUE(harness.session->Subscribe(early, Revision(0)).ok());
  harness.RunAll();
  EXPECT_THAT(early->log, ElementsAre("bookmark 0"));
  harness.session->Detach(harness.Edit({OpenCommand{}, Advance(1)}).get());
  EXPECT_THAT(early->log, ElementsAre("bookmark 0", "diff 0-1"));

  harness.Edit({OpenCommand{.mirror_revision = Revision(1)}, kMetric(2, 1.0)});
  const auto late = std::make_shared<FakeSubscriber>();
  ASSERT_TRUE(harness.session->Subscribe(late, Revision(0)).ok());
  harness.RunAll();
  EXPECT_THAT(late->log, ElementsAre("snapshot 1"));
  harness.session->Unsubscribe(late.get());
  harness.session->Close({ErrorCode::kSessionNotFound, "gone", {}});
  harness.RunAll();
  EXPECT_EQ(early->closed->code, ErrorCode::kSessionNotFound);
  EXPECT_FALSE(late->closed.has_value());
  EXPECT_EQ(harness.session->Subscribe(late, Revision(0)).error().code,
            ErrorCode::kSessionNotFound);
}

// Goal: transfer rows cost time, so they are made while somebody wants them and not otherwise. An
// editor whose connection has broken still counts: it comes back for what it missed.
TEST(Session, MakesTransferRowsWhileSomebodyWantsThem) {
  SessionHarness h;
  const auto advance = [&](std::int64_t id, bool wants_transfer) {
    const OpenCommand open{.wants_transfer = wants_transfer};
    const auto editor = h.Edit({open, SessionHarness::AdvanceOf(id)});
    h.session->Detach(editor.get());
    return std::exchange(h.script->transfer_count, 0);
  };
  EXPECT_EQ(advance(1, false), 0);
  EXPECT_EQ(advance(2, true), 1);
  EXPECT_EQ(advance(3, false), 0);
  const auto subscriber = std::make_shared<FakeSubscriber>();
  subscriber->wants_rows = true;
  ASSERT_TRUE(h.session->Subscribe(subscriber, Revision(0)).ok());
  EXPECT_EQ(advance(4, false), 1);
  h.session->Unsubscribe(subscriber.get());
  EXPECT_EQ(advance(5, false), 0);
}

TEST(Session, HasOneEditorAtATime) {
  SessionHarness harness;
  const auto first = harness.Edit({OpenCommand{}});
  const auto second = harness.Edit({OpenCommand{}});
  ASSERT_FALSE(harness.attach_status.ok());
  EXPECT_EQ(harness.attach_status.error().code, ErrorCode::kSessionBusy);
  EXPECT_THAT(second->Log(), IsEmpty());
  harness.session->Detach(first.get());
  harness.Edit({OpenCommand{}});
  EXPECT_TRUE(harness.attach_status.ok());
}

TEST(Session, StopsAtTheVisitBudgetAndGoesOnLater) {
  SessionHarness harness({.visits_needed = 5000});
  const auto editor = harness.Edit({OpenCommand{}, Advance(1, {.visits_max = 3001}), Advance(2)});
  const auto& first = BodyOf<AdvancedEvent>(*editor, 2);
  EXPECT_EQ(first.progress.stop_reason, StopReason::kVisitBudget);
  EXPECT_EQ(first.progress.counts.visits, 3001);
  EXPECT_EQ(first.progress.active_count, 1999);
  const auto& second = BodyOf<AdvancedEvent>(*editor, 4);
  EXPECT_EQ(second.progress.stop_reason, StopReason::kConverged);
  EXPECT_EQ(second.progress.counts.visits, 1999);
}

TEST(Session, StopsAtTheTimeBudgetWithACommittedMesh) {
  SessionHarness harness({.visits_needed = 1'000'000});
  harness.script->clock = &harness.clock;
  const auto editor =
      harness.Edit({OpenCommand{}, Advance(1, {.time_max = std::chrono::milliseconds(50)})});
  EXPECT_THAT(editor->Log(), ElementsAre("opened", "diff 1", "advanced 1"));
  const auto& advanced = BodyOf<AdvancedEvent>(*editor, 2);
  EXPECT_EQ(advanced.end, AdvanceEnd::kTimeBudget);
  // A visit takes a microsecond; the clock is read every kVisitsPerStep visits.
  EXPECT_GE(advanced.progress.counts.visits, 50'000);
  EXPECT_LE(advanced.progress.counts.visits, 50'000 + kVisitsPerStep);
  EXPECT_EQ(advanced.compute, std::chrono::microseconds(advanced.progress.counts.visits));
}

TEST(Session, SendsProgressAtTheWishedInterval) {
  SessionHarness harness({.visits_needed = 100'000});
  harness.script->clock = &harness.clock;
  const auto editor = harness.Edit(
      {OpenCommand{}, Advance(1, {.progress_interval = std::chrono::milliseconds(20)})});
  EXPECT_THAT(editor->Log(), ElementsAre("opened", "progress 1", "progress 1", "progress 1",
                                         "progress 1", "diff 1", "advanced 1"));
  EXPECT_EQ(BodyOf<ProgressEvent>(*editor, 1).progress.active_count, 80'000);
  EXPECT_EQ(BodyOf<ProgressEvent>(*editor, 1).elapsed, std::chrono::milliseconds(20));
}

TEST(Session, CommitsWhatItHasWhenAnAdvanceIsCancelled) {
  SessionHarness harness({.visits_needed = 1'000'000});
  harness.script->clock = &harness.clock;
  const auto editor = std::make_shared<FakeEditor>();
  editor->commands = {OpenCommand{}, Advance(1), Advance(2, {.visits_max = 10})};
  ASSERT_TRUE(harness.session->Attach(editor).ok());
  harness.session->Wake();
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(harness.scheduler.RunOne());
  EXPECT_THAT(editor->Log(), ElementsAre("opened")) << "still at work";
  EXPECT_TRUE(harness.session->info().running);
  harness.session->CancelAdvance(1);
  harness.RunAll();
  EXPECT_THAT(editor->Log(), ElementsAre("opened", "diff 1", "advanced 1", "diff 2", "advanced 2"));
  const auto& cancelled = BodyOf<AdvancedEvent>(*editor, 2);
  EXPECT_EQ(cancelled.progress.stop_reason, StopReason::kCancelled);
  EXPECT_GT(cancelled.progress.counts.visits, 0);
  EXPECT_EQ(BodyOf<AdvancedEvent>(*editor, 4).progress.counts.visits, 10)
      << "the cancel was for advance 1 alone";
}

TEST(Session, HonoursACancelThatComesBeforeItsAdvanceBegins) {
  SessionHarness harness;
  harness.session->CancelAdvance(1);
  const auto editor = harness.Edit({OpenCommand{}, Advance(1)});
  EXPECT_EQ(BodyOf<AdvancedEvent>(*editor, 2).progress.stop_reason, StopReason::kCancelled);
  EXPECT_EQ(BodyOf<AdvancedEvent>(*editor, 2).progress.counts.visits, 0);
}

// Goal: one cancel does not make the session forget another.
TEST(Session, HonoursEveryCancelThatComesBeforeItsUpdateBegins) {
  SessionHarness harness({.visits_needed = 100});
  for (const std::int64_t id : {1, 3, 4}) harness.session->CancelAdvance(id);
  const auto editor = harness.Edit({OpenCommand{}, Advance(1), Advance(2), kMetric(3, 2.0)});
  EXPECT_THAT(editor->Log(),
              ElementsAre("opened", "diff 1", "advanced 1", "diff 2", "advanced 2", "rejected 3"));
  EXPECT_EQ(BodyOf<AdvancedEvent>(*editor, 2).progress.stop_reason, StopReason::kCancelled);
  EXPECT_EQ(BodyOf<AdvancedEvent>(*editor, 4).progress.stop_reason, StopReason::kConverged);
  EXPECT_EQ(BodyOf<RejectedEvent>(*editor, 5).error.code, ErrorCode::kCancelled);
}

// Goal: whoever names more updates than a session remembers is heard for those that come first.
TEST(Session, RemembersTheNearestCancels) {
  SessionHarness harness({.visits_needed = 100});
  for (auto id = static_cast<std::int64_t>(kCancelsMax) + 1; id > 0; --id) {
    harness.session->CancelAdvance(id);
  }
  const auto last = static_cast<std::int64_t>(kCancelsMax);
  const auto editor = harness.Edit({OpenCommand{}, Advance(1), Advance(last), Advance(last + 1)});
  EXPECT_EQ(BodyOf<AdvancedEvent>(*editor, 2).progress.stop_reason, StopReason::kCancelled);
  EXPECT_EQ(BodyOf<AdvancedEvent>(*editor, 4).progress.stop_reason, StopReason::kCancelled);
  EXPECT_EQ(BodyOf<AdvancedEvent>(*editor, 6).progress.stop_reason, StopReason::kConverged);
}

// Goal: a cancel reaches an update that is being staged; the stage is as before, and because the
// client may have sent the rest of the step already, none of it is committed.
TEST(Session, RefusesAnUpdateThatIsCancelledWhileItIsStaged) {
  SessionHarness harness;
  const auto editor = harness.Edit({OpenCommand{}, Advance(1), kMetric(2, 1.0)});
  harness.script->during_update = [&] { harness.session->CancelAdvance(3); };
  editor->events.clear();
  editor->commands = {kMetric(3, 2.0), Advance(4)};
  harness.session->Wake();
  harness.RunAll();
  EXPECT_THAT(editor->Log(), ElementsAre("rejected 3", "rejected 4"));
  EXPECT_EQ(BodyOf<RejectedEvent>(*editor, 0).error.code, ErrorCode::kCancelled);
  EXPECT_EQ(BodyOf<RejectedEvent>(*editor, 1).error.code, ErrorCode::kUpdateRejected);
}

// Goal: it is answered also if its editor has named another one since.
TEST(Session, RefusesACancelledUpdateThatIsNotTheLastOneNamed) {
  SessionHarness harness;
  const auto editor = harness.Edit({OpenCommand{}, Advance(1)});
  harness.script->during_update = [&] {
    harness.session->CancelAdvance(2);
    harness.session->CancelAdvance(3);
  };
  editor->events.clear();
  editor->commands = {kMetric(2, 2.0), Advance(3)};
  harness.session->Wake();
  harness.RunAll();
  EXPECT_THAT(editor->Log(), ElementsAre("rejected 2", "rejected 3"));
  EXPECT_EQ(BodyOf<RejectedEvent>(*editor, 0).error.code, ErrorCode::kCancelled);
  EXPECT_EQ(BodyOf<RejectedEvent>(*editor, 1).error.code, ErrorCode::kUpdateRejected);
}

// Goal: nobody waits for an update whose client has gone: it counts as never sent, what was staged
// before stays, and the client that comes back sends it again.
TEST(Session, ForgetsAnUpdateWhoseEditorGoesWhileItIsStaged) {
  SessionHarness harness;
  const auto first = std::make_shared<FakeEditor>();
  harness.script->during_update = [&, count = 0]() mutable {
    if (++count == 2) harness.session->Detach(first.get());
  };
  first->commands = {OpenCommand{}, Advance(1), kMetric(2, 1.0), kMetric(3, 2.0)};
  ASSERT_TRUE(harness.session->Attach(first).ok());
  harness.session->Wake();
  harness.RunAll();
  EXPECT_THAT(first->Log(), ElementsAre("opened", "diff 1", "advanced 1", "accepted 2"));
  const auto second = harness.Edit({OpenCommand{}, kMetric(3, 2.0), Advance(4)});
  EXPECT_EQ(BodyOf<OpenedEvent>(*second, 0).last_update_id, 2);
  EXPECT_EQ(BodyOf<AcceptedEvent>(*second, 2).staged_count, 2);
  EXPECT_THAT(second->Log(),
              ElementsAre("opened", "snapshot", "accepted 3", "diff 4", "advanced 4"));
}

TEST(Session, EndsWhileAnUpdateIsStaged) {
  SessionHarness harness;
  harness.script->during_update = [&] {
    harness.session->Close({ErrorCode::kSessionNotFound, "deleted", {}});
  };
  const auto editor = harness.Edit({OpenCommand{}, Advance(1), kMetric(2, 1.0)});
  EXPECT_THAT(editor->Log(), ElementsAre("opened", "diff 1", "advanced 1"));
  EXPECT_TRUE(editor->closed.has_value());
}

// Goal: the time of an advance ends a step that would take long, but not the first one.
// Method: each step takes 60 ms before it looks, of the 100 that there are.
TEST(Session, EndsAStepWhenTheTimeOfItsAdvanceIsOver) {
  SessionHarness harness({.visits_needed = 10'000});
  harness.script->during_step = [&] { harness.clock.Advance(std::chrono::milliseconds(60)); };
  const auto editor =
      harness.Edit({OpenCommand{}, Advance(1, {.time_max = std::chrono::milliseconds(100)})});
  const auto& advanced = BodyOf<AdvancedEvent>(*editor, 2);
  EXPECT_EQ(advanced.end, AdvanceEnd::kTimeBudget);
  EXPECT_EQ(advanced.progress.counts.visits, kVisitsPerStep) << "the second step saw the time";
  EXPECT_GT(advanced.progress.active_count, 0);
}

TEST(Session, GoesBackWhenTheMetricHasNoValueWhereAVertexWent) {
  SessionHarness harness;
  const auto editor = harness.Edit({OpenCommand{}, Advance(1), kMetric(2, 1.0)});
  harness.script->step_error = Error{ErrorCode::kExpressionValue, "1/0 at (0, 0)"};
  editor->events.clear();
  editor->commands = {Advance(3)};
  harness.session->Wake();
  harness.RunAll();
  EXPECT_THAT(editor->Log(), ElementsAre("rejected 3"));
  EXPECT_EQ(harness.script->rollback_count, 1);
  harness.script->step_error.reset();
  editor->commands = {Advance(4)};
  harness.session->Wake();
  harness.RunAll();
  EXPECT_EQ(editor->events.back().revision, Revision(2));
}

// Before the first commit there is no revision to go back to: the engine is built anew.
TEST(Session, StartsOverWhenTheFirstAdvanceFails) {
  SessionHarness harness;
  harness.script->step_error = Error{ErrorCode::kExpressionValue, "1/0 at (0, 0)"};
  const auto editor = harness.Edit({OpenCommand{}, Advance(1)});
  EXPECT_THAT(editor->Log(), ElementsAre("opened", "rejected 1"));
  EXPECT_EQ(harness.script->created_count, 2);
  EXPECT_EQ(harness.script->rollback_count, 0);
}

// Goal: promise Bounded. Without room for answers no command is taken.
TEST(Session, TakesNoCommandWhileThereIsNoRoomForAnswers) {
  SessionHarness harness;
  const auto editor = std::make_shared<FakeEditor>();
  editor->commands = {OpenCommand{}, Advance(1)};
  editor->has_room = false;
  ASSERT_TRUE(harness.session->Attach(editor).ok());
  harness.session->Wake();
  harness.RunAll();
  EXPECT_THAT(editor->Log(), IsEmpty());
  editor->has_room = true;
  harness.session->Wake();
  harness.RunAll();
  EXPECT_THAT(editor->Log(), ElementsAre("opened", "diff 1", "advanced 1"));
}

TEST(Session, AnswersCallsFromTheCommittedState) {
  SessionHarness harness;
  std::vector<std::string> answers;
  const auto call = [&](const Result<const CommittedState*>& state) {
    answers.push_back(state.ok()
                          ? "revision " + std::to_string(static_cast<int>((*state)->revision))
                          : std::string(ErrorCodeName(state.error().code)));
  };
  ASSERT_TRUE(harness.session->Post(call).ok());
  harness.RunAll();
  harness.Edit({OpenCommand{}, Advance(1)});
  ASSERT_TRUE(harness.session->Post(call).ok());
  harness.RunAll();
  EXPECT_THAT(answers, ElementsAre("REVISION_NOT_FOUND", "revision 1"));
}

TEST(Session, TakesAsManyWaitingCallsAsAllowedAndNotOneMore) {
  SessionHarness harness;
  int answered = 0;
  const auto call = [&](const Result<const CommittedState*>&) { ++answered; };
  for (std::size_t i = 0; i < kCallsMax; ++i) ASSERT_TRUE(harness.session->Post(call).ok());
  const Status refused = harness.session->Post(call);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kResourceExhausted);
  harness.RunAll();
  EXPECT_EQ(answered, static_cast<int>(kCallsMax));
}

TEST(Session, EndsItsEditorAndCallsWhenItIsClosed) {
  SessionHarness harness;
  const auto editor = harness.Edit({OpenCommand{}, Advance(1)});
  std::optional<ErrorCode> answer;
  ASSERT_TRUE(harness.session
                  ->Post([&](const Result<const CommittedState*>& state) {
                    if (!state.ok()) answer = state.error().code;
                  })
                  .ok());
  harness.session->Close({ErrorCode::kSessionNotFound, "deleted"});
  harness.RunAll();
  ASSERT_TRUE(editor->closed.has_value());
  EXPECT_EQ(editor->closed->code, ErrorCode::kSessionNotFound);
  EXPECT_EQ(answer, ErrorCode::kSessionNotFound);
  EXPECT_FALSE(harness.session->Post([](const auto&) {}).ok());
  EXPECT_FALSE(harness.session->Attach(std::make_shared<FakeEditor>()).ok());
}

// Goal: at shutdown a running advance commits what it has before its stream ends.
TEST(Session, CommitsARunningAdvanceWhenTheServerDrains) {
  SessionHarness harness({.visits_needed = 1'000'000});
  harness.script->clock = &harness.clock;
  const auto editor = std::make_shared<FakeEditor>();
  editor->commands = {OpenCommand{}, Advance(1), Advance(2)};
  ASSERT_TRUE(harness.session->Attach(editor).ok());
  harness.session->Wake();
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(harness.scheduler.RunOne());
  harness.session->Drain({ErrorCode::kUnavailable, "the server shuts down"});
  harness.RunAll();
  EXPECT_THAT(editor->Log(), ElementsAre("opened", "diff 1", "advanced 1"));
  EXPECT_EQ(BodyOf<AdvancedEvent>(*editor, 2).end, AdvanceEnd::kServerClosing);
  ASSERT_TRUE(editor->closed.has_value());
  EXPECT_EQ(editor->closed->code, ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace pliant::server
