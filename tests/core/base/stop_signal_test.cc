#include "core/base/stop_signal.h"

#include <gtest/gtest.h>

#include "tests/support/stop_after.h"

namespace pliant {
namespace {

TEST(StopPoll, AsksOnceAPeriodBeginningWithTheFirstCall) {
  const testing::StopAfter signal(3);
  StopPoll stopped(&signal);
  std::int64_t calls = 0;
  while (!stopped()) ++calls;
  EXPECT_EQ(signal.asked_count(), 3);
  EXPECT_EQ(calls, 2 * StopPoll::kPeriod);
  EXPECT_TRUE(stopped());
  EXPECT_EQ(signal.asked_count(), 3) << "asked again after a yes";
}

TEST(StopPoll, NeverStopsWithoutASignal) {
  StopPoll stopped(nullptr);
  for (std::int64_t i = 0; i < 3 * StopPoll::kPeriod; ++i) ASSERT_FALSE(stopped());
}

TEST(StopFlag, SaysWhatItWasSetTo) {
  StopFlag flag;
  EXPECT_FALSE(flag.asked());
  flag.Set(true);
  EXPECT_TRUE(flag.asked());
  flag.Set(false);
  EXPECT_FALSE(flag.asked());
}

}  // namespace
}  // namespace pliant
