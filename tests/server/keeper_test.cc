#include "server/keeper.h"

#include <gtest/gtest.h>

#include <future>
#include <optional>
#include <span>
#include <thread>

#include "server/limits.h"
#include "server/record.h"
#include "server/stored_form.h"
#include "tests/support/memory_store.h"
#include "tests/support/wire_arrays.h"

namespace pliant::server {
namespace {

class KeeperTest : public testing::Test {
 protected:
  const WireCodec codec_;
  const SessionMakers makers_{
      .factory = RemesherFactory(), .loader = RemesherLoader(), .codec = &codec_};
  const Log log_{LogLevel::kError, LogFormat::kText};
};

// What a session that has committed once writes.
Journal::Contents OneCommit(const SessionMakers& makers) {
  Journal::Contents contents;
  contents.snapshot = WriteInput(FormOf(test::UnitSquare("0.2")));
  SessionMemory memory = ReadMemory(contents.snapshot, {}, makers).value();
  EXPECT_TRUE(memory.engine->Step({}).ok());
  const MeshDiff diff = memory.engine->Commit();
  CommitRecord record{.revision = diff.revision,
                      .update_id = 1,
                      .active_count = 0,
                      .time = {},
                      .spec = memory.engine->committed_spec(),
                      .change = {},
                      .transfer = {},
                      .fields = {}};
  record.change.emplace<1>(*memory.engine->Save());
  contents.records.push_back(WriteRecord(record));
  return contents;
}

TEST_F(KeeperTest, CompactsUpToTheLastCommit) {
  Journal::Contents contents = OneCommit(makers_);
  contents.records.push_back(
      WriteRecord(AnswerRecord{.answer = {}, .effect = StageEffect::kTainted, .update = {}}));
  const auto compacted = CompactSession(contents, makers_);
  ASSERT_TRUE(compacted.ok()) << compacted.error().message;
  ASSERT_TRUE(compacted->has_value());
  EXPECT_EQ((*compacted)->record_count, 1u);
  const auto whole = ReadMemory(contents.snapshot, contents.records, makers_);
  const auto shorter =
      ReadMemory((*compacted)->snapshot, std::span(contents.records).subspan(1), makers_);
  ASSERT_TRUE(shorter.ok()) << shorter.error().message;
  EXPECT_EQ(shorter->revision, whole->revision);
  EXPECT_EQ(shorter->summary, whole->summary);
  EXPECT_TRUE(shorter->engine->tainted());
  contents.records.erase(contents.records.begin());
  EXPECT_FALSE(CompactSession(contents, makers_)->has_value()) << "no commit, nothing to gain";
}

// Goal: a journal that has grown is replaced on the keeper's own thread, and what it holds stays.
TEST_F(KeeperTest, ReplacesGrownJournals) {
  auto owned = std::make_unique<MemoryStore>();
  MemoryStore& store = *owned;
  Keeper keeper(std::move(owned), makers_, log_);
  const StoreKey key{DocumentKind::kSession, "t", "s"};
  const std::shared_ptr<Journal> journal = keeper.JournalOf("t", "s");
  Journal::Contents contents = OneCommit(makers_);
  journal->Create({}, contents.snapshot, [](const Status&) {});
  // Answers until it has grown beyond the least size.
  std::vector<Bytes> records = contents.records;
  const Bytes filler = WriteRecord(
      AnswerRecord{.answer = {}, .effect = StageEffect::kNone, .update = Bytes(kJournalBytesMin)});
  records.insert(records.begin(), filler);
  journal->Append(records, {}, [](const Status&) {});
  // No time limit of its own: the test's is long enough for any machine.
  while (store.Load(key)->head.snapshot_number == 0) std::this_thread::yield();
  EXPECT_EQ(store.Load(key)->head.snapshot_number, 2);
  const Result<Journal::Contents> now = journal->Load();
  const auto memory = ReadMemory(now->snapshot, now->records, makers_);
  ASSERT_TRUE(memory.ok()) << memory.error().message;
  EXPECT_EQ(memory->revision, Revision(1));
}

// Goal: a session is made again from the store beside the one that goes on, without what is staged.
TEST_F(KeeperTest, RecallsASessionAsItWasWithNothingStaged) {
  std::optional<Result<SessionMemory>> found;
  std::optional<Result<SessionMemory>> nobody;
  Journal::Contents contents = OneCommit(makers_);
  const UpdateAnswer answer{{.update_id = 1, .revision = Revision(1), .body = AcceptedEvent{0}}};
  contents.records.push_back(
      WriteRecord(AnswerRecord{.answer = answer, .effect = StageEffect::kNone, .update = {}}));
  contents.records.push_back(
      WriteRecord(AnswerRecord{.answer = {}, .effect = StageEffect::kTainted, .update = {}}));
  {
    Keeper keeper(std::make_unique<MemoryStore>(), makers_, log_);
    const std::shared_ptr<Journal> journal = keeper.JournalOf("t", "s");
    journal->Create({}, contents.snapshot, [](const Status&) {});
    journal->Append(contents.records, {}, [](const Status&) {});
    keeper.Recall("t", "nobody", [&](auto memory) { nobody.emplace(std::move(memory)); });
    std::promise<void> done;
    keeper.Recall("t", "s", [&](auto memory) {
      found.emplace(std::move(memory));
      done.set_value();
    });
    done.get_future().wait();
  }
  EXPECT_EQ(nobody->error().code, ErrorCode::kSessionNotFound);
  ASSERT_TRUE(found->ok()) << found->error().message;
  EXPECT_EQ((*found)->revision, Revision(1));
  EXPECT_EQ((*found)->results.last_update_id(), 1) << "the answer that came after the commit";
  EXPECT_FALSE((*found)->engine->tainted());
}

// Goal: whoever waits for a recall hears of the end.
TEST_F(KeeperTest, AnswersEveryRecallAtItsEnd) {
  int answer_count = 0;
  {
    Keeper keeper(std::make_unique<MemoryStore>(), makers_, log_);
    for (int i = 0; i < 50; ++i) {
      keeper.Recall("t", "nobody", [&](const auto& memory) {
        EXPECT_FALSE(memory.ok());
        ++answer_count;
      });
    }
  }
  EXPECT_EQ(answer_count, 50);
}

}  // namespace
}  // namespace pliant::server
