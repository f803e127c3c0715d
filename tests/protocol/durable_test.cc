// Goal: the promise "Durable" and what follows from it: a session that was stored goes on as if its
// server had not stopped. tests/crash kills real servers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/protocol/follow.h"
#include "tests/protocol/same_message.h"
#include "tests/protocol/updates.h"
#include "tests/support/in_process_server.h"
#include "tests/support/mirror.h"
#include "tests/support/subscribe_client.h"
#include "tests/support/temporary_folder.h"

namespace pliant::test {
namespace {

constexpr const char* kDurable =
    "A revision that was acknowledged to me survives a crash of the server.";

// A session on a server that may be stopped and started again, and its mirror.
class Client {
 public:
  // @param directory  empty: in memory only
  explicit Client(const std::string& directory, v1::CreateSession create) : directory_(directory) {
    Start();
    create.set_session_id("s");
    EXPECT_TRUE(server_->Create(create, nullptr).ok());
    Open();
  }

  void Restart() {
    edit_.reset();
    server_.reset();
    Start();
    Open();
  }

  /// Sends an update and gives its answer, without what is different on every run.
  v1::EditResponse Do(v1::EditRequest request) {
    request.set_update_id(++update_id);
    return Repeat(request);
  }
  /// The same with a number that was used before.
  v1::EditResponse Repeat(const v1::EditRequest& request) {
    edit_->Send(request);
    v1::EditResponse answer;
    for (v1::EditResponse& response : edit_->Until(request.update_id())) {
      if (response.has_diff()) {
        EXPECT_EQ(mirror.Apply(response.diff()), "") << kDurable;
        last_diff = response.diff();
      }
      answer = std::move(response);
    }
    return WithoutTimes(std::move(answer));
  }
  v1::Session Info() {
    grpc::ClientContext context;
    v1::GetSessionRequest request;
    request.set_session_id("s");
    v1::GetSessionResponse response;
    EXPECT_TRUE(server_->sessions->GetSession(&context, request, &response).ok());
    return response.session();
  }
  InProcessServer& server() { return *server_; }

  Mirror mirror;
  v1::MeshDiff last_diff;
  v1::EditResponse opened;
  std::int64_t update_id = 0;

 private:
  void Start() {
    server::Config config;
    config.data = directory_;
    server_ = std::make_unique<InProcessServer>(server::RemesherFactory(), config);
  }
  void Open() {
    edit_ = std::make_unique<EditClient>(
        *server_, "s", mirror.revision,
        std::vector<v1::MeshPart>{v1::MESH_PART_TRANSFER, v1::MESH_PART_FIELDS,
                                  v1::MESH_PART_METRIC});
    opened = edit_->Next();
    EXPECT_TRUE(opened.has_opened());
  }

