#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

#include "core/base/check.h"
#include "server/session.h"
#include "tests/support/session_harness.h"

namespace pliant::server {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr auto kAdvance = &SessionHarness::AdvanceOf;

// Goal: a call that takes long goes on slice by slice; the state that it looks at does not change
// meanwhile, and what waits comes after it.
TEST(SessionCalls, LetsACallGoOnInSlices) {
  SessionHarness harness;
  const auto editor = harness.Edit({OpenCommand{}, kAdvance(1, {})});
  editor->events.clear();
  int slice_count = 0;
  ASSERT_TRUE(harness.session
                  ->Post([&](const Result<const CommittedState*>& state) {
                    ASSERT_TRUE(state.ok());
                    (*state)->session->GoOn([&](const Status& there, Clock::Time) {
                      EXPECT_TRUE(there.ok());
                      EXPECT_THAT(editor->Log(), IsEmpty());
                      return ++slice_count == 3;
                    });
                  })
                  .ok());
  editor->commands = {kMetric(2, 1.0), kAdvance(3, {})};
  harness.session->Wake();
  EXPECT_TRUE(harness.scheduler.RunOne());
  EXPECT_EQ(slice_count, 1);
  EXPECT_TRUE(harness.scheduler.RunOne());
  EXPECT_EQ(slice_count, 2);
  harness.RunAll();
  EXPECT_EQ(slice_count, 3);
  EXPECT_THAT(editor->Log(), ElementsAre("accepted 2", "diff 3", "advanced 3"));
}

// Goal: a call that goes on is answered once, also when the session ends or meets a bug.
TEST(SessionCalls, TellsACallThatGoesOnWhyItCannot) {
  for (const bool by_bug : {false, true}) {
    SessionHarness harness;
    harness.Edit({OpenCommand{}, kAdvance(1, {})});
    std::vector<ErrorCode> answers;
    const auto rest = [&](const Status& there, Clock::Time) {
      if (!there.ok()) answers.push_back(there.error().code);
      PLIANT_CHECK(!by_bug || !there.ok(), "test", "rest");
      return !there.ok();
    };
    ASSERT_TRUE(harness.session
                    ->Post([&](const Result<const CommittedState*>& state) {
                      (*state)->session->GoOn(rest);
                    })
                    .ok());
    EXPECT_TRUE(harness.scheduler.RunOne());
    if (!by_bug) harness.session->Close({ErrorCode::kSessionNotFound, "deleted"});
    harness.RunAll();
    EXPECT_THAT(answers, ElementsAre(by_bug ? ErrorCode::kInternal : ErrorCode::kSessionNotFound));
    EXPECT_TRUE(harness.broken.empty());
  }
}

}  // namespace
}  // namespace pliant::server
