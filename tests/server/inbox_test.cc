#include "server/inbox.h"

#include <gtest/gtest.h>

#include <string>

namespace pliant::server {
namespace {

TEST(Inbox, GivesItemsBackInOrder) {
  Inbox<int> inbox({.count_max = 3, .bytes_max = 100});
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(inbox.Push(i, 1).has_value());
  for (int i = 0; i < 3; ++i) EXPECT_EQ(inbox.Pop(), i);
  EXPECT_EQ(inbox.Pop(), std::nullopt);
}

TEST(Inbox, TakesCountMaxItemsAndNotOneMore) {
  Inbox<int> inbox({.count_max = 2, .bytes_max = 100});
  EXPECT_FALSE(inbox.Push(1, 0).has_value());
  EXPECT_FALSE(inbox.full());
  EXPECT_FALSE(inbox.Push(2, 0).has_value());
  EXPECT_TRUE(inbox.full());
  EXPECT_EQ(inbox.Push(3, 0), 3) << "one past the bound comes back";
  EXPECT_EQ(inbox.count(), 2U);
  EXPECT_EQ(inbox.Pop(), 1);
  EXPECT_FALSE(inbox.full());
}

// Goal: the bound on bytes stops what follows, so that one large command fits into an empty inbox.
TEST(Inbox, TakesOneItemBeyondBytesMaxAndNotTwo) {
  Inbox<std::string> inbox({.count_max = 10, .bytes_max = 100});
  EXPECT_FALSE(inbox.Push("a", 99).has_value());
  EXPECT_FALSE(inbox.full()) << "one byte below the bound";
  EXPECT_FALSE(inbox.Push("b", 1000).has_value());
  EXPECT_TRUE(inbox.full());
  EXPECT_TRUE(inbox.Push("c", 1).has_value());
  EXPECT_EQ(inbox.bytes(), 1099U);
  EXPECT_EQ(inbox.Pop(), "a");
  EXPECT_TRUE(inbox.full()) << "the large one is still there";
  EXPECT_EQ(inbox.Pop(), "b");
  EXPECT_EQ(inbox.bytes(), 0U);
  EXPECT_FALSE(inbox.full());
}

}  // namespace
}  // namespace pliant::server
