// Goal: who calls RollbackTo neither spoils the stream of an editor that has just come, nor fills
// the memory of one that does not read. Both were met by the simulation.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <optional>

#include "tests/support/session_harness.h"

namespace pliant::server {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class SessionRollbackTest : public testing::Test {
 protected:
  static EngineInput Square() {
    Domain square;
    square.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    square.segments = {{0, 1, 1}, {1, 2, 2}, {2, 3, 3}, {3, 0, 4}};
    EngineInput input;
    input.start = std::move(square);
    input.metric.source = SizeMetric{"0.5"};
    return input;
  }

  Status RollbackTo(Revision revision, std::int64_t update_id) {
    std::optional<Status> done;
    const Status posted = harness_.session->Post([&](const Result<const CommittedState*>& state) {
      const auto there = (*state)->session->RollbackTo(revision, update_id, {});
      done = there.ok() ? Status() : Status(there.error());
    });
    EXPECT_TRUE(posted.ok());
    harness_.RunAll();
    return *done;
  }

  SessionHarness harness_{{}, Square()};
};

TEST_F(SessionRollbackTest, AnEditorIsToldFirstWhereTheSessionIs) {
  const auto first =
      harness_.Edit({OpenCommand{}, SessionHarness::AdvanceOf(1), SessionHarness::AdvanceOf(2)});
  harness_.session->Detach(first.get());
  const auto late = harness_.Edit({});  // Attached; its first command is still on its way.
  ASSERT_TRUE(RollbackTo(Revision(1), 3).ok());
  EXPECT_THAT(late->Log(), IsEmpty());
  late->commands.emplace_back(OpenCommand{.mirror_revision = Revision(2)});
  harness_.session->Wake();
  harness_.RunAll();
  EXPECT_THAT(late->Log(), ElementsAre("opened", "diff"));
  ASSERT_TRUE(RollbackTo(Revision(2), 4).ok());
  EXPECT_THAT(late->Log(), ElementsAre("opened", "diff", "diff"));
}

TEST_F(SessionRollbackTest, WaitsForAnEditorThatDoesNotRead) {
  const auto editor =
      harness_.Edit({OpenCommand{}, SessionHarness::AdvanceOf(1), SessionHarness::AdvanceOf(2)});
  editor->has_room = false;
  const Status refused = RollbackTo(Revision(1), 3);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kResourceExhausted);
  EXPECT_GT(refused.error().retry_after_ms, 0);
  EXPECT_EQ(harness_.session->info().revision, Revision(2));
  editor->has_room = true;
  EXPECT_TRUE(RollbackTo(Revision(1), 3).ok());
  EXPECT_EQ(harness_.session->info().revision, Revision(3));
}

}  // namespace
}  // namespace pliant::server
