#include "server/outbox.h"

#include <gtest/gtest.h>

namespace pliant::server {
namespace {

TEST(Outbox, HasRoomBelowItsBoundAndNotAtIt) {
  Outbox<int> outbox(100);
  outbox.Push(1, 99);
  EXPECT_TRUE(outbox.has_room());
  outbox.Push(2, 1);
  EXPECT_FALSE(outbox.has_room()) << "at the bound";
  EXPECT_EQ(outbox.Pop(), 1);
  EXPECT_TRUE(outbox.has_room());
}

// Goal: an answer is never lost, even past the bound.
TEST(Outbox, KeepsEveryAnswerInOrder) {
  Outbox<int> outbox(1);
  for (int i = 0; i < 5; ++i) outbox.Push(i, 10);
  EXPECT_EQ(outbox.bytes(), 50U);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(outbox.Pop(), i);
  EXPECT_EQ(outbox.Pop(), std::nullopt);
  EXPECT_TRUE(outbox.empty());
}

}  // namespace
}  // namespace pliant::server