  const std::string directory_;
  std::unique_ptr<InProcessServer> server_;
  std::unique_ptr<EditClient> edit_;
};

// What a client does next; it may look at its mirror.
using Step = std::function<v1::EditRequest(const Mirror&)>;

std::vector<Step> Script() {
  const auto fixed = [](v1::EditRequest request) {
    return [request](const Mirror&) { return request; };
  };
  return {fixed(Size("0.07")),
          fixed(Advance()),
          fixed(Size("0.05 + 0.1*x")),
          fixed(Size("-1")),  // Refused: the next advance is, too.
          fixed(Advance()),
          fixed(Size("0.05 + 0.1*x")),
          fixed(Advance(200)),  // Not converged.
          fixed(Advance()),
          [](const Mirror& mirror) { return Tensors(mirror, 900); },
          fixed(Advance()),
          [](const Mirror& mirror) { return Field(mirror, 2); },
          fixed(Advance()),
          [](const Mirror& mirror) { return Tensors(mirror, 1500); },
          fixed(Discard()),
          fixed(Size("0.06 + 0.1*y")),
          fixed(Advance()),
          fixed(Rollback(4)),
          fixed(Advance()),
          [](const Mirror& mirror) { return Tensors(mirror, 700); },
          [](const Mirror& mirror) { return Field(mirror, 3); },
          fixed(Advance(500)),
          fixed(SquareWithHole()),
          fixed(Advance()),
          [](const Mirror& mirror) { return Displace(mirror, 0.02); },
          fixed(Advance(1)),
          [](const Mirror& mirror) { return DisplaceWithTensors(mirror, 0.02); },
          fixed(Advance(300)),
          fixed(SquareWithoutCorner()),
          [](const Mirror& mirror) { return Displace(mirror, -0.01); },
          fixed(Size("0.06 + 0.1*y")),
          fixed(Advance()),
          [](const Mirror& mirror) { return Freeze(mirror); },
          fixed(Hops(4)),
          fixed(Size("0.05 + 0.1*y")),
          fixed(Advance()),
          fixed(Rollback(5)),
          fixed(Size("0.04 + 0.1*x")),
          fixed(Advance())};
}

// Method: the same script for two sessions, of which one's server is stopped and started after
// every step, also with updates staged. Answers, diffs (transfer rows, metric and fields included)
// and meshes must be the same to the bit, which they are only if everything that decides is.
TEST(Durable, ASessionGoesOnAsIfItsServerHadNotStopped) {
  const TemporaryFolder folder;
  Client steady("", UnitSquare("0.1"));
  Client stopped(folder.path(), UnitSquare("0.1"));
  int number = 0;
  for (const Step& step : Script()) {
    SCOPED_TRACE(testing::Message() << "step " << ++number);
    const v1::EditResponse expected = steady.Do(step(steady.mirror));
    const v1::EditResponse found = stopped.Do(step(stopped.mirror));
    ExpectSame(expected, found, kDurable);
    ExpectSame(steady.last_diff, stopped.last_diff, kDurable);
    ASSERT_TRUE(steady.mirror == stopped.mirror) << kDurable;

    v1::Session before = stopped.Info();
    stopped.Restart();
    EXPECT_EQ(stopped.opened.opened().last_update_id(), stopped.update_id) << kDurable;
    v1::Session after = stopped.Info();
    // Asleep or not, and how its memory is shared, are the server's affairs.
    for (v1::Session* session : {&before, &after}) {
      session->clear_state();
      session->clear_memory_bytes();
    }
    ExpectSame(before, after, kDurable);
    if (found.has_accepted()) {
      EXPECT_EQ(stopped.opened.opened().staged_count(), found.accepted().staged_count());
    }
  }
  EXPECT_GT(stopped.mirror.revision, 8);
}

// Goal: what was answered is answered again and not applied again, also after a restart.
TEST(Durable, ARepeatedUpdateGetsItsFirstAnswer) {
  const TemporaryFolder folder;
  Client client(folder.path(), UnitSquare("0.1"));
  const v1::EditResponse first = client.Do(Advance());
  const v1::EditResponse refused = client.Do(Size("-1"));
  const v1::EditResponse rejected = client.Do(Advance());
  client.Restart();
  v1::EditRequest again = Advance();
  again.set_update_id(1);
  ExpectSame(first, client.Repeat(again), kDurable);
  again.set_update_id(3);
  ExpectSame(rejected, client.Repeat(again), kDurable);
  EXPECT_EQ(client.Info().revision(), 1) << kDurable;
  EXPECT_TRUE(refused.has_rejected());
}

// Goal: what was answered is not the answer to another update under its number, also after a
// restart; neither is what the refused one was a part of committed.
TEST(Durable, AnotherUpdateUnderAUsedNumberIsRefused) {
  const TemporaryFolder folder;
  Client client(folder.path(), UnitSquare("0.1"));
  client.Do(Advance());
  v1::EditRequest size = Size("0.07");
  const v1::EditResponse accepted = client.Do(size);
  client.Do(Advance(200));
  client.Restart();
  size.set_update_id(2);
  ExpectSame(accepted, client.Repeat(size), kDurable);
  v1::EditRequest other = Size("0.08");
  other.set_update_id(2);
  EXPECT_EQ(client.Repeat(other).rejected().error().reason(), "PROTOCOL_ORDER");
  client.Restart();
  EXPECT_EQ(client.Do(Advance()).rejected().error().reason(), "UPDATE_REJECTED");
  other = Advance(100);
  other.set_update_id(3);
  EXPECT_EQ(client.Repeat(other).rejected().error().reason(), "PROTOCOL_ORDER");
  EXPECT_EQ(client.Info().revision(), 2);
  EXPECT_TRUE(client.Do(Advance()).has_advanced());
}

// Goal: saved revisions and the window for resuming are there again.
TEST(Durable, SavedRevisionsAndTheHistoryAreKept) {
  const TemporaryFolder folder;
  Client client(folder.path(), UnitSquare("0.1"));
  client.Do(Advance());
  const Mirror first = client.mirror;
  grpc::ClientContext context;
  v1::SaveRevisionRequest save;
  save.set_session_id("s");
  v1::SaveRevisionResponse saved;
  ASSERT_TRUE(client.server().sessions->SaveRevision(&context, save, &saved).ok());
  for (const char* size : {"0.08", "0.09", "0.07"}) {
    client.Do(Size(size));
    client.Do(Advance());
  }
  client.Restart();
  EXPECT_THAT(client.Info().saved_revisions(), testing::ElementsAre(1)) << kDurable;
  SubscribeClient reader(client.server(), "s", first.revision);
  Mirror follower = first;
  EXPECT_EQ(reader.Follow(follower, client.mirror.revision), "") << "by a diff, not a snapshot";
  EXPECT_TRUE(follower == client.mirror);
  client.Do(Rollback(1));
  EXPECT_EQ(client.mirror.vertices, first.vertices) << kDurable;
  EXPECT_EQ(client.mirror.triangles, first.triangles) << kDurable;
}

TEST(Durable, AForkIsASessionOfItsOwn) {
  const TemporaryFolder folder;
  Client client(folder.path(), UnitSquare("0.1"));
  client.Do(Advance());
  client.Do(Size("0.08"));
  client.Do(Advance());
  grpc::ClientContext context;
  v1::ForkRequest request;
  request.set_session_id("s");
  request.set_revision(1);
  request.set_new_session_id("fork");
  v1::ForkResponse response;
  ASSERT_TRUE(client.server().sessions->Fork(&context, request, &response).ok());
  EXPECT_EQ(response.session().revision(), 1);
  client.Restart();
  v1::GetMeshRequest get;
  get.set_session_id("fork");
  v1::MeshSnapshot snapshot;
  ASSERT_TRUE(client.server().GetMesh(get, &snapshot).ok());
  Mirror mirror;
  EXPECT_EQ(mirror.Take(snapshot), "");
  EXPECT_EQ(mirror.Hash(), response.session().state_hash()) << kDurable;
}

TEST(Durable, ADeletedSessionStaysDeletedAndItsNameIsFree) {
  const TemporaryFolder folder;
  Client client(folder.path(), UnitSquare("0.1"));
  client.Do(Advance());
  const auto remove = [&] {
    grpc::ClientContext context;
    v1::DeleteSessionRequest request;
    request.set_session_id("s");
    v1::DeleteSessionResponse response;
    return client.server().sessions->DeleteSession(&context, request, &response);
  };
  EXPECT_TRUE(remove().ok());
  EXPECT_EQ(ReasonOf(remove()), "SESSION_NOT_FOUND");
  v1::CreateSession create = UnitSquare("0.3");
  create.set_session_id("s");
  EXPECT_TRUE(client.server().Create(create, nullptr).ok());
  EXPECT_EQ(client.Info().revision(), 0);
}

// Goal: a server that keeps nothing says so when somebody counts on it.
TEST(Durable, WithoutAStoreNobodyIsPromisedOne) {
  InProcessServer server;
  v1::CreateSession create = UnitSquare("0.3");
  create.mutable_options()->set_durability(v1::DURABILITY_STRICT);
  EXPECT_EQ(ReasonOf(server.Create(create, nullptr)), "UNIMPLEMENTED");
  create.mutable_options()->set_durability(v1::DURABILITY_NONE);
  EXPECT_TRUE(server.Create(create, nullptr).ok());
}

// Goal: a session that nobody wanted kept is gone with the server; others are not.
TEST(Durable, DurabilityIsEachSessionsOwn) {
  const TemporaryFolder folder;
  server::Config config;
  config.data = folder.path();
  {
    InProcessServer server(server::RemesherFactory(), config);
    for (const v1::Durability durability :
         {v1::DURABILITY_NONE, v1::DURABILITY_RELAXED, v1::DURABILITY_STRICT}) {
      v1::CreateSession create = UnitSquare("0.2");
      const std::string id = "s" + std::to_string(durability);
      create.set_session_id(id);
      create.mutable_options()->set_durability(durability);
      ASSERT_TRUE(server.Create(create, nullptr).ok());
      EditClient edit(server, id);
      edit.Advance(1);
      const v1::AdvanceResult result = edit.Until(1).back().advanced();
      EXPECT_EQ(result.has_durable_revision(), durability != v1::DURABILITY_NONE);
      if (durability == v1::DURABILITY_STRICT) {
        EXPECT_EQ(result.durable_revision(), 1);
      }
    }
  }
  InProcessServer server(server::RemesherFactory(), config);
  grpc::ClientContext context;
  v1::ListSessionsResponse list;
  ASSERT_TRUE(server.sessions->ListSessions(&context, {}, &list).ok());
  ASSERT_EQ(list.sessions_size(), 2);
  EXPECT_EQ(list.sessions(0).session_id(), "s2");
  for (const v1::Session& session : list.sessions()) {
    EXPECT_EQ(session.revision(), 1);
    EXPECT_EQ(session.state(), v1::SESSION_STATE_ASLEEP) << "loaded when it is needed";
  }
}

}  // namespace
}  // namespace pliant::test
