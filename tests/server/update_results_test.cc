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
