#include "server/ticker.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>

namespace pliant::server {
namespace {

using std::chrono::milliseconds;

TEST(Ticker, WorksAgainAndAgainUntilItsEnd) {
  std::atomic<int> count = 0;
  {
    std::latch third(3);
    const Ticker ticker(milliseconds(1), [&] {
      if (++count <= 3) third.count_down();
    });
    third.wait();
  }
  const int at_end = count;
  EXPECT_GE(at_end, 3);
  EXPECT_EQ(count, at_end);
}

TEST(Ticker, EndsAtOnce) {
  std::atomic<int> count = 0;
  {
    const Ticker ticker(std::chrono::hours(1), [&] { ++count; });
  }
  EXPECT_EQ(count, 0);
}

}  // namespace
}  // namespace pliant::server
