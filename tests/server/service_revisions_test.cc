// Goal: revisions over a real connection: going back is bit for bit, also for what comes after;
// saved ones stay; a fork is a session of its own; the editor and subscribers are told.
#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "server/limits.h"
#include "tests/support/files.h"
#include "tests/support/in_process_server.h"
#include "tests/support/mirror.h"
#include "tests/support/subscribe_client.h"

namespace pliant::test {
namespace {

class RevisionsTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(server.Create(UnitSquare("0.1"), &id).ok());
    edit = std::make_unique<EditClient>(server, id);
    AdvanceTo("0.1");
  }

  // One update and an advance, applied to the mirror. @return the state hash.
  std::uint64_t AdvanceTo(const std::string& size) {
    return AdvanceTo(size, *edit, mirror, update);
  }
  static std::uint64_t AdvanceTo(const std::string& size, EditClient& client, Mirror& copy,
                                 std::int64_t& last_update) {
    client.Size(++last_update, size);
    client.Advance(++last_update);
    return Follow(client, last_update, copy).advanced().state_hash();
  }
  static v1::EditResponse Follow(EditClient& client, std::int64_t until, Mirror& copy) {
    v1::EditResponse last;
    for (const v1::EditResponse& response : client.Until(until)) {
      if (response.has_diff()) {
        EXPECT_EQ(copy.Apply(response.diff()), "");
      }
      last = response;
    }
    return last;
  }
  v1::EditResponse Rollback(std::int64_t revision) {
    v1::EditRequest request;
    request.set_update_id(++update);
    request.mutable_rollback()->set_to_revision(revision);
    edit->Send(request);
    return Follow(*edit, update, mirror);
  }
  grpc::Status Save(std::int64_t revision) {
    grpc::ClientContext context;
    v1::SaveRevisionRequest request;
    request.set_session_id(id);
    request.set_revision(revision);
    v1::SaveRevisionResponse response;
    return server.sessions->SaveRevision(&context, request, &response);
  }
  grpc::Status Fork(std::int64_t revision, const std::string& new_id) {
    grpc::ClientContext context;
    v1::ForkRequest request;
    request.set_session_id(id);
    request.set_revision(revision);
    request.set_new_session_id(new_id);
    v1::ForkResponse response;
    const grpc::Status status = server.sessions->Fork(&context, request, &response);
    if (status.ok()) {
      EXPECT_EQ(response.session().session_id(), new_id);
    }
    return status;
  }

  InProcessServer server;
  std::string id;
  std::unique_ptr<EditClient> edit;
  Mirror mirror;
  std::int64_t update = 0;
};

TEST_F(RevisionsTest, GoingBackIsBitForBitAndSoIsWhatFollows) {
  SubscribeClient follower(server, id);
  Mirror followed;
  const std::uint64_t at2 = AdvanceTo("0.06");
  const std::uint64_t at3 = AdvanceTo("0.08");
  const std::uint64_t at4 = AdvanceTo("0.05");
  const v1::EditResponse back = Rollback(2);
  ASSERT_TRUE(back.has_advanced()) << back.rejected().error().message();
  EXPECT_EQ(back.advanced().base_revision(), 4);
  EXPECT_EQ(back.advanced().revision(), 5);
  EXPECT_EQ(back.advanced().stop_reason(), v1::STOP_REASON_CONVERGED);
  EXPECT_EQ(back.advanced().state_hash(), at2);
  EXPECT_EQ(mirror.Hash(), at2);
  EXPECT_EQ(AdvanceTo("0.08"), at3);
  EXPECT_EQ(AdvanceTo("0.05"), at4);
  // Back over the rollback itself, to before it.
  EXPECT_EQ(Rollback(4).advanced().state_hash(), at4);
  EXPECT_EQ(Rollback(5).advanced().state_hash(), at2);
  EXPECT_EQ(follower.Follow(followed, mirror.revision), "");
  EXPECT_TRUE(followed == mirror);
}

