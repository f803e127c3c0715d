// Goal: what a session does with its journal: when it answers, sleeps, wakes, and what a failed
// write means.
// Method: the real engine on a scheduler without threads, and a store in memory whose writes end
// when the test says so.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "server/keeper.h"
#include "server/session.h"
#include "server/stored_form.h"
#include "tests/support/fake_server_parts.h"
#include "tests/support/memory_store.h"
#include "tests/support/wire_arrays.h"

namespace pliant::server {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class SessionStoreTest : public testing::Test {
 protected:
  SessionStoreTest() { session_ = Start(Durability::kStrict); }

  Session::Environment Environment(Durability durability) {
    return {.clock = &clock_,
            .scheduler = &scheduler_,
            .log = &log_,
            .factory = RemesherFactory(),
            .loader = RemesherLoader(),
            .codec = &codec_,
            .journal = std::make_shared<StoreJournal>(store_, key_, nullptr),
            .durability = durability,
            .on_broken = [](const std::string&) {}};
  }
  std::shared_ptr<Session> Start(Durability durability,
                                 std::optional<std::int64_t> history_bytes_max = {}) {
    v1::CreateSession create = test::UnitSquare("0.2");
    if (history_bytes_max) create.mutable_options()->set_history_bytes_max(*history_bytes_max);
    Session::Environment environment = Environment(durability);
    environment.history_bytes_asked = history_bytes_max;
    auto session = std::make_shared<Session>(std::move(environment), key_.name,
                                             std::map<std::string, std::string>{});
    session->Start(
        codec_.ReadInput(FormOf(create))->engine,
        [this](const Status& status) { start_status_ = status; }, FormOf(create));
    RunAll();
    return session;
  }
  // Another server's view of what is stored.
  std::shared_ptr<Session> Restore() {
    StoredInfo stored = ReadInfo(store_.Load(key_)->head.head).value();
    stored.info.session_id = key_.name;
    return std::make_shared<Session>(Environment(stored.durability), stored.info);
  }
  void RunAll() {
    while (scheduler_.RunOne()) {
    }
  }
  std::shared_ptr<FakeEditor> Edit(Session& session, std::vector<SessionCommand> commands) {
    auto editor = std::make_shared<FakeEditor>();
    editor->commands.assign(commands.begin(), commands.end());
    EXPECT_TRUE(session.Attach(editor).ok());
    session.Wake();
    RunAll();
    return editor;
  }
  UpdateCommand Size(std::int64_t id, const std::string& size) {
    v1::EditRequest request;
    request.set_update_id(id);
    request.mutable_metric()->add_sources()->mutable_size()->set_size(size);
    UpdateCommand command = codec_.ReadUpdate(FormOf(request));
    command.form = FormOf(request);
    return command;
  }
  /// A size under number 2, with an advance that is due before it is staged.
  std::shared_ptr<FakeEditor> EditDue(const std::string& size) {
    const AdvanceSpec due{.time_max = std::chrono::milliseconds(1), .arrival = clock_.Now()};
    clock_.Advance(std::chrono::milliseconds(2));
    return Edit(*session_, {OpenCommand{.mirror_revision = Revision(1)}, Size(2, size),
                            UpdateCommand{.update_id = 3, .body = due}});
  }
  /// Advance 4, and where it leads.
  std::uint64_t Finish(Session& session, FakeEditor& editor) {
    editor.commands.emplace_back(Advance(4));
    session.Wake();
    RunAll();
    EXPECT_EQ(editor.Log().back(), "advanced 4");
    return session.info().summary->state_hash;
  }
  static UpdateCommand Advance(std::int64_t id) { return {.update_id = id, .body = AdvanceSpec{}}; }

