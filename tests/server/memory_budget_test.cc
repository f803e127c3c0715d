#include "server/memory_budget.h"

#include <gtest/gtest.h>

namespace pliant::server {
namespace {

TEST(MemoryBudget, CallsOnlyWhoGrowsBeyondTheLimit) {
  int calls = 0;
  MemoryBudget budget(100, [&] { ++calls; });
  budget.Add(100);
  EXPECT_EQ(calls, 0);
  EXPECT_EQ(budget.excess(), 0);
  budget.Add(1);
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(budget.excess(), 1);
  budget.Add(-1);
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(budget.used(), 100);
}

TEST(MemoryBudget, CountsWhatWasMeasuredBesides) {
  int calls = 0;
  MemoryBudget budget(100, [&] { ++calls; });
  budget.SetBesides(70);
  budget.Add(30);
  EXPECT_EQ(calls, 0);
  budget.Add(1);
  EXPECT_EQ(calls, 1);
  EXPECT_EQ(budget.excess(), 1);
  EXPECT_EQ(budget.used(), 31) << "sessions alone";
  budget.SetBesides(0);
  EXPECT_EQ(budget.excess(), -69);
}

TEST(MemoryBudget, WithoutALimitNobodyIsCalled) {
  MemoryBudget budget(0, [] { FAIL(); });
  budget.Add(INT64_MAX);
  EXPECT_EQ(budget.excess(), 0);
}

}  // namespace
}  // namespace pliant::server
