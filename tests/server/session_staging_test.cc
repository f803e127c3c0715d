// Goal: an advance that is due, or cancelled, while what was sent before it is still being staged
// is answered then; nothing is committed without the rest of its step, and no work is lost. Method:
// a fake engine whose updates take as long as the test says.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "server/session.h"
#include "tests/support/session_harness.h"

namespace pliant::server {
namespace {

using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::HasSubstr;

class SessionStaging : public testing::Test {
 protected:
  SessionStaging() {
    editor_ = harness_.Edit({OpenCommand{}, SessionHarness::AdvanceOf(1)});
    editor_->events.clear();
    harness_.script->calls.clear();
  }

  void Send(std::vector<SessionCommand> commands) {
    for (SessionCommand& command : commands) editor_->commands.push_back(std::move(command));
    harness_.session->Wake();
    harness_.RunAll();
  }
  /// So long does one update take, from now on.
  void StagingTakes(milliseconds time) {
    harness_.script->during_update = [this, time] { harness_.clock.Advance(time); };
  }
  [[nodiscard]] SessionCommand Due(std::int64_t id, milliseconds after) const {
    return SessionHarness::AdvanceOf(id, {.time_max = after, .arrival = harness_.clock.Now()});
  }
  static SessionCommand Metric(std::int64_t id) {
    return SessionHarness::MetricAtTime(id, static_cast<double>(id));
  }
  template <class Body>
  [[nodiscard]] const Body& Event(std::size_t index) const {
    return std::get<Body>(editor_->events.at(index).body);
  }

