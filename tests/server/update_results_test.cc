#include "server/update_results.h"

#include <gtest/gtest.h>

namespace pliant::server {
namespace {

SessionEvent Accepted(std::int64_t update_id) {
  return {.update_id = update_id, .body = AcceptedEvent{}};
}

TEST(UpdateResults, RemembersUpToItsBoundAndForgetsTheOldestBeyond) {
  UpdateResults results(2);
  EXPECT_EQ(results.last_update_id(), 0);
  results.Add(Accepted(3));
  results.Add(Accepted(7));
  EXPECT_EQ(results.Find(3)->update_id, 3);
  results.Add(Accepted(8));
  EXPECT_FALSE(results.Find(3).has_value()) << "one past the bound";
  EXPECT_EQ(results.Find(7)->update_id, 7);
  EXPECT_EQ(results.Find(8)->update_id, 8);
  EXPECT_EQ(results.last_update_id(), 8);
}

// Goal: every kind of answer comes back as it was, in order.
TEST(UpdateResults, GivesBackWhatWasAdded) {
  UpdateResults results(4);
  const Error error{ErrorCode::kNotFinite, "no", "metric.tensors", 17};
  results.Add({.update_id = 2, .revision = Revision(5), .body = AcceptedEvent{.staged_count = 3}});
  results.Add({.update_id = 4, .revision = Revision(5), .body = RejectedEvent{error}});
  results.Add({.update_id = 9,
               .revision = Revision(6),
               .body = AdvancedEvent{.base_revision = Revision(5), .motion_fraction = 0.5}});
  ASSERT_EQ(results.count(), 3U);
  const SessionEvent accepted = *results.Find(2);
  EXPECT_EQ(accepted.revision, Revision(5));
  EXPECT_EQ(std::get<AcceptedEvent>(accepted.body).staged_count, 3);
  EXPECT_EQ(std::get<RejectedEvent>(results.Find(4)->body).error.index, 17);
  EXPECT_EQ(std::get<AdvancedEvent>(results.Find(9)->body).motion_fraction, 0.5);
  EXPECT_EQ(results.At(0).update_id, 2);
  EXPECT_EQ(results.At(2).revision, Revision(6));
}

TEST(UpdateResults, KnowsNothingOfIdsThatNeverWere) {
  UpdateResults results(4);
  results.Add(Accepted(3));
  results.Add(Accepted(7));
  EXPECT_FALSE(results.Find(5).has_value());
  EXPECT_FALSE(results.Find(8).has_value());
  EXPECT_FALSE(results.Find(-1).has_value());
}

TEST(UpdateResults, RefusesIdsThatDoNotGrow) {
  UpdateResults results(4);
  results.Add(Accepted(3));
  EXPECT_THROW(results.Add(Accepted(3)), InvariantViolation);
}

}  // namespace
}  // namespace pliant::server
