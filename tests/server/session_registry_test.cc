#include "server/session_registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <string>
#include <vector>

#include "tests/support/session_harness.h"

namespace pliant::server {
namespace {

using testing::ElementsAre;

// A session that only has a name.
std::shared_ptr<Session> Named(const std::string& id) {
  static ManualClock clock;
  Session::Environment environment;
  environment.clock = &clock;
  return std::make_shared<Session>(environment, id, std::map<std::string, std::string>());
}

std::vector<std::string> IdsOf(const SessionRegistry::Page& page) {
  std::vector<std::string> ids;
  for (const auto& session : page.sessions) ids.push_back(session->session_id());
  return ids;
}

TEST(SessionRegistry, FindsASessionOnlyOnceItIsPublished) {
  SessionRegistry registry({10, 10}, /*seed=*/1);
  ASSERT_TRUE(registry.Reserve("", "a").ok());
  EXPECT_EQ(registry.Find("", "a").error().code, ErrorCode::kSessionNotFound);
  EXPECT_EQ(registry.Reserve("", "a").error().code, ErrorCode::kSessionExists);
  registry.Publish("", Named("a"));
  EXPECT_EQ((*registry.Find("", "a"))->session_id(), "a");
  EXPECT_NE(registry.Remove("", "a"), nullptr);
  EXPECT_EQ(registry.Remove("", "a"), nullptr);
  EXPECT_EQ(registry.Find("", "a").error().code, ErrorCode::kSessionNotFound);
  EXPECT_TRUE(registry.Reserve("", "a").ok()) << "the id is free again";
}

TEST(SessionRegistry, HoldsAsManyAsAllowedAndNotOneMore) {
  SessionRegistry registry({2, 2}, 1);
  ASSERT_TRUE(registry.Reserve("", "a").ok());
  ASSERT_TRUE(registry.Reserve("", "").ok());
  EXPECT_EQ(registry.Reserve("", "c").error().code, ErrorCode::kResourceExhausted);
  EXPECT_GT(registry.Reserve("", "c").error().retry_after_ms, 0) << "others may delete theirs";
  EXPECT_EQ(registry.Reserve("", "a").error().code, ErrorCode::kSessionExists)
      << "the more precise cause comes first";
  registry.Remove("", "a");
  EXPECT_TRUE(registry.Reserve("", "c").ok());
}

TEST(SessionRegistry, KeepsTenantsApart) {
  SessionRegistry registry({.sessions_max = 4, .sessions_per_tenant_max = 2}, 1);
  for (const char* tenant : {"x", "y"}) {
    ASSERT_TRUE(registry.Reserve(tenant, "a").ok());
    registry.Publish(tenant, Named("a"));
  }
  EXPECT_NE(*registry.Find("x", "a"), *registry.Find("y", "a"));
  EXPECT_EQ(registry.Find("z", "a").error().code, ErrorCode::kSessionNotFound);
  ASSERT_TRUE(registry.Reserve("x", "b").ok());
  const Error full = registry.Reserve("x", "c").error();
  EXPECT_EQ(full.code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(full.retry_after_ms, 0) << "waiting alone frees nothing...";
  EXPECT_NE(full.message.find("delete one"), std::string::npos) << "...but that";
  EXPECT_TRUE(registry.Reserve("y", "c").ok());
  EXPECT_THAT(IdsOf(registry.List("y", 0, 9)), ElementsAre("a"));
  EXPECT_EQ(registry.All().size(), 2U);
  EXPECT_NE(registry.Remove("x", "a"), nullptr);
  EXPECT_TRUE(registry.Reserve("x", "c").ok());
  EXPECT_TRUE(registry.Find("y", "a").ok());
}

TEST(SessionRegistry, MakesUpIdsThatDiffer) {
  SessionRegistry registry({1000, 1000}, 1);
  std::set<std::string> ids;
  for (int i = 0; i < 1000; ++i) ids.insert(*registry.Reserve("", ""));
  EXPECT_EQ(ids.size(), 1000U);
}

TEST(SessionRegistry, ListsByAgeInPages) {
  SessionRegistry registry({10, 10}, 1);
  for (const char* id : {"c", "a", "b"}) {
    ASSERT_TRUE(registry.Reserve("", id).ok());
    registry.Publish("", Named(id));
  }
  SessionRegistry::Page page = registry.List("", 0, 2);
  EXPECT_THAT(IdsOf(page), ElementsAre("c", "a"));
  ASSERT_NE(page.next, 0);
  page = registry.List("", page.next, 2);
  EXPECT_THAT(IdsOf(page), ElementsAre("b"));
  EXPECT_EQ(page.next, 0);
  EXPECT_EQ(registry.List("", 0, 3).next, 0) << "exactly one page";
  EXPECT_EQ(registry.All().size(), 3U);
}

// Goal: a session that goes while one pages does not make another one appear twice or vanish.
TEST(SessionRegistry, KeepsItsPlaceWhenSessionsGo) {
  SessionRegistry registry({10, 10}, 1);
  for (const char* id : {"a", "b", "c", "d"}) {
    ASSERT_TRUE(registry.Reserve("", id).ok());
    registry.Publish("", Named(id));
  }
  const SessionRegistry::Page page = registry.List("", 0, 2);
  registry.Remove("", "a");
  registry.Remove("", "b");
  EXPECT_THAT(IdsOf(registry.List("", page.next, 2)), ElementsAre("c", "d"));
}

}  // namespace
}  // namespace pliant::server
