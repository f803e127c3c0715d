#include "server/store_journal.h"

#include <gtest/gtest.h>

#include "server/limits.h"
#include "tests/support/memory_store.h"

namespace pliant::server {
namespace {

const StoreKey kJournalKey{DocumentKind::kSession, "t", "s"};

class StoreJournalTest : public testing::Test {
 protected:
  std::shared_ptr<StoreJournal> Make() {
    return std::make_shared<StoreJournal>(
        store_, kJournalKey, [this](const std::shared_ptr<StoreJournal>&) { ++grown_count_; });
  }
  Status Append(StoreJournal& journal, std::vector<Bytes> records) {
    Status result;
    journal.Append(std::move(records), Bytes(1), [&](const Status& status) { result = status; });
    return result;
  }
  static Bytes Record(int value, std::size_t size = 4) {
    return Bytes(size, static_cast<std::byte>(value));
  }

  MemoryStore store_;
  int grown_count_ = 0;
};

TEST_F(StoreJournalTest, NumbersItsRecordsAcrossLoads) {
  const auto first = Make();
  first->Create(Bytes(1), Record(0), [](const Status& status) { EXPECT_TRUE(status.ok()); });
  EXPECT_TRUE(Append(*first, {Record(1), Record(2)}).ok());
  const auto second = Make();
  const Result<Journal::Contents> contents = second->Load();
  ASSERT_TRUE(contents.ok());
  EXPECT_EQ(contents->snapshot, Record(0));
  EXPECT_EQ(contents->records.size(), 2u);
  EXPECT_TRUE(Append(*second, {Record(3)}).ok());
  EXPECT_EQ(Append(*first, {Record(4)}).error().code, ErrorCode::kSessionBusy) << "fenced";
  EXPECT_TRUE(second->Load().ok()) << "loaded again, as after a sleep, it is still the owner";
  EXPECT_TRUE(Append(*second, {Record(5)}).ok());
}

TEST_F(StoreJournalTest, OutgrowsItsSnapshotOnceAndIsCompacted) {
  const auto journal = Make();
  journal->Create(Bytes(1), Record(0, kJournalBytesMin), [](const Status&) {});
  EXPECT_TRUE(Append(*journal, {Record(1, 2 * kJournalBytesMin - 1)}).ok());
  EXPECT_EQ(grown_count_, 0) << "twice the snapshot, less one byte";
  EXPECT_TRUE(Append(*journal, {Record(2, 1)}).ok());
  EXPECT_TRUE(Append(*journal, {Record(3, 9)}).ok());
  EXPECT_EQ(grown_count_, 1) << "asked for once";
  const Status compacted = journal->Compact(
      [](const Journal::Contents& contents) -> Result<std::optional<StoreJournal::Compacted>> {
        EXPECT_EQ(contents.records.size(), 3u);
        return std::optional(StoreJournal::Compacted{Record(7), 2});
      });
  EXPECT_TRUE(compacted.ok());
  const Result<StoredDocument> document = store_.Load(kJournalKey);
  EXPECT_EQ(document->snapshot, Record(7));
  EXPECT_EQ(document->records.size(), 1u);
  EXPECT_TRUE(Append(*journal, {Record(4)}).ok()) << "numbers go on";
}

TEST_F(StoreJournalTest, AJournalThatCannotBeCompactedStays) {
  const auto journal = Make();
  journal->Create(Bytes(1), Record(0), [](const Status&) {});
  EXPECT_TRUE(Append(*journal, {Record(1, kJournalBytesMin)}).ok());
  EXPECT_EQ(grown_count_, 1);
  const auto fail = [](const Journal::Contents&) -> Result<std::optional<StoreJournal::Compacted>> {
    return Error{ErrorCode::kUnimplemented, "no", {}};
  };
  EXPECT_FALSE(journal->Compact(fail).ok());
  EXPECT_EQ(store_.Load(kJournalKey)->records.size(), 1u);
  EXPECT_TRUE(Append(*journal, {Record(2, kJournalBytesMin - 1)}).ok());
  EXPECT_EQ(grown_count_, 1);
  EXPECT_TRUE(Append(*journal, {Record(3, 1)}).ok());
  EXPECT_EQ(grown_count_, 2) << "tried again when it has doubled";
}

TEST_F(StoreJournalTest, DeletesAlsoWhatItNeverLoaded) {
  Make()->Create(Bytes(1), Record(0), [](const Status&) {});
  Status result = Error{ErrorCode::kInternal, "not called", {}};
  Make()->Delete([&](const Status& status) { result = status; });
  EXPECT_TRUE(result.ok());
  EXPECT_EQ(store_.Load(kJournalKey).error().code, ErrorCode::kSessionNotFound);
  Make()->Delete([&](const Status& status) { result = status; });
  EXPECT_EQ(result.error().code, ErrorCode::kSessionNotFound);
}

}  // namespace
}  // namespace pliant::server
