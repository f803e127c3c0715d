#include "server/record.h"

#include <gtest/gtest.h>

namespace pliant::server {
namespace {

template <class Kind>
Kind Again(const Kind& record) {
  const Result<Record> again = ReadRecord(WriteRecord(record));
  EXPECT_TRUE(again.ok()) << (again.ok() ? "" : again.error().message);
  return std::get<Kind>(*again);
}

TEST(Record, KeepsAnswers) {
  const AnswerRecord record = Again(AnswerRecord{
      .answer = UpdateAnswer{{.update_id = 3, .revision = Revision(2), .body = AcceptedEvent{4}},
                             {UpdateKind::kMetric, 9}},
      .effect = StageEffect::kStaged,
      .update = Bytes(5, std::byte{6})});
  EXPECT_EQ(record.answer->event.update_id, 3);
  EXPECT_EQ(record.answer->update.hash, 9u);
  EXPECT_EQ(record.effect, StageEffect::kStaged);
  EXPECT_EQ(record.update, Bytes(5, std::byte{6}));
  EXPECT_FALSE(Again(AnswerRecord{.effect = StageEffect::kEmptied}).answer.has_value());
}

TEST(Record, KeepsCommits) {
  CommitRecord commit{.revision = Revision(9),
                      .update_id = 8,
                      .active_count = 7,
                      .time = Clock::WallTime(std::chrono::seconds(5)),
                      .transfer = TransferRows{},
                      .fields = {.changed = {}, .dropped_names = {"u"}}};
  commit.change.emplace<1>(Bytes(4, std::byte{1}));
  commit.spec = std::make_shared<const MetricSpec>(MetricSpec{.source = SizeMetric{"x"}});
  CommitRecord again = Again(commit);
  EXPECT_EQ(again.revision, Revision(9));
  EXPECT_EQ(again.update_id, 8);
  EXPECT_EQ(again.active_count, 7);
  EXPECT_EQ(again.time, commit.time);
  ASSERT_EQ(again.change.index(), 1u);
  EXPECT_EQ(std::get<1>(again.change), Bytes(4, std::byte{1}));
  EXPECT_EQ(**again.spec, **commit.spec);
  EXPECT_TRUE(again.transfer.has_value());
  EXPECT_EQ(again.fields, commit.fields);

  commit.change.emplace<0>(Bytes(3, std::byte{2}));
  commit.spec = nullptr;
  commit.transfer.reset();
  again = Again(commit);
  EXPECT_EQ(std::get<0>(again.change), Bytes(3, std::byte{2}));
  ASSERT_TRUE(again.spec.has_value());
  EXPECT_EQ(*again.spec, nullptr) << "no specification is something else than as before";
  EXPECT_FALSE(again.transfer.has_value());
  commit.spec.reset();
  EXPECT_FALSE(Again(commit).spec.has_value());
}

TEST(Record, KeepsSavedRevisions) {
  EXPECT_EQ(Again(SavedRecord{{1, 5, 9}}).revisions, (std::vector<std::int64_t>{1, 5, 9}));
}

TEST(Record, RefusesWhatIsNoRecord) {
  const Bytes good = WriteRecord(SavedRecord{{1}});
  for (std::size_t i = 0; i < good.size(); ++i) {
    Bytes bad = good;
    bad[i] ^= std::byte{4};
    EXPECT_FALSE(ReadRecord(bad).ok()) << "byte " << i;
    EXPECT_FALSE(ReadRecord(std::span(good).first(i)).ok());
  }
  Bytes newer = good;
  newer[4] = std::byte{5};
  EXPECT_EQ(ReadRecord(newer).error().code, ErrorCode::kDataVersion);
}

// Goal: what the version before wrote, whose answers have no fingerprint, is read.
TEST(Record, ReadsTheVersionBefore) {
  Bytes old = WriteRecord(AnswerRecord{
      .answer = UpdateAnswer{{.update_id = 3, .revision = Revision(2), .body = AcceptedEvent{4}}},
      .effect = StageEffect::kStaged,
      .update = Bytes(5, std::byte{6})});
  old[4] = std::byte{2};
  const Result<Record> record = ReadRecord(old);
  ASSERT_TRUE(record.ok()) << record.error().message;
  EXPECT_EQ(std::get<AnswerRecord>(*record).answer->event.update_id, 3);
  EXPECT_EQ(std::get<AnswerRecord>(*record).answer->update, Fingerprint{});
}

TEST(Record, KeepsWhatAListShows) {
  StoredInfo stored;
  stored.durability = Durability::kRelaxed;
  stored.info.labels = {{"solver", "x"}, {"case", ""}};
  stored.info.revision = Revision(12);
  stored.info.summary = MeshSummary{1, 2, 3, 4};
  stored.info.active_count = 5;
  stored.info.last_update_id = 6;
  stored.info.saved_revisions = {7, 8};
  stored.info.create_time = Clock::WallTime(std::chrono::seconds(9));
  const auto again = ReadInfo(WriteInfo(stored));
  ASSERT_TRUE(again.ok()) << again.error().message;
  EXPECT_EQ(again->durability, Durability::kRelaxed);
  EXPECT_EQ(again->info.labels, stored.info.labels);
  EXPECT_EQ(again->info.revision, Revision(12));
  EXPECT_EQ(again->info.summary, stored.info.summary);
  EXPECT_EQ(again->info.active_count, 5);
  EXPECT_EQ(again->info.last_update_id, 6);
  EXPECT_EQ(again->info.saved_revisions, stored.info.saved_revisions);
  EXPECT_EQ(again->info.create_time, stored.info.create_time);
  EXPECT_FALSE(again->info.commit_time.has_value());
  EXPECT_FALSE(again->info.history_bytes_max.has_value());
  stored.info.history_bytes_max = 0;
  EXPECT_EQ(ReadInfo(WriteInfo(stored))->info.history_bytes_max, 0);
  EXPECT_FALSE(ReadInfo(WriteRecord(SavedRecord{})).ok()) << "another kind of bytes";
}

}  // namespace
}  // namespace pliant::server
