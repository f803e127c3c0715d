// What session_advance.cc does beyond the tests of session_test.cc.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/session.h"
#include "tests/support/session_harness.h"

namespace pliant::server {
namespace {

using testing::ElementsAre;

// Goal: an advance with a commit interval sends what there is on the way, counts all its work, and
// commits less often for an editor that does not keep up.
TEST(SessionAdvance, CommitsOnTheWayIfAskedTo) {
  for (const bool keeps_up : {true, false}) {
    SCOPED_TRACE(keeps_up);
    SessionHarness harness({.visits_needed = 10'000});
    harness.script->clock = &harness.clock;
    const auto editor = std::make_shared<FakeEditor>();
    editor->commands = {OpenCommand{}, SessionHarness::AdvanceOf(
                                           1, {.visits_max = 8000,
                                               .progress_interval = std::chrono::milliseconds(100),
                                               .commit_interval = std::chrono::milliseconds(3)})};
    ASSERT_TRUE(harness.session->Attach(editor).ok());
    harness.session->Wake();
    // It takes the commands, and then stops reading.
    harness.scheduler.RunOne();
    editor->has_room = keeps_up;
    harness.RunAll();
    if (keeps_up) {
      EXPECT_THAT(editor->Log(), ElementsAre("opened", "diff 1", "diff 1", "diff 1", "advanced 1"));
    } else {
      EXPECT_THAT(editor->Log(), ElementsAre("opened", "diff 1", "advanced 1"));
    }
    const auto& advanced = std::get<AdvancedEvent>(editor->events.back().body);
    EXPECT_EQ(advanced.base_revision, Revision(0));
    EXPECT_EQ(editor->events.back().revision, Revision(keeps_up ? 3 : 1));
    EXPECT_EQ(advanced.progress.counts.visits, 8000);
    EXPECT_EQ(advanced.progress.active_count, 2000);
  }
}

}  // namespace
}  // namespace pliant::server
