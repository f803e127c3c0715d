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

// Goal: a deadline counts from when the advance came, so that it holds for what was sent with it
// too, but not from before the advance ahead of it has ended.
TEST(SessionAdvance, ItsTimeCountsFromWhenItCame) {
  using std::chrono::milliseconds;
  SessionHarness harness({.visits_needed = 100'000});
  harness.script->clock = &harness.clock;
  const Clock::Time arrival = harness.clock.Now();
  // Staging takes 20 ms, a step of 1,000 visits 1 ms.
  harness.script->during_update = [&] { harness.clock.Advance(milliseconds(20)); };
  const AdvanceSpec spec{.time_max = milliseconds(30), .arrival = arrival};
  const AdvanceSpec late{.time_max = milliseconds(10), .arrival = arrival + milliseconds(30)};
  const auto editor = harness.Edit({OpenCommand{}, SessionHarness::MetricAtTime(1, 1),
                                    SessionHarness::AdvanceOf(2, spec),    // Until 30 ms...
                                    SessionHarness::AdvanceOf(3, spec),    // ...60 ms...
                                    SessionHarness::MetricAtTime(4, 2),    // ...80 ms...
                                    SessionHarness::AdvanceOf(5, late)});  // ...due at 70 ms.
  EXPECT_THAT(editor->Log(), ElementsAre("opened", "accepted 1", "diff 2", "advanced 2", "diff 3",
                                         "advanced 3", "accepted 4", "advanced 5"));
  std::vector<std::pair<std::int64_t, milliseconds>> visits_and_elapsed;
  for (const SessionEvent& event : editor->events) {
    const auto* advanced = std::get_if<AdvancedEvent>(&event.body);
    if (advanced == nullptr) continue;
    EXPECT_EQ(advanced->end,
              visits_and_elapsed.size() < 2 ? AdvanceEnd::kTimeBudget : AdvanceEnd::kStaging);
    visits_and_elapsed.emplace_back(advanced->progress.counts.visits,
                                    std::chrono::duration_cast<milliseconds>(advanced->elapsed));
  }
  EXPECT_THAT(visits_and_elapsed,
              ElementsAre(std::pair(10'000, milliseconds(30)), std::pair(30'000, milliseconds(30)),
                          std::pair(0, milliseconds(20))));
}

TEST(SessionAdvance, TellsHowManyCornersWent) {
  SessionHarness harness({.softened_count = 7});
  const auto editor = harness.Edit({OpenCommand{}, SessionHarness::AdvanceOf(1)});
  EXPECT_EQ(std::get<AdvancedEvent>(editor->events.back().body).softened_count, 7);
}

}  // namespace
}  // namespace pliant::server