// Goal: a session keeps as much as its creator asked for; forks and imported sessions do too, and
// all of them say so.
TEST_F(RevisionsTest, KeepsAsMuchHistoryAsWasAskedFor) {
  v1::CreateSession create = UnitSquare("0.1");
  create.mutable_options()->set_history_bytes_max(0);
  ASSERT_TRUE(server.Create(create, &id).ok());
  edit = std::make_unique<EditClient>(server, id);
  mirror = {};
  update = 0;
  AdvanceTo("0.1");
  ASSERT_TRUE(Save(1).ok());
  AdvanceTo("0.08");
  AdvanceTo("0.06");
  EXPECT_EQ(Rollback(2).rejected().error().reason(), "REVISION_NOT_FOUND");
  EXPECT_TRUE(Rollback(1).has_advanced()) << "it is saved, which costs what it costs";
  ASSERT_TRUE(Fork(0, "fork").ok());
  v1::Session imported;
  ASSERT_TRUE(ImportFile(server, ExportFile(server, id), "import", &imported).ok());
  EXPECT_TRUE(imported.has_history_bytes_max());
  for (const std::string& name : {id, std::string("fork"), std::string("import")}) {
    grpc::ClientContext context;
    v1::GetSessionRequest request;
    request.set_session_id(name);
    v1::GetSessionResponse response;
    ASSERT_TRUE(server.sessions->GetSession(&context, request, &response).ok());
    EXPECT_TRUE(response.session().has_history_bytes_max()) << name;
    EXPECT_EQ(response.session().history_bytes_max(), 0);
  }
}

TEST_F(RevisionsTest, RefusesWhatIsNotKeptAndWhileSomethingIsStaged) {
  AdvanceTo("0.06");
  v1::EditResponse refused = Rollback(7);
  EXPECT_EQ(refused.rejected().error().reason(), "REVISION_NOT_FOUND");
  EXPECT_NE(refused.rejected().error().message().find("oldest"), std::string::npos);
  edit->Size(++update, "0.1");
  edit->Until(update);
  refused = Rollback(1);
  EXPECT_EQ(refused.rejected().error().reason(), "PROTOCOL_ORDER");
  EXPECT_EQ(ReasonOf(Save(9)), "REVISION_NOT_FOUND");
  EXPECT_EQ(ReasonOf(Fork(9, "f")), "REVISION_NOT_FOUND");
}

TEST_F(RevisionsTest, ACallGoesBackOnceAndTellsTheEditor) {
  const std::uint64_t first = mirror.Hash();
  AdvanceTo("0.06");
  v1::RollbackToRequest request;
  request.set_session_id(id);
  request.set_to_revision(1);
  v1::RollbackToResponse response;
  {
    grpc::ClientContext context;
    EXPECT_EQ(ReasonOf(server.sessions->RollbackTo(&context, request, &response)),
              "PROTOCOL_ORDER");
  }
  request.set_update_id(++update);
  for (int i = 0; i < 2; ++i) {
    grpc::ClientContext context;
    ASSERT_TRUE(server.sessions->RollbackTo(&context, request, &response).ok());
    EXPECT_EQ(response.revision(), 3);
    EXPECT_EQ(response.state_hash(), first);
  }
  const v1::EditResponse told = edit->Next();
  ASSERT_TRUE(told.has_diff());
  EXPECT_EQ(mirror.Apply(told.diff()), "");
  EXPECT_EQ(mirror.Hash(), first);
}

