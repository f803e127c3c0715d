// Goal: an update that comes again gets its first answer, and another one under its number none.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/support/session_harness.h"

namespace pliant::server {
namespace {

using testing::ElementsAre;

// Goal: promise Resumable. What is sent twice is applied once and answered twice.
TEST(SessionRepeat, AnswersARepeatedUpdateWithoutApplyingIt) {
  SessionHarness harness;
  const auto first = harness.Edit({OpenCommand{}, Advance(1), kMetric(2, 1.0), Advance(3)});
  harness.session->Detach(first.get());
  const auto calls = harness.script->calls;
  const auto second =
      harness.Edit({OpenCommand{.mirror_revision = Revision(2)}, kMetric(2, 1.0), Advance(3)});
  EXPECT_THAT(second->Log(), ElementsAre("opened", "accepted 2", "advanced 3"));
  EXPECT_EQ(harness.script->calls, calls) << "nothing was applied again";
  EXPECT_EQ(harness.session->info().revision, Revision(2));
  EXPECT_EQ(BodyOf<OpenedEvent>(*second, 0).last_update_id, 3);
  EXPECT_EQ(second->done_count, 3);
}

UpdateCommand With(UpdateCommand command, UpdateKind kind, std::uint64_t hash) {
  command.fingerprint = {kind, hash};
  return command;
}

// Goal: who uses a number that another one has used learns it, and commits nothing without what was
// refused; who used it gets the first answer again.
TEST(SessionRepeat, RefusesAnotherUpdateUnderAUsedNumber) {
  SessionHarness harness;
  const UpdateCommand metric = With(kMetric(2, 1.0), UpdateKind::kMetric, 7);
  const UpdateCommand advance = With(Advance(3), UpdateKind::kAdvance, 8);
  const auto editor = harness.Edit(
      {OpenCommand{}, Advance(1), metric, advance, With(kMetric(2, 2.0), UpdateKind::kMetric, 9),
       With(kMetric(3, 1.0), UpdateKind::kMetric, 7), Advance(4),
       With(Advance(2), UpdateKind::kAdvance, 8), metric, advance, Advance(5),
       With(kMetric(2, 2.0), UpdateKind::kMetric, 9), With(Advance(3), UpdateKind::kAdvance, 9),
       kMetric(6, 1.0), Advance(7)});
  EXPECT_THAT(editor->Log(),
              ElementsAre("opened", "diff 1", "advanced 1", "accepted 2", "diff 3", "advanced 3",
                          "rejected 2", "rejected 3", "rejected 4", "rejected 2", "accepted 2",
                          "advanced 3", "diff 5", "advanced 5", "rejected 2", "rejected 3",
                          "accepted 6", "diff 7", "advanced 7"))
      << "a step that is refused as a whole leaves nothing behind";
  const Error& error = BodyOf<RejectedEvent>(*editor, 6).error;
  EXPECT_EQ(error.code, ErrorCode::kProtocolOrder);
  EXPECT_NE(error.message.find("update_id 2 was used by another update"), std::string::npos);
  EXPECT_EQ(BodyOf<RejectedEvent>(*editor, 8).error.code, ErrorCode::kUpdateRejected)
      << "an advance without what was refused";
  EXPECT_EQ(editor->done_count, 15);
}

// Goal: an advance says little, and two callers' advances often the same; one that follows what was
// refused is not told of the other's commit.
TEST(SessionRepeat, GivesNobodyTheCommitOfAnothersStep) {
  SessionHarness harness;
  const UpdateCommand advance = With(Advance(3), UpdateKind::kAdvance, 8);
  const auto first = harness.Edit(
      {OpenCommand{}, Advance(1), With(kMetric(2, 1.0), UpdateKind::kMetric, 7), advance});
  harness.session->Detach(first.get());
  const auto second = harness.Edit({OpenCommand{.mirror_revision = Revision(2)},
                                    With(kMetric(2, 2.0), UpdateKind::kMetric, 9), advance,
                                    kMetric(4, 2.0), Advance(5)});
  EXPECT_THAT(second->Log(), ElementsAre("opened", "rejected 2", "rejected 3", "accepted 4",
                                         "diff 5", "advanced 5"));
  EXPECT_EQ(BodyOf<RejectedEvent>(*second, 2).error.code, ErrorCode::kUpdateRejected);
  harness.session->Detach(second.get());
  const auto third = harness.Edit({OpenCommand{.mirror_revision = Revision(3)}, advance});
  EXPECT_THAT(third->Log(), ElementsAre("opened", "advanced 3")) << "whose step it was";
}

// Goal: what was refused before a resend stays refused by it.
TEST(SessionRepeat, KeepsTheRefusalOfWhatComesAfterARepeatedAdvance) {
  SessionHarness harness;
  const UpdateCommand advance = With(Advance(1), UpdateKind::kAdvance, 8);
  const UpdateCommand bad{
      2, BadUpdate{{ErrorCode::kNotFinite, "no"}}, {}, {UpdateKind::kMetric, 7}};
  const auto first = harness.Edit({OpenCommand{}, advance, bad});
  harness.session->Detach(first.get());
  const auto second =
      harness.Edit({OpenCommand{.mirror_revision = Revision(1)}, advance, bad, Advance(3)});
  EXPECT_THAT(second->Log(), ElementsAre("opened", "advanced 1", "rejected 2", "rejected 3"));
}

TEST(SessionRepeat, RefusesAnUpdateIdThatNeverWasAndIsNotNew) {
  SessionHarness harness;
  const auto editor = harness.Edit({OpenCommand{}, Advance(5), kMetric(4, 1.0)});
  EXPECT_THAT(editor->Log(), ElementsAre("opened", "diff 5", "advanced 5", "rejected 4"));
  EXPECT_EQ(BodyOf<RejectedEvent>(*editor, 3).error.code, ErrorCode::kProtocolOrder);
}

// Goal: no slip of a client takes all numbers that a session has: what it sends so is refused, with
// its step, and the session goes on where it was.
TEST(SessionRepeat, RefusesANumberThatLeavesTooFew) {
  SessionHarness harness;
  const auto editor =
      harness.Edit({OpenCommand{}, kMetric(kUpdateIdMax, 1.0), Advance(1), kMetric(2, 1.0),
                    Advance(3), Advance(kUpdateIdMax), Advance(4)});
  EXPECT_THAT(editor->Log(), ElementsAre("opened", "rejected 4611686018427387904", "rejected 1",
                                         "accepted 2", "diff 3", "advanced 3",
                                         "rejected 4611686018427387904", "diff 4", "advanced 4"));
  const Error& error = BodyOf<RejectedEvent>(*editor, 1).error;
  EXPECT_EQ(error.code, ErrorCode::kOutOfRange);
  EXPECT_EQ(error.field, "update_id");
  EXPECT_NE(error.message.find("numbers up to 2305843009213693952 are allowed"), std::string::npos)
      << error.message;
  EXPECT_EQ(editor->done_count, 7);
}

}  // namespace
}  // namespace pliant::server
