#include "core/base/lazy.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <vector>

#include "core/threads/thread_pool.h"

namespace pliant {
namespace {

// Goal: the value is made once, however many threads ask first, and all see all of it.
TEST(Lazy, MakesItsValueOnce) {
  ThreadPool pool(4);
  for (int trial = 0; trial < 50; ++trial) {
    Lazy<std::vector<int>> lazy;
    std::atomic<int> made = 0;
    std::atomic<int> right = 0;
    pool.Run(16, [&](std::int32_t /*index*/) {
      right += lazy.Get([&] {
        ++made;
        return std::vector<int>(1000, 7);
      }) == std::vector<int>(1000, 7);
    });
    EXPECT_EQ(made, 1);
    EXPECT_EQ(right, 16);
  }
}

TEST(Lazy, TriesAgainAfterAnException) {
  Lazy<int> lazy;
  EXPECT_THROW((void)lazy.Get([]() -> int { throw std::runtime_error("x"); }), std::runtime_error);
  EXPECT_FALSE(lazy.made());
  EXPECT_EQ(lazy.Get([] { return 3; }), 3);
  EXPECT_TRUE(lazy.made());
  EXPECT_EQ(lazy.Get([] { return 4; }), 3);
}

}  // namespace
}  // namespace pliant
