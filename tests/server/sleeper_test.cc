// Goal: who sleeps, and that many sessions work under a limit that holds few of them.
#include "server/sleeper.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/keeper.h"
#include "server/stored_form.h"
#include "tests/support/fake_server_parts.h"
#include "tests/support/memory_store.h"
#include "tests/support/wire_arrays.h"

namespace pliant::server {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// Sessions of the real engine on a scheduler without threads.
class SleeperTest : public testing::Test {
 protected:
  std::shared_ptr<Session> Create(const std::string& id, MemoryBudget* budget) {
    const v1::CreateSession create = test::UnitSquare("0.2");
    auto session = std::make_shared<Session>(
        Session::Environment{.clock = &clock_,
                             .scheduler = &scheduler_,
                             .log = &log_,
                             .factory = RemesherFactory(),
                             .loader = RemesherLoader(),
                             .codec = &codec_,
                             .journal = std::make_shared<StoreJournal>(
                                 store_, StoreKey{DocumentKind::kSession, "", id}, nullptr),
                             .budget = budget,
                             .on_broken = nullptr},
        id, std::map<std::string, std::string>{});
    session->Start(
        codec_.ReadInput(FormOf(create))->engine, [](const Status&) {}, FormOf(create));
    RunAll();
    EXPECT_TRUE(registry_.Reserve("", id).ok());
    registry_.Publish("", session);
    return session;
  }
  void RunAll() {
    while (scheduler_.RunOne()) {
    }
  }
  // What one session holds before its first advance.
  std::int64_t MemoryOfOne() {
    Sleeper probe({}, registry_, clock_);
    const auto session = Create("probe", &probe.budget());
    const std::int64_t one = probe.budget().used();
    session->Close({ErrorCode::kSessionNotFound, "gone", {}});
    RunAll();
    registry_.Remove("", "probe");
    return one;
  }
  static std::vector<std::string> Names(const std::vector<std::shared_ptr<Session>>& sessions) {
    std::vector<std::string> names;
    for (const auto& session : sessions) names.push_back(session->session_id());
    return names;
  }

