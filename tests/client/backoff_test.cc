#include "client/cpp/backoff.h"

#include <gtest/gtest.h>

#include <chrono>
#include <set>

namespace pliant::client {
namespace {

TEST(Backoff, GrowsToItsLimitAndIsSpread) {
  std::set<std::int64_t> last;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Backoff backoff(seed);
    std::int64_t low = 10;
    for (int i = 0; i < 12; ++i) {
      const std::int64_t pause = backoff.Next().count();
      EXPECT_GE(pause, low) << i;
      EXPECT_LE(pause, 2 * low) << i;
      low = std::min<std::int64_t>(2 * low, 1000);
      if (i == 11) last.insert(pause);
    }
  }
  EXPECT_GT(last.size(), 10U) << "clients would come back together";
}

TEST(Outage, EndsAfterItsTimeAndBeginsAnew) {
  Outage never(std::chrono::milliseconds(0));
  EXPECT_FALSE(never.NextPause().has_value());
  Outage outage(std::chrono::milliseconds(100));
  const auto start = Outage::Clock::now();
  int pauses = 0;
  while (outage.NextPause()) ++pauses;
  EXPECT_GE(pauses, 3);
  EXPECT_LE(pauses, 4);
  EXPECT_GE(outage.end() - start, std::chrono::milliseconds(100));
  outage.End();
  ASSERT_TRUE(outage.NextPause().has_value());
  EXPECT_GT(outage.end(), Outage::Clock::now() + std::chrono::milliseconds(50));
}

}  // namespace
}  // namespace pliant::client
