#include "server/update_results.h"

#include <gtest/gtest.h>

#include <string>

#include "server/limits.h"

namespace pliant::server {
namespace {

constexpr Fingerprint kNewMetric{UpdateKind::kMetric, 7};

UpdateAnswer Accepted(std::int64_t update_id, const Fingerprint& update = kNewMetric) {
  return {.event = {.update_id = update_id, .body = AcceptedEvent{}}, .update = update};
}

TEST(UpdateResults, RemembersUpToItsBoundAndForgetsTheOldestBeyond) {
  UpdateResults results(2);
  EXPECT_EQ(results.last_update_id(), 0);
  results.Add(Accepted(3));
  results.Add(Accepted(7));
  EXPECT_EQ(results.Repeat(3, kNewMetric)->update_id, 3);
  results.Add(Accepted(8));
  EXPECT_FALSE(results.Repeat(3, kNewMetric).ok()) << "one past the bound";
  EXPECT_EQ(results.Repeat(7, kNewMetric)->update_id, 7);
  EXPECT_EQ(results.Repeat(8, kNewMetric)->update_id, 8);
  EXPECT_EQ(results.last_update_id(), 8);
}

// Goal: every kind of answer comes back as it was, in order.
TEST(UpdateResults, GivesBackWhatWasAdded) {
  UpdateResults results(4);
  const Error error{ErrorCode::kNotFinite, "no", "metric.tensors", 17};
  const Fingerprint advance{UpdateKind::kAdvance, 8};
  results.Add({{.update_id = 2, .revision = Revision(5), .body = AcceptedEvent{.staged_count = 3}},
               kNewMetric});
  results.Add(
      {{.update_id = 4, .revision = Revision(5), .body = RejectedEvent{error}}, kNewMetric});
  results.Add({{.update_id = 9,
                .revision = Revision(6),
                .body = AdvancedEvent{.base_revision = Revision(5), .motion_fraction = 0.5}},
               advance});
  ASSERT_EQ(results.count(), 3U);
  const SessionEvent accepted = *results.Repeat(2, kNewMetric);
  EXPECT_EQ(accepted.revision, Revision(5));
  EXPECT_EQ(std::get<AcceptedEvent>(accepted.body).staged_count, 3);
  EXPECT_EQ(std::get<RejectedEvent>(results.Repeat(4, kNewMetric)->body).error.index, 17);
  EXPECT_EQ(std::get<AdvancedEvent>(results.Repeat(9, advance)->body).motion_fraction, 0.5);
  EXPECT_EQ(results.At(0).event.update_id, 2);
  EXPECT_EQ(results.At(0).update, kNewMetric);
  EXPECT_EQ(results.At(2).update, advance);
  EXPECT_EQ(results.At(2).event.revision, Revision(6));
}

// Goal: numbers that follow each other never run out; nor do those of a client that skips.
TEST(UpdateResults, LeavesHalfOfTheNumbersForThoseToCome) {
  UpdateResults results(4);
  EXPECT_TRUE(results.CheckNew(kUpdateIdMax / 2).ok());
  EXPECT_EQ(results.CheckNew(kUpdateIdMax / 2 + 1).error().code, ErrorCode::kOutOfRange);
  EXPECT_EQ(results.CheckNew(kUpdateIdMax).error().field, "update_id");
  results.Add(Accepted(kUpdateIdMax / 2));
  EXPECT_TRUE(results.CheckNew(kUpdateIdMax / 2 + 1).ok());
  EXPECT_FALSE(results.CheckNew(kUpdateIdMax).ok());
  results.Add(Accepted(kUpdateIdMax - 2));
  EXPECT_TRUE(results.CheckNew(kUpdateIdMax - 1).ok()) << "the next one is always allowed";
  EXPECT_FALSE(results.CheckNew(kUpdateIdMax).ok());
}

TEST(UpdateResults, KnowsNothingOfIdsThatNeverWere) {
  UpdateResults results(4);
  results.Add(Accepted(3));
  results.Add(Accepted(7));
  EXPECT_EQ(results.Repeat(5, kNewMetric).error().code, ErrorCode::kProtocolOrder);
  EXPECT_EQ(results.Repeat(-1, kNewMetric).error().field, "update_id");
}

// Goal: two callers that use one number do not get each other's answers.
TEST(UpdateResults, AnswersNoOtherUpdate) {
  UpdateResults results(4);
  results.Add(Accepted(3));
  for (const Fingerprint& other :
       {Fingerprint{UpdateKind::kMetric, 8}, Fingerprint{UpdateKind::kNodes, 7},
        Fingerprint{UpdateKind::kAdvance, 7}}) {
    const Result<SessionEvent> answer = results.Repeat(3, other);
    ASSERT_FALSE(answer.ok());
    EXPECT_EQ(answer.error().code, ErrorCode::kProtocolOrder);
    EXPECT_EQ(answer.error().field, "update_id");
    for (const char* part : {"update_id 3", "a metric", "last_update_id + 1"}) {
      EXPECT_NE(answer.error().message.find(part), std::string::npos) << answer.error().message;
    }
  }
  EXPECT_TRUE(results.Repeat(3, {UpdateKind::kMetric, 0}).ok()) << "its arrays were not complete";
}

// Goal: answers that were stored before there were fingerprints go on to be given.
TEST(UpdateResults, AnswersWhatCouldHaveBeenAnsweredSo) {
  UpdateResults results(4);
  const Fingerprint advance{UpdateKind::kAdvance, 8};
  const Fingerprint rollback{UpdateKind::kRollback, 9};
  results.Add(Accepted(1, {}));
  results.Add({{.update_id = 2, .body = AdvancedEvent{}}, {}});
  results.Add({{.update_id = 3, .body = RejectedEvent{}}, {}});
  EXPECT_TRUE(results.Repeat(1, kNewMetric).ok());
  EXPECT_FALSE(results.Repeat(1, advance).ok());
  EXPECT_FALSE(results.Repeat(1, rollback).ok());
  EXPECT_FALSE(results.Repeat(2, kNewMetric).ok());
  EXPECT_TRUE(results.Repeat(2, advance).ok());
  EXPECT_TRUE(results.Repeat(2, rollback).ok());
  EXPECT_TRUE(results.Repeat(3, kNewMetric).ok());
  EXPECT_TRUE(results.Repeat(3, advance).ok());
}

TEST(UpdateResults, RefusesIdsThatDoNotGrow) {
  UpdateResults results(4);
  results.Add(Accepted(3));
  EXPECT_THROW(results.Add(Accepted(3)), InvariantViolation);
}

}  // namespace
}  // namespace pliant::server