  SessionHarness harness_;
  std::shared_ptr<FakeEditor> editor_;
};

TEST_F(SessionStaging, AnswersAnAdvanceThatIsDueAndGoesOn) {
  StagingTakes(milliseconds(20));
  std::vector<std::size_t> calls_at_answers;
  editor_->before_send = [&] { calls_at_answers.push_back(harness_.script->calls.size()); };
  Send({Metric(2), Metric(3), Metric(4), Due(5, milliseconds(30))});
  EXPECT_THAT(editor_->Log(), ElementsAre("accepted 2", "accepted 3", "accepted 4", "advanced 5"));
  EXPECT_THAT(calls_at_answers, ElementsAre(1, 2, 2, 2)) << "in the middle of the second update";
  EXPECT_EQ(Event<AcceptedEvent>(2).staged_count, 3);
  const auto& due = Event<AdvancedEvent>(3);
  EXPECT_EQ(due.end, AdvanceEnd::kStaging);
  EXPECT_EQ(due.base_revision, Revision(1));
  EXPECT_EQ(editor_->events[3].revision, Revision(1));
  EXPECT_EQ(due.summary.state_hash, 1u);
  EXPECT_EQ(due.elapsed, milliseconds(40));
  EXPECT_EQ(editor_->done_count, 6);
  EXPECT_THAT(harness_.script->calls, ElementsAre("metric t=2", "metric t=3", "metric t=4"));
  editor_->events.clear();
  Send({SessionHarness::AdvanceOf(6)});
  EXPECT_THAT(editor_->Log(), ElementsAre("diff 6", "advanced 6"));
  EXPECT_EQ(Event<AdvancedEvent>(1).base_revision, Revision(1));
  EXPECT_EQ(harness_.script->calls.size(), 3u) << "nothing was staged twice";
}

TEST_F(SessionStaging, AnswersAnAdvanceThatIsCancelled) {
  harness_.script->during_update = [&] { harness_.session->CancelAdvance(3); };
  Send({Metric(2), SessionHarness::AdvanceOf(3), SessionHarness::AdvanceOf(4)});
  EXPECT_THAT(editor_->Log(), ElementsAre("accepted 2", "advanced 3", "diff 4", "advanced 4"));
  EXPECT_EQ(Event<AdvancedEvent>(1).end, AdvanceEnd::kStaging);
}

// Goal: a client that asks again and again is answered each time, and staging is not begun anew.
TEST_F(SessionStaging, AnswersEveryAdvanceThatIsDueMeanwhile) {
  harness_.script->during_update = [this, count = 0]() mutable {
    if (++count == 2) editor_->commands.emplace_back(Due(5, milliseconds(10)));
    harness_.clock.Advance(milliseconds(20));
  };
  Send({Metric(2), Metric(3), Due(4, milliseconds(10))});
  EXPECT_THAT(editor_->Log(), ElementsAre("accepted 2", "accepted 3", "advanced 4", "advanced 5"));
  EXPECT_EQ(Event<AdvancedEvent>(3).end, AdvanceEnd::kStaging);
  EXPECT_EQ(Event<AdvancedEvent>(3).elapsed, milliseconds(20)) << "since the first one's end";
}

// Goal: what is put off is bounded by what a stream may have waiting.
TEST_F(SessionStaging, PutsOffNoMoreWhileSomethingIsPutOff) {
  harness_.script->during_update = [this, count = 0]() mutable {
    if (++count == 2) {
      editor_->commands.emplace_back(Metric(6));
      editor_->commands.emplace_back(Due(7, milliseconds(10)));
    }
    harness_.clock.Advance(milliseconds(20));
  };
  Send({Metric(2), Metric(3), Metric(4), Due(5, milliseconds(10))});
  // Due while 3 is staged, but 4 is put off then; when 4 is staged nothing is.
  EXPECT_THAT(editor_->Log(), ElementsAre("accepted 2", "accepted 3", "accepted 4", "advanced 5",
                                          "accepted 6", "advanced 7"));
  EXPECT_EQ(Event<AcceptedEvent>(4).staged_count, 4);
}

TEST_F(SessionStaging, RefusesTheNextAdvanceIfAnUpdateIsRefusedLate) {
  harness_.script->during_update = [&] {
    harness_.clock.Advance(milliseconds(20));
    harness_.script->update_error = Error{ErrorCode::kNotFinite, "a NaN", "metric", 17};
  };
  Send({Metric(2), Metric(3), Metric(4), Due(5, milliseconds(10))});
  EXPECT_THAT(editor_->Log(), ElementsAre("accepted 2", "accepted 3", "accepted 4", "advanced 5"));
  harness_.script->update_error.reset();
  editor_->events.clear();
  Send({SessionHarness::AdvanceOf(6), SessionHarness::AdvanceOf(7)});
  EXPECT_THAT(editor_->Log(), ElementsAre("rejected 6", "diff 7", "advanced 7"));
  const Error& error = Event<RejectedEvent>(0).error;
  EXPECT_EQ(error.code, ErrorCode::kNotFinite);
  EXPECT_EQ(error.index, 17);
  EXPECT_THAT(error.message, HasSubstr("update 3"));
  EXPECT_EQ(harness_.script->calls.size(), 2u) << "what came after it is dropped";
}

// Goal: who does not want an update any more need not wait for it.
TEST_F(SessionStaging, ADiscardBreaksOffWhatIsPutOff) {
  harness_.script->during_update = [this, count = 0]() mutable {
    if (++count == 2) {
      editor_->commands.emplace_back(UpdateCommand{.update_id = 6, .body = DiscardUpdate{}});
    }
    harness_.clock.Advance(milliseconds(20));
  };
  Send({Metric(2), Metric(3), Metric(4), Due(5, milliseconds(10))});
  EXPECT_THAT(editor_->Log(),
              ElementsAre("accepted 2", "accepted 3", "accepted 4", "advanced 5", "accepted 6"));
  EXPECT_EQ(harness_.script->calls.size(), 2u) << "the third was never begun";
  EXPECT_EQ(Event<AcceptedEvent>(4).staged_count, 0);
  editor_->events.clear();
  Send({SessionHarness::AdvanceOf(7)});
  EXPECT_THAT(editor_->Log(), ElementsAre("diff 7", "advanced 7"));
}

TEST_F(SessionStaging, ABugInWhatIsPutOffRefusesTheNextAdvance) {
  harness_.script->during_update = [this, count = 0]() mutable {
    if (++count == 2) throw std::runtime_error("test");
    harness_.clock.Advance(milliseconds(20));
  };
  Send({Metric(2), Metric(3), Due(4, milliseconds(10))});
  EXPECT_THAT(editor_->Log(), ElementsAre("accepted 2", "accepted 3", "advanced 4"));
  editor_->events.clear();
  Send({SessionHarness::AdvanceOf(5), SessionHarness::AdvanceOf(6)});
  EXPECT_THAT(editor_->Log(), ElementsAre("rejected 5", "diff 6", "advanced 6"));
  EXPECT_EQ(Event<RejectedEvent>(0).error.code, ErrorCode::kInternal);
}

// Goal: what was answered is staged, whoever goes.
TEST_F(SessionStaging, GoesOnWithoutItsEditor) {
  harness_.script->during_update = [this, count = 0]() mutable {
    if (++count == 2) harness_.session->Detach(editor_.get());
    harness_.clock.Advance(milliseconds(20));
  };
  Send({Metric(2), Metric(3), Due(4, milliseconds(10))});
  const auto second = harness_.Edit({OpenCommand{}, SessionHarness::AdvanceOf(5)});
  const auto& opened = std::get<OpenedEvent>(second->events[0].body);
  EXPECT_EQ(opened.last_update_id, 4);
  EXPECT_EQ(opened.staged_count, 2);
  EXPECT_THAT(harness_.script->calls, ElementsAre("metric t=2", "metric t=3"));
}

// Goal: a step of which something was refused already is told so, as ever.
TEST_F(SessionStaging, LeavesARefusedStepAsItIs) {
  StagingTakes(milliseconds(20));
  Send({UpdateCommand{.update_id = 2, .body = BadUpdate{{ErrorCode::kNotFinite, "a NaN", {}}}},
        Metric(3), Due(4, milliseconds(10))});
  EXPECT_THAT(editor_->Log(), ElementsAre("rejected 2", "accepted 3", "rejected 4"));
}

// Goal: where an advance cannot be answered before something else is, it waits.
TEST_F(SessionStaging, WaitsForWhatCannotBePutOff) {
  StagingTakes(milliseconds(20));
  for (const bool is_bad : {true, false}) {
    SCOPED_TRACE(is_bad);
    editor_->events.clear();
    const std::int64_t id = is_bad ? 2 : 5;
    UpdateCommand between{.update_id = id + 1};
    if (is_bad) between.body = BadUpdate{{ErrorCode::kNotFinite, "a NaN", {}}};
    if (!is_bad) between.body = RollbackUpdate{Revision(1)};
    Send({Metric(id), between, Due(id + 2, milliseconds(10))});
    EXPECT_EQ(editor_->Log()[1], "rejected " + std::to_string(id + 1));
    EXPECT_EQ(editor_->Log().back(), (is_bad ? "rejected " : "advanced ") + std::to_string(id + 2));
  }
  EXPECT_EQ(editor_->Log()[2], "diff 7") << "a first step is made in any case";
}

// Goal: an update that is cancelled while it waits is refused when its turn comes.
TEST_F(SessionStaging, DoesNotPutOffACancelledUpdate) {
  harness_.script->during_update = [&] {
    harness_.clock.Advance(milliseconds(20));
    harness_.session->CancelAdvance(3);
  };
  Send({Metric(2), Metric(3), Due(4, milliseconds(10))});
  EXPECT_THAT(editor_->Log(), ElementsAre("accepted 2", "rejected 3", "rejected 4"));
}

}  // namespace
}  // namespace pliant::server
