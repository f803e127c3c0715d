// Goal: Subscribe over a real connection: what comes first, what a slow reader gets, how it ends,
// and what it costs the server.
#include "server/subscribe_stream.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "server/limits.h"
#include "tests/support/in_process_server.h"
#include "tests/support/mirror.h"
#include "tests/support/subscribe_client.h"

namespace pliant::test {
namespace {

void AdvanceTo(EditClient& edit, std::int64_t update_id, const std::string& size) {
  edit.Size(update_id, size);
  edit.Advance(update_id + 1);
  ASSERT_TRUE(edit.Until(update_id + 1).back().has_advanced());
}

class SubscribeTest : public testing::Test {
 protected:
  void SetUp() override {
    server::Config config;
    config.bookmark_ms = 50;
    server = std::make_unique<InProcessServer>(server::RemesherFactory(), config);
    ASSERT_TRUE(server->Create(UnitSquare("0.1"), &id).ok());
    edit = std::make_unique<EditClient>(*server, id);
  }

  std::unique_ptr<InProcessServer> server;
  std::string id;
  std::unique_ptr<EditClient> edit;
};

TEST_F(SubscribeTest, SnapshotThenLiveDiffsThenBookmarks) {
  SubscribeClient early(*server, id);
  EXPECT_TRUE(early.Next().has_bookmark()) << "there is no mesh yet";
  edit->Advance(1);
  ASSERT_TRUE(edit->Until(1).back().has_advanced());
  Mirror mirror;
  EXPECT_EQ(early.Follow(mirror, 1), "");
  SubscribeClient late(*server, id);
  Mirror other;
  EXPECT_TRUE(late.Next(&other).has_snapshot());
  for (std::int64_t update = 2; update < 10; update += 2) {
    AdvanceTo(*edit, update, update % 4 == 0 ? "0.1" : "0.08");
    const std::int64_t revision = 1 + update / 2;
    EXPECT_EQ(early.Follow(mirror, revision), "");
    EXPECT_EQ(late.Follow(other, revision), "");
    EXPECT_TRUE(mirror == other);
  }
  const v1::SubscribeResponse quiet = early.Next();
  EXPECT_TRUE(quiet.has_bookmark());
  EXPECT_EQ(quiet.revision(), 5);

  SubscribeClient resumed(*server, id, 3);
  EXPECT_TRUE(resumed.Next().has_diff());
  SubscribeClient current(*server, id, 5);
  EXPECT_TRUE(current.Next().has_bookmark());
}

TEST_F(SubscribeTest, EndsWithTheSessionAndWithTheServer) {
  SubscribeClient nobody(*server, "none");
  EXPECT_EQ(ReasonOf(nobody.End()), "SESSION_NOT_FOUND");
  SubscribeClient deleted(*server, id);
  deleted.Next();
  grpc::ClientContext context;
  v1::DeleteSessionRequest request;
  request.set_session_id(id);
  v1::DeleteSessionResponse response;
  ASSERT_TRUE(server->sessions->DeleteSession(&context, request, &response).ok());
  EXPECT_EQ(ReasonOf(deleted.End()), "SESSION_NOT_FOUND");
  EXPECT_TRUE(deleted.saw_closing);

  ASSERT_TRUE(server->Create(UnitSquare("0.1"), &id).ok());
  SubscribeClient closed(*server, id);
  closed.Next();
  server->server().Shutdown();
  EXPECT_EQ(ReasonOf(closed.End()), "UNAVAILABLE");
}

// Goal: the reason comes behind what is on its way.
// Method: a reader that has not read a mesh larger than the window of its stream when its session
// is deleted; another one, who comes after it, has read the same.
TEST_F(SubscribeTest, SaysWhyItEndsAlsoBehindWhatIsUnread) {
  SubscribeClient slow(*server, id);
  SubscribeClient prompt(*server, id);
  EXPECT_TRUE(slow.Next().has_bookmark());
  EXPECT_TRUE(prompt.Next().has_bookmark());
  ASSERT_NO_FATAL_FAILURE(AdvanceTo(*edit, 1, "0.004"));
  Mirror mirror;
  ASSERT_EQ(prompt.Follow(mirror, 1), "");
  grpc::ClientContext context;
  v1::DeleteSessionRequest request;
  request.set_session_id(id);
  v1::DeleteSessionResponse response;
  ASSERT_TRUE(server->sessions->DeleteSession(&context, request, &response).ok());
  EXPECT_EQ(ReasonOf(slow.End()), "SESSION_NOT_FOUND");
  EXPECT_TRUE(slow.saw_closing);
}

// Goal: who asks for less than the whole mesh gets that, and proves it. The square has one region,
// 0, so that a filter by it lets all through and one by another nothing; mesh_view_test has more.
TEST_F(SubscribeTest, GivesPartsOfTheMesh) {
  v1::SubscribeRequest positions;
  positions.set_mirror_mode(v1::MIRROR_MODE_POSITIONS);
  v1::SubscribeRequest all;
  all.add_region_tags(0);
  v1::SubscribeRequest nothing;
  nothing.add_region_tags(5);
  v1::SubscribeRequest none;
  none.set_mirror_mode(v1::MIRROR_MODE_NONE);
  edit->Advance(1);
  ASSERT_TRUE(edit->Until(1).back().has_advanced());
  SubscribeClient whole_client(*server, id);
  SubscribeClient positions_client(*server, id, 1, positions);
  SubscribeClient all_client(*server, id, 0, all);
  SubscribeClient nothing_client(*server, id, 0, nothing);
  SubscribeClient none_client(*server, id, 0, none);
  Mirror whole;
  Mirror points;
  Mirror filtered;
  Mirror empty;
  EXPECT_TRUE(positions_client.Next(&points).has_snapshot()) << "though it said that it has one";
  EXPECT_TRUE(none_client.Next().has_bookmark());
  for (std::int64_t update = 2; update < 8; update += 2) {
    const std::int64_t revision = 1 + update / 2;
    AdvanceTo(*edit, update, update % 4 == 0 ? "0.1" : "0.08");
    ASSERT_EQ(whole_client.Follow(whole, revision), "");
    ASSERT_EQ(positions_client.Follow(points, revision), "");
    ASSERT_EQ(all_client.Follow(filtered, revision), "");
    ASSERT_EQ(nothing_client.Follow(empty, revision), "");
    EXPECT_EQ(points.vertices, whole.vertices);
    EXPECT_TRUE(points.triangles.empty() && points.edges.empty());
    EXPECT_TRUE(filtered == whole);
    EXPECT_TRUE(empty.vertices.empty() && empty.triangles.empty() && empty.edges.empty());
    v1::SubscribeResponse told;
    do {
      told = none_client.Next();
      ASSERT_TRUE(told.has_bookmark());
    } while (told.revision() < revision);
  }
}

// Goal: with dense numbers every revision is a whole mesh whose corners are rows.
TEST_F(SubscribeTest, GivesDenseNumbers) {
  v1::SubscribeRequest request;
  request.set_numbering(v1::NUMBERING_DENSE);
  edit->Advance(1);
  ASSERT_TRUE(edit->Until(1).back().has_advanced());
  SubscribeClient stable(*server, id);
  SubscribeClient dense(*server, id, 0, request);
  Mirror mirror;
  for (std::int64_t update = 2; update < 8; update += 2) {
    const std::int64_t revision = 1 + update / 2;
    AdvanceTo(*edit, update, update % 4 == 0 ? "0.07" : "0.15");
    ASSERT_EQ(stable.Follow(mirror, revision), "");
    v1::SubscribeResponse response;
    while (response.revision() < revision) response = dense.Next();
    ASSERT_TRUE(response.has_snapshot());
    v1::MeshSnapshot& snapshot = *response.mutable_snapshot();
    EXPECT_EQ(snapshot.numbering(), v1::NUMBERING_DENSE);
    const auto slots = NumbersOf<std::int32_t>(snapshot.vertex_ids());
    const auto to_slots = [&](v1::Array& rows, std::int64_t columns) {
      auto numbers = NumbersOf<std::int32_t>(rows);
      for (std::int32_t& number : numbers) number = slots.at(static_cast<std::size_t>(number));
      rows = Ints(numbers, columns);
    };
    to_slots(*snapshot.mutable_triangle_vertices(), 3);
    to_slots(*snapshot.mutable_edge_vertices(), 2);
    Mirror other;
    EXPECT_EQ(other.Take(snapshot), "");
    EXPECT_TRUE(other == mirror);
  }
}

// Goal: a reader that stops costs bounded memory and slows nobody.
// Method: it reads nothing while many large diffs pass; what it gets then is few messages, not one
// for each revision, and its mirror is right.
TEST_F(SubscribeTest, AReaderThatStopsGetsMergedDiffs) {
  edit->Advance(1);
  ASSERT_TRUE(edit->Until(1).back().has_advanced());
  SubscribeClient slow(*server, id);
  SubscribeClient quick(*server, id);
  Mirror mirror;
  std::int64_t update = 0;
  constexpr int kRevisions = 60;
  for (int i = 0; i < kRevisions; ++i) {
    update += 2;
    AdvanceTo(*edit, update, i % 2 == 0 ? "0.02" : "0.025");
    ASSERT_EQ(quick.Follow(mirror, 2 + i), "");
  }
  Mirror behind;
  int diffs = 0;
  while (behind.revision < 1 + kRevisions) {
    const bool is_bookmark = slow.Next(&behind).has_bookmark();  // While a slow machine remeshes.
    ASSERT_EQ(slow.wrong, "");
    if (!is_bookmark) ++diffs;
  }
  EXPECT_TRUE(behind == mirror);
  // gRPC itself holds what its windows take; the rest is merged.
  EXPECT_LT(diffs, kRevisions);
}

}  // namespace
}  // namespace pliant::test
