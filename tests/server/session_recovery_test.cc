// Goal: promise Isolated. A bug inside one session is told to its client with a reference; the
// session goes on from its last commit if its mesh is provably valid there, and ends otherwise.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/session_harness.h"

namespace pliant::server {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(SessionRecovery, GoesBackToTheLastCommitAndGoesOn) {
  SessionHarness harness;
  const auto editor = harness.Edit({OpenCommand{}, Advance(1)});
  harness.script->throw_in_step = true;
  editor->events.clear();
  editor->commands = {SessionHarness::MetricAtTime(2, 1.0), Advance(3)};
  harness.session->Wake();
  harness.RunAll();
  EXPECT_THAT(editor->Log(), ElementsAre("accepted 2", "rejected 3"));
  const Error& error = std::get<RejectedEvent>(editor->events[1].body).error;
  EXPECT_EQ(error.code, ErrorCode::kInternal);
  EXPECT_THAT(error.message, HasSubstr("back at revision 1"));
  EXPECT_THAT(error.message, HasSubstr(error.field)) << "the reference";
  EXPECT_EQ(harness.script->rollback_count, 1);
  EXPECT_TRUE(harness.broken.empty());

  harness.script->throw_in_step = false;
  editor->commands = {Advance(4)};
  harness.session->Wake();
  harness.RunAll();
  EXPECT_EQ(editor->events.back().revision, Revision(2));
}

// The diff has been told by then, and so has its revision: there is where the session goes on.
TEST(SessionRecovery, GoesOnFromACommitWhoseTroublesItCannotFind) {
  SessionHarness harness;
  harness.script->during_troubles = [] { PLIANT_CHECK(false, "test", "troubles"); };
  const auto editor = harness.Edit({OpenCommand{}, Advance(1)});
  EXPECT_THAT(editor->Log(), ElementsAre("opened", "diff 1", "rejected 1"));
  const Error& error = std::get<RejectedEvent>(editor->events[2].body).error;
  EXPECT_EQ(error.code, ErrorCode::kInternal);
  EXPECT_THAT(error.message, HasSubstr("back at revision 1"));

  harness.script->during_troubles = nullptr;
  editor->commands = {Advance(2)};
  harness.session->Wake();
  harness.RunAll();
  EXPECT_EQ(editor->events.back().revision, Revision(2));
}

TEST(SessionRecovery, EndsTheSessionWhoseMeshIsBrokenAfterGoingBack) {
  SessionHarness harness;
  const auto editor = harness.Edit({OpenCommand{}, Advance(1)});
  harness.script->throw_in_commit = true;
  harness.script->invalid_after_rollback = true;
  editor->events.clear();
  editor->commands = {Advance(2)};
  // Who is told looks for the session in vain.
  editor->before_send = [&] { EXPECT_THAT(harness.broken, ElementsAre("s1")); };
  harness.session->Wake();
  harness.RunAll();
  EXPECT_THAT(editor->Log(), ElementsAre("rejected 2"));
  ASSERT_TRUE(editor->closed.has_value());
  EXPECT_EQ(editor->closed->code, ErrorCode::kInternal);
  EXPECT_THAT(harness.broken, ElementsAre("s1"));
}

TEST(SessionRecovery, AnswersTheCallThatMetTheBug) {
  SessionHarness harness;
  harness.Edit({OpenCommand{}, Advance(1)});
  std::vector<ErrorCode> answers;
  ASSERT_TRUE(harness.session
                  ->Post([&](const Result<const CommittedState*>& state) {
                    if (!state.ok()) {
                      answers.push_back(state.error().code);
                      return;
                    }
                    PLIANT_CHECK(false, "test", "call");
                  })
                  .ok());
  harness.RunAll();
  EXPECT_THAT(answers, ElementsAre(ErrorCode::kInternal));
  EXPECT_TRUE(harness.broken.empty());
}

}  // namespace
}  // namespace pliant::server
