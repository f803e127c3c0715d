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
  int messages = 0;
  while (behind.revision < 1 + kRevisions) {
    slow.Next(&behind);
    ASSERT_EQ(slow.wrong, "");
    ++messages;
  }
  EXPECT_TRUE(behind == mirror);
  // gRPC itself holds what its windows take; the rest is merged.
  EXPECT_LT(messages, kRevisions);
}

}  // namespace
}  // namespace pliant::test