  const StoreKey key_{DocumentKind::kSession, "", "s1"};
  const WireCodec codec_;
  ManualClock clock_;
  const Log log_{LogLevel::kError, LogFormat::kText};
  MemoryStore store_;
  Scheduler scheduler_{/*worker_count=*/0, clock_};
  std::optional<Status> start_status_;
  std::shared_ptr<Session> session_;
};

TEST_F(SessionStoreTest, NobodySeesACommitBeforeItIsDurable) {
  ASSERT_TRUE(start_status_.has_value() && start_status_->ok());
  store_.Hold();
  const auto reader = std::make_shared<FakeSubscriber>();
  ASSERT_TRUE(session_->Subscribe(reader, Revision::kNone).ok());
  const auto editor = Edit(*session_, {OpenCommand{}, Advance(1)});
  EXPECT_THAT(editor->Log(), ElementsAre("opened"));
  EXPECT_EQ(editor->done_count, 1);
  EXPECT_EQ(session_->info().revision, Revision::kNone);
  EXPECT_THAT(reader->log, ElementsAre("bookmark 0"));
  EXPECT_EQ(store_.waiting_count(), 1u) << "commit and answer together";
  store_.Flush();
  RunAll();
  EXPECT_THAT(editor->Log(), ElementsAre("opened", "diff 1", "advanced 1"));
  EXPECT_EQ(editor->done_count, 2);
  EXPECT_EQ(session_->info().revision, Revision(1));
  EXPECT_THAT(reader->log, ElementsAre("bookmark 0", "diff 0-1"));
}

TEST_F(SessionStoreTest, AFailedWriteNeverHappened) {
  Edit(*session_, {OpenCommand{}, Advance(1)});
  const std::uint64_t hash = session_->info().summary->state_hash;
  store_.Hold();
  session_ = Restore();
  const auto second =
      Edit(*session_, {OpenCommand{.mirror_revision = Revision(1)}, Size(2, "0.1"), Advance(3)});
  EXPECT_THAT(second->Log(), ElementsAre("opened"));
  store_.Flush(Error{ErrorCode::kResourceExhausted, "full", {}});
  RunAll();
  EXPECT_THAT(second->Log(), ElementsAre("opened")) << "nothing was told";
  ASSERT_TRUE(second->closed.has_value());
  EXPECT_EQ(second->closed->code, ErrorCode::kResourceExhausted);
  EXPECT_EQ(session_->info().revision, Revision(1));
  EXPECT_EQ(session_->info().summary->state_hash, hash);
  // There is space again: the client repeats, and it is applied once.
  const auto third =
      Edit(*session_, {OpenCommand{.mirror_revision = Revision(1)}, Size(2, "0.1"), Advance(3)});
  EXPECT_THAT(third->Log(), ElementsAre("opened", "accepted 2", "diff 3", "advanced 3"));
  EXPECT_EQ(session_->info().revision, Revision(2));
}

TEST_F(SessionStoreTest, SleepsAndWakesWithItsStage) {
  const auto editor = Edit(*session_, {OpenCommand{}, Advance(1), Size(2, "0.1 + 0.1*x")});
  session_->RequestSleep();
  RunAll();
  EXPECT_TRUE(session_->info().asleep);
  EXPECT_EQ(session_->info().revision, Revision(1));
  EXPECT_EQ(session_->info().last_update_id, 2);
  editor->commands.emplace_back(Advance(3));
  session_->Wake();
  RunAll();
  EXPECT_EQ(editor->Log().back(), "advanced 3") << "its editor did not notice";
  EXPECT_FALSE(session_->info().asleep);

  // A twin that never slept.
  const std::uint64_t hash = session_->info().summary->state_hash;
  MemoryStore other;
  Session::Environment environment = Environment(Durability::kStrict);
  environment.journal = std::make_shared<StoreJournal>(other, key_, nullptr);
  const auto twin =
      std::make_shared<Session>(environment, "twin", std::map<std::string, std::string>{});
  const v1::CreateSession create = test::UnitSquare("0.2");
  twin->Start(
      codec_.ReadInput(FormOf(create))->engine, [](const Status&) {}, FormOf(create));
  RunAll();
  Edit(*twin, {OpenCommand{}, Advance(1), Size(2, "0.1 + 0.1*x"), Advance(3)});
  EXPECT_EQ(twin->info().summary->state_hash, hash);
}

// Goal: an answer that comes while an update is still being staged is as durable as any other...
TEST_F(SessionStoreTest, WhatIsAnsweredBeforeItIsStagedIsStoredFirst) {
  session_->Detach(Edit(*session_, {OpenCommand{}, Advance(1)}).get());
  store_.Hold();
  const auto editor = EditDue("0.1");
  EXPECT_THAT(editor->Log(), ElementsAre("opened"));
  store_.Flush();
  RunAll();
  EXPECT_THAT(editor->Log(), ElementsAre("opened", "accepted 2", "advanced 3"));
  EXPECT_EQ(std::get<AdvancedEvent>(editor->events[2].body).end, AdvanceEnd::kStaging);

  // ...and who loads the session stages it again.
  session_ = Restore();
  const auto second = Edit(*session_, {OpenCommand{.mirror_revision = Revision(1)}});
  EXPECT_EQ(std::get<OpenedEvent>(second->events[0].body).staged_count, 1);
  const std::uint64_t hash = Finish(*session_, *second);
  EXPECT_EQ(session_->info().revision, Revision(2));

  // A twin whose advance was not due.
  Session::Environment environment = Environment(Durability::kNone);
  environment.journal = nullptr;
  const auto twin =
      std::make_shared<Session>(environment, "twin", std::map<std::string, std::string>{});
  twin->Start(codec_.ReadInput(FormOf(test::UnitSquare("0.2")))->engine, [](const Status&) {});
  RunAll();
  const auto editor_of_twin = Edit(*twin, {OpenCommand{}, Advance(1), Size(2, "0.1")});
  EXPECT_EQ(Finish(*twin, *editor_of_twin), hash);
}

TEST_F(SessionStoreTest, WhatIsRefusedAfterItWasAnsweredIsRefusedAgain) {
  session_->Detach(Edit(*session_, {OpenCommand{}, Advance(1)}).get());
  EXPECT_THAT(EditDue("x - 0.5")->Log(), ElementsAre("opened", "accepted 2", "advanced 3"));
  session_ = Restore();
  const auto editor =
      Edit(*session_, {OpenCommand{.mirror_revision = Revision(1)}, Advance(4), Advance(5)});
  EXPECT_THAT(editor->Log(), ElementsAre("opened", "rejected 4", "diff 5", "advanced 5"));
  const Error& error = std::get<RejectedEvent>(editor->events[1].body).error;
  EXPECT_EQ(error.code, ErrorCode::kExpressionValue) << error.message;
  EXPECT_THAT(error.message, testing::HasSubstr("update 2"));
}

// Goal: a session keeps as much as it was created to keep, also when it has slept or was loaded by
// another server, and says so meanwhile.
TEST_F(SessionStoreTest, KeepsAsMuchHistoryAsItWasCreatedTo) {
  session_->Delete({ErrorCode::kSessionNotFound, "deleted", {}}, [](const Status&) {});
  RunAll();
  session_ = Start(Durability::kRelaxed, /*history_bytes_max=*/0);
  session_->Detach(Edit(*session_, {OpenCommand{}, Advance(1), Size(2, "0.1"), Advance(3)}).get());
  const auto back = [](std::int64_t id) {
    return UpdateCommand{.update_id = id, .body = RollbackUpdate{Revision(1)}};
  };
  session_->Detach(Edit(*session_, {OpenCommand{.mirror_revision = Revision(2)}, back(4)}).get());
  session_ = Restore();
  EXPECT_TRUE(session_->info().asleep);
  EXPECT_EQ(session_->info().history_bytes_max, 0);
  const auto editor = Edit(*session_, {OpenCommand{.mirror_revision = Revision(2)}, back(5),
                                       Size(6, "0.2"), Advance(7), back(8)});
  EXPECT_THAT(editor->Log(), ElementsAre("opened", "rejected 5", "accepted 6", "diff 7",
                                         "advanced 7", "rejected 8"));
  EXPECT_EQ(session_->info().history_bytes_max, 0);
}

TEST_F(SessionStoreTest, ReadersOfASleepingSessionWakeItOnlyIfTheyLackSomething) {
  Edit(*session_, {OpenCommand{}, Advance(1)});
  session_ = Restore();
  EXPECT_TRUE(session_->info().asleep);
  session_->Wake();
  RunAll();
  EXPECT_TRUE(session_->info().asleep) << "nobody needs it";
  const auto reader = std::make_shared<FakeSubscriber>();
  ASSERT_TRUE(session_->Subscribe(reader, Revision::kNone).ok());
  RunAll();
  EXPECT_THAT(reader->log, ElementsAre("snapshot 1"));
  session_->RequestSleep();
  RunAll();
  EXPECT_TRUE(session_->info().asleep);
  session_->WakeForSubscriber();
  RunAll();
  EXPECT_TRUE(session_->info().asleep) << "it has everything";
}

TEST_F(SessionStoreTest, ASessionWithoutAJournalDoesNotSleep) {
  Session::Environment environment = Environment(Durability::kNone);
  environment.journal = nullptr;
  const auto session =
      std::make_shared<Session>(environment, "m", std::map<std::string, std::string>{});
  session->Start(codec_.ReadInput(FormOf(test::UnitSquare()))->engine, [](const Status&) {});
  RunAll();
  session->RequestSleep();
  RunAll();
  EXPECT_FALSE(session->info().asleep);
}

TEST_F(SessionStoreTest, WhatCannotBeLoadedSaysSoAndCanBeDeleted) {
  Edit(*session_, {OpenCommand{}, Advance(1)});
  session_ = Restore();
  // A record that is none.
  store_.Append(key_, Epoch::kFirst, {3, {Bytes(9)}, store_.Load(key_)->head.head},
                [](const Status& status) { EXPECT_TRUE(status.ok()) << status.error().message; });
  const auto editor = Edit(*session_, {OpenCommand{}});
  ASSERT_TRUE(editor->closed.has_value());
  EXPECT_EQ(editor->closed->code, ErrorCode::kDataCorrupt);
  std::optional<Status> deleted;
  session_->Delete({ErrorCode::kSessionNotFound, "deleted", {}},
                   [&](const Status& status) { deleted = status; });
  RunAll();
  ASSERT_TRUE(deleted.has_value());
  EXPECT_TRUE(deleted->ok());
  EXPECT_THAT(*store_.List(DocumentKind::kSession), IsEmpty());
}

}  // namespace
}  // namespace pliant::server
