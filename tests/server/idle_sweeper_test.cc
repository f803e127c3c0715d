#include "server/idle_sweeper.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "tests/support/session_harness.h"

namespace pliant::server {
namespace {

using std::chrono::seconds;

// A registry with one session, and a sweeper that ends those that rest for 10 s. The clock stands
// still unless it is told, so the sweeper's own looks change nothing.
struct Fixture {
  Fixture() {
    EXPECT_TRUE(registry.Reserve("t", "s1").ok());
    registry.Publish("t", harness.session);
  }
  bool Exists() { return registry.Find("t", "s1").ok(); }

  SessionHarness harness;
  SessionRegistry registry{{10, 10}, /*seed=*/1};
  IdleSweeper sweeper{registry, harness.clock, harness.log, seconds(10)};
};

// At the bound and one past it.
TEST(IdleSweeper, EndsASessionThatNobodyUsed) {
  Fixture f;
  f.harness.clock.Advance(seconds(10) - std::chrono::nanoseconds(1));
  EXPECT_EQ(f.sweeper.Sweep(), 0U);
  EXPECT_TRUE(f.Exists());
  f.harness.clock.Advance(std::chrono::nanoseconds(1));
  f.sweeper.Sweep();
  EXPECT_FALSE(f.Exists());
  const auto editor = std::make_shared<FakeEditor>();
  const Status attached = f.harness.session->Attach(editor);
  ASSERT_FALSE(attached.ok());
  EXPECT_EQ(attached.error().code, ErrorCode::kSessionNotFound);
  EXPECT_NE(attached.error().message.find("10 s"), std::string::npos);
}

TEST(IdleSweeper, LeavesOneThatIsHeldOrWasUsed) {
  Fixture f;
  const auto editor = std::make_shared<FakeEditor>();
  ASSERT_TRUE(f.harness.session->Attach(editor).ok());
  f.harness.clock.Advance(seconds(100));
  f.sweeper.Sweep();
  EXPECT_TRUE(f.Exists()) << "it has an editor";
  f.harness.session->Detach(editor.get());
  f.sweeper.Sweep();
  EXPECT_TRUE(f.Exists()) << "its rest begins when the editor leaves";
  f.harness.clock.Advance(seconds(9));
  ASSERT_TRUE(f.harness.session->Post([](const Result<const CommittedState*>&) {}).ok());
  f.harness.clock.Advance(seconds(100));
  f.sweeper.Sweep();
  EXPECT_TRUE(f.Exists()) << "a call waits";
  f.harness.RunAll();
  f.sweeper.Sweep();
  EXPECT_FALSE(f.Exists());
}

}  // namespace
}  // namespace pliant::server
