#include "server/tenant_account.h"

#include <gtest/gtest.h>

namespace pliant::server {
namespace {

using std::chrono::milliseconds;

Clock::Time At(milliseconds time) { return Clock::Time(time); }

TEST(TenantAccount, WithoutLimitsEverythingFits) {
  TenantAccount account({});
  account.Change({}, {.vertices = 1'000'000'000, .bytes = std::int64_t{1} << 50});
  account.Charge(std::chrono::hours(100), At(milliseconds(0)));
  EXPECT_TRUE(account.CheckRoom({}, {.vertices = 1, .bytes = 1}).ok());
  EXPECT_TRUE(account.CheckCompute(At(milliseconds(0))).ok());
}

// At the bound and one past it, for a new session and for one that grows.
TEST(TenantAccount, VerticesAndBytesEndAtTheirBounds) {
  TenantAccount account({.vertices_max = 100, .bytes_max = 1000});
  account.Change({}, {.vertices = 60, .bytes = 500});
  EXPECT_TRUE(account.CheckRoom({}, {.vertices = 40, .bytes = 500}).ok());
  const Status vertices = account.CheckRoom({}, {.vertices = 41, .bytes = 0});
  ASSERT_FALSE(vertices.ok());
  EXPECT_EQ(vertices.error().code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(vertices.error().retry_after_ms, 0) << "waiting alone frees nothing...";
  EXPECT_NE(vertices.error().message.find("delete a session"), std::string::npos) << "...but that";
  EXPECT_FALSE(account.CheckRoom({}, {.vertices = 0, .bytes = 501}).ok());
  EXPECT_TRUE(account.CheckRoom({.vertices = 60, .bytes = 500}, {100, 1000}).ok());
  EXPECT_FALSE(account.CheckRoom({.vertices = 60, .bytes = 500}, {101, 1000}).ok());
  account.Change({.vertices = 60, .bytes = 500}, {});
  EXPECT_EQ(account.usage().vertices, 0);
  EXPECT_TRUE(account.CheckRoom({}, {100, 1000}).ok());
}

TEST(TenantAccount, ComputeTimeIsPaidBackByTheClock) {
  TenantAccount account({.compute_percent = 50, .compute_burst = milliseconds(1000)});
  account.Charge(milliseconds(1000), At(milliseconds(0)));
  EXPECT_TRUE(account.CheckCompute(At(milliseconds(0))).ok()) << "the burst is just used up";
  account.Charge(milliseconds(1), At(milliseconds(0)));
  const Status over = account.CheckCompute(At(milliseconds(0)));
  ASSERT_FALSE(over.ok());
  EXPECT_EQ(over.error().code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(over.error().retry_after_ms, 2) << "a millisecond at half the speed";
  EXPECT_FALSE(account.CheckCompute(At(milliseconds(1))).ok());
  EXPECT_TRUE(account.CheckCompute(At(milliseconds(2))).ok());
  // Rest is not saved up beyond the burst.
  account.Charge(milliseconds(1001), At(milliseconds(1'000'000)));
  EXPECT_FALSE(account.CheckCompute(At(milliseconds(1'000'000))).ok());
}

TEST(TenantAccounts, EveryTenantHasItsOwn) {
  TenantAccounts accounts({.vertices_max = 10});
  accounts.Of("a")->Change({}, {.vertices = 10});
  EXPECT_FALSE(accounts.Of("a")->CheckRoom({}, {.vertices = 1}).ok());
  EXPECT_TRUE(accounts.Of("b")->CheckRoom({}, {.vertices = 10}).ok());
}

}  // namespace
}  // namespace pliant::server