// Goal: a call and an editor that take the same number do not get each other's answers.
TEST_F(RevisionsTest, ACallAndAnEditorUnderOneNumber) {
  AdvanceTo("0.06");
  const auto roll_back = [&](std::int64_t to_revision, std::int64_t update_id) {
    grpc::ClientContext context;
    v1::RollbackToRequest request;
    request.set_session_id(id);
    request.set_to_revision(to_revision);
    request.set_update_id(update_id);
    v1::RollbackToResponse response;
    const grpc::Status status = server.sessions->RollbackTo(&context, request, &response);
    return status.ok() ? "revision " + std::to_string(response.revision()) : ReasonOf(status);
  };
  EXPECT_EQ(roll_back(1, update), "PROTOCOL_ORDER") << "the number of an advance";
  EXPECT_EQ(roll_back(1, INT64_MAX), "OUT_OF_RANGE") << "no number would be left";
  EXPECT_EQ(roll_back(1, update + 1), "revision 3");
  EXPECT_EQ(roll_back(1, update + 1), "revision 3");
  EXPECT_EQ(roll_back(2, update + 1), "PROTOCOL_ORDER") << "another revision";

  // The editor does not know of it, and takes the next number that it knows.
  edit->Size(update + 1, "0.05");
  edit->Advance(update + 2);
  const v1::EditResponse metric = edit->Until(update + 1).back();
  EXPECT_EQ(metric.rejected().error().reason(), "PROTOCOL_ORDER");
  EXPECT_NE(metric.rejected().error().message().find("a rollback"), std::string::npos)
      << metric.rejected().error().message();
  EXPECT_EQ(edit->Until(update + 2).back().rejected().error().reason(), "UPDATE_REJECTED")
      << "nothing is committed without what was refused";
  v1::EditRequest same;
  same.set_update_id(update + 1);
  same.mutable_rollback()->set_to_revision(1);
  edit->Send(same);
  EXPECT_EQ(edit->Until(update + 1).back().advanced().revision(), 3) << "it says the same";
}

TEST_F(RevisionsTest, SavedOnesAreListedAndReleased) {
  AdvanceTo("0.06");
  EXPECT_TRUE(Save(0).ok());
  EXPECT_TRUE(Save(1).ok());
  const auto saved = [&] {
    grpc::ClientContext context;
    v1::GetSessionRequest request;
    request.set_session_id(id);
    v1::GetSessionResponse response;
    EXPECT_TRUE(server.sessions->GetSession(&context, request, &response).ok());
    return std::vector<std::int64_t>(response.session().saved_revisions().begin(),
                                     response.session().saved_revisions().end());
  };
  EXPECT_EQ(saved(), (std::vector<std::int64_t>{1, 2}));
  v1::ReleaseRequest request;
  request.set_session_id(id);
  request.add_revisions(2);
  request.add_revisions(5);
  {
    grpc::ClientContext context;
    v1::ReleaseResponse response;
    EXPECT_EQ(ReasonOf(server.sessions->Release(&context, request, &response)),
              "REVISION_NOT_FOUND");
  }
  EXPECT_EQ(saved().size(), 2U);
  request.set_revisions(1, 1);
  grpc::ClientContext context;
  v1::ReleaseResponse response;
  EXPECT_TRUE(server.sessions->Release(&context, request, &response).ok());
  EXPECT_TRUE(saved().empty());
}

TEST_F(RevisionsTest, AForkIsASessionOfItsOwn) {
  const std::uint64_t at2 = AdvanceTo("0.06");
  const std::uint64_t at3 = AdvanceTo("0.08");
  ASSERT_TRUE(Fork(2, "past").ok());
  ASSERT_TRUE(Fork(0, "present").ok());
  EXPECT_EQ(ReasonOf(Fork(0, "past")), "SESSION_EXISTS");
  Mirror copy;
  EditClient past(server, "past");
  EXPECT_EQ(past.Next().revision(), 2);
  EXPECT_EQ(copy.Take(past.Next().snapshot()), "");
  EXPECT_EQ(copy.Hash(), at2);
  std::int64_t last_update = 0;
  EXPECT_EQ(AdvanceTo("0.08", past, copy, last_update), at3);
  EditClient present(server, "present");
  EXPECT_EQ(present.Next().revision(), 3);
  EXPECT_EQ(present.Next().snapshot().state_hash(), at3);
  EXPECT_EQ(Rollback(1).advanced().revision(), 4) << "the first session goes on by itself";
}

}  // namespace
}  // namespace pliant::test