  const WireCodec codec_;
  ManualClock clock_;
  const Log log_{LogLevel::kError, LogFormat::kText};
  MemoryStore store_;
  Scheduler scheduler_{/*worker_count=*/0, clock_};
  SessionRegistry registry_{{.sessions_max = 2000, .sessions_per_tenant_max = 2000}, 1};
};

TEST_F(SleeperTest, ChoosesTheIdleAndThenTheLeastRecentlyUsed) {
  Sleeper sleeper({.idle_max = std::chrono::seconds(60), .memory_bytes_max = 0}, registry_, clock_);
  for (const char* name : {"a", "b", "c"}) {
    Create(name, &sleeper.budget());
    clock_.Advance(std::chrono::seconds(20));
  }
  EXPECT_THAT(Names(sleeper.Choose()), ElementsAre("a"));
  clock_.Advance(std::chrono::seconds(20));
  EXPECT_THAT(Names(sleeper.Choose()), ElementsAre("a", "b"));
  for (const auto& session : sleeper.Choose()) session->RequestSleep();
  RunAll();
  EXPECT_THAT(Names(sleeper.Choose()), IsEmpty());
}

// Goal: beyond the limit some room is made, so that the next session that grows needs no choice.
TEST_F(SleeperTest, FreesAShareOfTheLimitBesides) {
  const std::int64_t one = MemoryOfOne();
  Sleeper sleeper({.idle_max = {}, .memory_bytes_max = 32 * one}, registry_, clock_);
  for (int i = 0; i < 32; ++i) Create(std::to_string(i), &sleeper.budget());
  EXPECT_THAT(Names(sleeper.Choose()), IsEmpty()) << "at the limit";
  Create("last", &sleeper.budget());
  EXPECT_THAT(Names(sleeper.Choose()), ElementsAre("0", "1", "2")) << "one, and a 16th of 32";
}

// Goal: the limit is that of the process, whatever sessions say: a quarter of it is a margin, and
// what was measured beyond their estimate takes the room of sessions.
TEST_F(SleeperTest, CountsWhatTheProcessHoldsBesides) {
  const std::int64_t one = MemoryOfOne();
  std::int64_t resident = 0;
  Sleeper sleeper(
      {.idle_max = {}, .memory_bytes_max = 32 * one, .resident = [&] { return resident; }},
      registry_, clock_);
  for (int i = 0; i < 10; ++i) Create(std::to_string(i), &sleeper.budget());
  resident = 24 * one;  // Three quarters of the limit; sessions say 10.
  sleeper.Measure();
  EXPECT_THAT(Names(sleeper.Choose()), IsEmpty()) << "at the limit less the margin";
  resident += 2 * one;
  sleeper.Measure();
  const std::vector<std::shared_ptr<Session>> chosen = sleeper.Choose();
  EXPECT_THAT(Names(chosen), ElementsAre("0", "1", "2", "3")) << "two, and a 16th of 32";
  for (const auto& session : chosen) session->RequestSleep();
  RunAll();
  EXPECT_THAT(Names(sleeper.Choose()), IsEmpty()) << "there is room without measuring again";
  resident = 0;  // Nobody can tell.
  sleeper.Measure();
  EXPECT_EQ(sleeper.budget().excess(), 6 * one - 24 * one);
}

TEST_F(SleeperTest, CountsWhatSessionsHold) {
  Sleeper sleeper({}, registry_, clock_);
  const auto session = Create("a", &sleeper.budget());
  const std::int64_t one = sleeper.budget().used();
  EXPECT_GT(one, 0);
  EXPECT_EQ(session->info().memory_bytes, one);
  Create("b", &sleeper.budget());
  EXPECT_EQ(sleeper.budget().used(), 2 * one);
  EXPECT_EQ(sleeper.budget().excess(), 0) << "there is no limit";
  session->RequestSleep();
  RunAll();
  EXPECT_EQ(sleeper.budget().used(), one);
  session->Close({ErrorCode::kSessionNotFound, "gone", {}});
  RunAll();
  EXPECT_EQ(sleeper.budget().used(), one);
}

// Goal: 300 sessions under a limit for about ten: all work, again and again, and the limit is
// kept whenever everybody has done what it could.
TEST_F(SleeperTest, ManySessionsWorkUnderASmallLimit) {
  constexpr int kSessions = 300;
  const std::int64_t one = MemoryOfOne();
  Sleeper sleeper({.idle_max = {}, .memory_bytes_max = 12 * one}, registry_, clock_);
  std::vector<std::shared_ptr<Session>> sessions;
  const auto settle = [&] {
    for (const auto& session : sleeper.Choose()) session->RequestSleep();
    RunAll();
  };
  for (int i = 0; i < kSessions; ++i) {
    clock_.Advance(std::chrono::milliseconds(1));
    sessions.push_back(Create(std::to_string(i), &sleeper.budget()));
    settle();
  }
  for (int round = 0; round < 3; ++round) {
    for (const auto& session : sessions) {
      clock_.Advance(std::chrono::milliseconds(1));
      const auto editor = std::make_shared<FakeEditor>();
      editor->commands = {OpenCommand{.mirror_revision = {}, .mirror = Mirror::kNone},
                          UpdateCommand{.update_id = round + 1, .body = AdvanceSpec{}, .form = {}}};
      ASSERT_TRUE(session->Attach(editor).ok());
      session->Wake();
      RunAll();
      ASSERT_EQ(editor->Log().back(), "advanced " + std::to_string(round + 1));
      ASSERT_EQ(session->info().revision, Revision(round + 1)) << session->session_id();
      session->Detach(editor.get());
      settle();
      ASSERT_LE(sleeper.budget().excess(), 0);
    }
  }
}

}  // namespace
}  // namespace pliant::server
