#include "server/followers.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/fake_server_parts.h"

namespace pliant::server {
namespace {

// Vertex 0 at x = revision.
std::shared_ptr<const MeshDiff> Diff(std::int64_t base, std::int64_t revision) {
  MeshDiff diff;
  diff.base_revision = Revision(base);
  diff.revision = Revision(revision);
  diff.vertex_ids = {VertexId(0)};
  diff.vertex_positions = {{static_cast<double>(revision), 0}};
  return std::make_shared<const MeshDiff>(std::move(diff));
}

class FollowersTest : public testing::Test {
 protected:
  void Commit(std::int64_t revision) {
    source.revision = Revision(revision);
    history.Add(Diff(revision - 1, revision));
  }
  bool Serve() { return followers.Serve(source, clock, clock.Now() + std::chrono::hours(1)); }

  ManualClock clock;
  DiffHistory history{1 << 16};
  Followers followers{3};
  int snapshot_count = 0;
  Followers::Source source{.history = &history, .snapshot = [this] {
                             ++snapshot_count;
                             return Diff(0, static_cast<std::int64_t>(source.revision));
                           }};
};

TEST_F(FollowersTest, ANewOneGetsASnapshotTheDiffsSinceOrABookmark) {
  Commit(5);
  Commit(6);
  const auto none = std::make_shared<FakeSubscriber>();
  const auto old = std::make_shared<FakeSubscriber>();
  const auto current = std::make_shared<FakeSubscriber>();
  ASSERT_TRUE(followers.Add(none, Revision(0)).ok());
  ASSERT_TRUE(followers.Add(old, Revision(4)).ok());
  ASSERT_TRUE(followers.Add(current, Revision(6)).ok());
  EXPECT_TRUE(Serve());
  EXPECT_EQ(none->log, std::vector<std::string>{"snapshot 6"});
  EXPECT_EQ(old->log, std::vector<std::string>{"diff 4-6"});
  EXPECT_EQ(current->log, std::vector<std::string>{"bookmark 6"});
  EXPECT_EQ(snapshot_count, 1);
  Serve();
  EXPECT_EQ(old->log.size(), 1U) << "nothing is told twice";
}

// Goal: one who wants no mesh costs none; one whom a diff does not serve gets a snapshot.
TEST_F(FollowersTest, GivesEachWhatItCanUse) {
  const auto listener = std::make_shared<FakeSubscriber>();
  listener->is_listener = true;
  const auto picky = std::make_shared<FakeSubscriber>();
  picky->takes_diffs = false;
  ASSERT_TRUE(followers.Add(listener, Revision(0)).ok());
  Commit(5);
  EXPECT_TRUE(Serve());
  EXPECT_EQ(snapshot_count, 0);
  ASSERT_TRUE(followers.Add(picky, Revision(5)).ok());
  Serve();
  Commit(6);
  EXPECT_TRUE(Serve());
  EXPECT_EQ(listener->log, (std::vector<std::string>{"bookmark 5", "bookmark 6"}));
  EXPECT_EQ(picky->log, (std::vector<std::string>{"bookmark 5", "snapshot 6"}));
  EXPECT_EQ(snapshot_count, 1);
}

TEST_F(FollowersTest, KnowsWhetherAnybodyWantsTransferRows) {
  const auto plain = std::make_shared<FakeSubscriber>();
  const auto keen = std::make_shared<FakeSubscriber>();
  keen->wants_rows = true;
  ASSERT_TRUE(followers.Add(plain, Revision(0)).ok());
  EXPECT_FALSE(followers.AnyWantsTransfer());
  ASSERT_TRUE(followers.Add(keen, Revision(0)).ok());
  EXPECT_TRUE(followers.AnyWantsTransfer());
  followers.Remove(keen.get());
  EXPECT_FALSE(followers.AnyWantsTransfer());
}

// Goal: a slow reader gets merged diffs, and a snapshot when the history is gone; nothing is held
// for it meanwhile.
TEST_F(FollowersTest, ASlowOneGetsMergedDiffsThenASnapshot) {
  const auto slow = std::make_shared<FakeSubscriber>();
  ASSERT_TRUE(followers.Add(slow, Revision(0)).ok());
  Commit(1);
  Serve();
  slow->is_ready = false;
  for (int revision = 2; revision <= 5; ++revision) {
    Commit(revision);
    EXPECT_TRUE(Serve());
  }
  EXPECT_EQ(slow->log.size(), 1U);
  slow->is_ready = true;
  Serve();
  EXPECT_EQ(slow->log.back(), "diff 1-5");
  slow->is_ready = false;
  for (int revision = 6; revision <= 2000; ++revision) Commit(revision);
  EXPECT_LE(history.bytes(), std::size_t{1} << 16);
  slow->is_ready = true;
  Serve();
  EXPECT_EQ(slow->log.back(), "snapshot 2000");
  Commit(2001);
  Serve();
  EXPECT_EQ(slow->log.back(), "diff 2000-2001");
}

TEST_F(FollowersTest, BeforeTheFirstCommitABookmarkComes) {
  const auto early = std::make_shared<FakeSubscriber>();
  ASSERT_TRUE(followers.Add(early, Revision(0)).ok());
  Serve();
  EXPECT_EQ(early->log, std::vector<std::string>{"bookmark 0"});
  Commit(1);
  Serve();
  EXPECT_EQ(early->log.back(), "diff 0-1");
}

TEST_F(FollowersTest, TheNumberIsBounded) {
  std::vector<std::shared_ptr<FakeSubscriber>> all(4);
  for (auto& one : all) one = std::make_shared<FakeSubscriber>();
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(followers.Add(all[i], Revision(0)).ok());
  const Status full = followers.Add(all[3], Revision(0));
  EXPECT_EQ(full.error().code, ErrorCode::kResourceExhausted);
  EXPECT_GT(full.error().retry_after_ms, 0) << "one may leave";
  followers.Remove(all[1].get());
  EXPECT_TRUE(followers.Add(all[3], Revision(0)).ok());
  EXPECT_EQ(followers.count(), 3U);
  followers.CloseAll({ErrorCode::kSessionNotFound, "gone", {}});
  EXPECT_EQ(all[0]->closed->code, ErrorCode::kSessionNotFound);
  EXPECT_FALSE(all[1]->closed.has_value());
  EXPECT_EQ(followers.count(), 0U);
}

// A slice of no time serves one subscriber: the others get their turn in later slices.
TEST_F(FollowersTest, ASliceEndsAndTheNextGoesOn) {
  std::vector<std::shared_ptr<FakeSubscriber>> all(3);
  for (auto& one : all) {
    one = std::make_shared<FakeSubscriber>();
    ASSERT_TRUE(followers.Add(one, Revision(0)).ok());
  }
  Commit(1);
  int slices = 1;
  while (!followers.Serve(source, clock, clock.Now())) ASSERT_LT(++slices, 10);
  EXPECT_EQ(slices, 4);
  for (const auto& one : all) EXPECT_EQ(one->log.size(), 1U);
}

}  // namespace
}  // namespace pliant::server
