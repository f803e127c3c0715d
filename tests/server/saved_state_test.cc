// Goal: a session's memory that was written and read again goes on as if it had not been.
// Method: sessions of the real engine, whose journal a test writes by hand as Session does.
#include "server/saved_state.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "server/kept_bytes.h"
#include "server/record.h"

namespace pliant::server {
namespace {

// Reads specifications from text: "size" of a square for an input, "size" for an update.
class TextCodec final : public SessionCodec {
 public:
  Result<SessionInput> ReadInput(std::span<const std::byte> bytes) const override {
    Domain domain;
    domain.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    domain.segments = {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
    SessionInput input;
    input.engine = {.start = domain, .metric = {.source = SizeMetric{Text(bytes)}}, .options = {}};
    input.history_bytes_max = history_bytes_max;
    return input;
  }
  UpdateCommand ReadUpdate(std::span<const std::byte> bytes) const override {
    return {.body = MetricUpdate{.source = SizeMetric{Text(bytes)}}};
  }
  static std::string Text(std::span<const std::byte> bytes) {
    return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  }
  static Bytes From(const std::string& text) {
    const auto bytes = std::as_bytes(std::span(text));
    return Bytes(bytes.begin(), bytes.end());
  }

  std::optional<std::int64_t> history_bytes_max = {};
};

class SavedStateTest : public testing::Test {
 protected:
  SavedStateTest()
      : makers_{.factory = RemesherFactory(), .loader = RemesherLoader(), .codec = &codec_},
        snapshot_(WriteInput(TextCodec::From("0.15"))),
        memory_(ReadMemory(snapshot_, {}, makers_).value()) {}

  void Record(const server::Record& record) { records_.push_back(WriteRecord(record)); }

  void Stage(const std::string& size) {
    const Bytes form = TextCodec::From(size);
    ASSERT_TRUE(memory_.engine->StageCommand(codec_.ReadUpdate(form)).ok());
    ++update_id_;
    const UpdateAnswer accepted{{.update_id = update_id_,
                                 .revision = memory_.revision,
                                 .body = AcceptedEvent{memory_.engine->staged_count()}},
                                {UpdateKind::kMetric, static_cast<std::uint64_t>(update_id_)}};
    memory_.results.Add(accepted);
    Record(AnswerRecord{.answer = accepted, .effect = StageEffect::kStaged, .update = form});
  }

  // As Session::Commit does.
  void Commit(std::int64_t visits_max = INT64_MAX) {
    const Result<Progress> progress = memory_.engine->Step({.visits_max = visits_max});
    ASSERT_TRUE(progress.ok());
    const auto diff = std::make_shared<const MeshDiff>(memory_.engine->Commit());
    std::optional<UndoStep> undo = memory_.engine->TakeUndo();
    CommitRecord record{.revision = diff->revision,
                        .update_id = ++update_id_,
                        .active_count = progress->active_count,
                        .time = {},
                        .spec = memory_.engine->committed_spec(),
                        .change = {},
                        .transfer = diff->transfer,
                        .fields = diff->fields};
    if (undo) {
      record.change.emplace<0>(*WriteDelta(memory_.engine->engine().InverseOf(undo->delta)));
      undo->active_count = memory_.active_count;
      memory_.undo.Add(*std::move(undo));
    } else {
      record.change.emplace<1>(*memory_.engine->Save());
    }
    Record(record);
    const std::int64_t vertex_count = diff->summary.vertex_count;
    const std::optional<std::int64_t> asked = memory_.history_bytes_max;
    memory_.history.SetBytesMax(HistoryBytesMax(vertex_count, kHistoryBytesMax, asked));
    memory_.undo.SetBytesMax(UndoBytesMax(vertex_count, asked));
    memory_.history.Add(diff);
    memory_.revision = diff->revision;
    memory_.applied_update_id = update_id_;
    memory_.active_count = progress->active_count;
    memory_.summary = diff->summary;
  }

  SessionMemory Again() {
    Result<SessionMemory> again = ReadMemory(snapshot_, records_, makers_);
    EXPECT_TRUE(again.ok()) << (again.ok() ? "" : again.error().message);
    return std::move(again).value();
  }

  TextCodec codec_;
  const SessionMakers makers_;
  Bytes snapshot_;
  std::vector<Bytes> records_;
  SessionMemory memory_;
  std::int64_t update_id_ = 0;
};

void ExpectSame(const SessionMemory& a, const SessionMemory& b) {
  EXPECT_EQ(a.revision, b.revision);
  EXPECT_EQ(a.applied_update_id, b.applied_update_id);
  EXPECT_EQ(a.active_count, b.active_count);
  EXPECT_EQ(a.summary, b.summary);
  EXPECT_EQ(a.results.last_update_id(), b.results.last_update_id());
  ASSERT_EQ(a.results.count(), b.results.count());
  for (std::size_t i = 0; i < a.results.count(); ++i) {
    EXPECT_EQ(a.results.At(i).update, b.results.At(i).update);
  }
  EXPECT_EQ(a.undo.saved(), b.undo.saved());
  EXPECT_EQ(a.undo.steps().size(), b.undo.steps().size());
  EXPECT_EQ(a.engine->staged_count(), b.engine->staged_count());
  EXPECT_EQ(a.engine->tainted(), b.engine->tainted());
}

// Goal: an update that was answered before it was staged is staged when it is read; what comes of
// it is known then, and what came after one that is refused is dropped with it.
TEST_F(SavedStateTest, StagesWhatWasPutOff) {
  Commit();
  const auto put_off = [&](const std::string& size) {
    const UpdateAnswer accepted{
        {.update_id = ++update_id_, .revision = memory_.revision, .body = AcceptedEvent{1}},
        {UpdateKind::kMetric, static_cast<std::uint64_t>(update_id_)}};
    memory_.results.Add(accepted);
    Record(AnswerRecord{
        .answer = accepted, .effect = StageEffect::kPutOff, .update = TextCodec::From(size)});
  };
  put_off("0.1");
  ASSERT_TRUE(memory_.engine->StageCommand(codec_.ReadUpdate(TextCodec::From("0.1"))).ok());
  ExpectSame(Again(), memory_);
  EXPECT_EQ(CountUnstaged(records_).value(), 1u);
  put_off("x - 0.5");
  put_off("0.2");
  const SessionMemory again = Again();
  EXPECT_EQ(again.engine->staged_count(), 1);
  EXPECT_TRUE(again.engine->tainted());
  ASSERT_TRUE(again.engine->late_refusal().has_value());
  EXPECT_EQ(again.engine->late_refusal()->code, ErrorCode::kExpressionValue);
  Record(AnswerRecord{.effect = StageEffect::kEmptied});
  EXPECT_FALSE(Again().engine->tainted());
  EXPECT_FALSE(Again().engine->late_refusal().has_value());
}

TEST_F(SavedStateTest, ReplaysRecordsAndSnapshotsAlike) {
  Commit();
  Stage("0.1 + 0.1*x");
  Commit(150);
  Commit();
  ASSERT_TRUE(memory_.undo.Save(Revision(2), memory_.revision).ok());
  Record(SavedRecord{{2}});
  Stage("0.12");
  Commit();
  const SessionMemory replayed = Again();
  ExpectSame(replayed, memory_);
  const Result<Bytes> snapshot = WriteMemory(replayed);
  ASSERT_TRUE(snapshot.ok()) << snapshot.error().message;
  Result<SessionMemory> loaded = ReadMemory(*snapshot, {}, makers_);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message;
  ExpectSame(*loaded, memory_);
  EXPECT_EQ(*WriteMemory(*loaded), *snapshot) << "nothing is lost on the way";

  // All three go back, and on, to the same bits.
  std::vector<std::uint64_t> hashes;
  for (SessionMemory* memory : {&memory_, &*loaded}) {
    const Result<UndoStep> way = memory->undo.WayTo(Revision(2), memory->revision);
    ASSERT_TRUE(way.ok());
    ASSERT_TRUE(memory->engine->GoTo(*way, Revision(9)).ok());
    ASSERT_TRUE(memory->engine->StageCommand(codec_.ReadUpdate(TextCodec::From("0.11"))).ok());
    ASSERT_TRUE(memory->engine->Step({}).ok());
    hashes.push_back(memory->engine->Commit().summary.state_hash);
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

// Goal: what is loaded keeps as much beside its mesh as what was there: a way back that was refused
// stays refused, and a snapshot that is made of it does not grow from one to the next.
TEST_F(SavedStateTest, KeepsNoMoreThanWasKept) {
  Commit();
  for (int i = 0; i < 24; ++i) {
    Stage(i % 2 == 0 ? "0.04" : "0.05");
    Commit();
  }
  const std::size_t step_count = memory_.undo.steps().size();
  ASSERT_LT(step_count, 24U) << "the bound is met";
  ASSERT_LT(memory_.history.count(), 24U);
  ASSERT_GT(step_count, 2U);
  const SessionMemory again = Again();
  EXPECT_EQ(again.undo.steps().size(), step_count);
  EXPECT_EQ(again.history.count(), memory_.history.count());
  snapshot_ = *WriteMemory(again);
  EXPECT_EQ(snapshot_.size(), WriteMemory(memory_)->size());
  records_.clear();
  for (int i = 0; i < 4; ++i) {
    Stage(i % 2 == 0 ? "0.045" : "0.055");
    Commit();
  }
  const SessionMemory later = Again();
  EXPECT_EQ(later.undo.steps().size(), memory_.undo.steps().size());
  EXPECT_EQ(later.history.count(), memory_.history.count());
}

// Goal: the same where the session was created to keep a certain amount, from its input on.
TEST_F(SavedStateTest, KeepsAsMuchAsWasAskedFor) {
  std::vector<std::size_t> step_counts;
  for (const std::int64_t asked : {std::int64_t{0}, std::int64_t{200'000}, kKeptBytesMax}) {
    SCOPED_TRACE(asked);
    codec_.history_bytes_max = asked;
    records_.clear();
    update_id_ = 0;
    memory_ = ReadMemory(snapshot_, {}, makers_).value();
    EXPECT_EQ(memory_.history_bytes_max, asked);
    Commit();
    for (int i = 0; i < 24; ++i) {
      Stage(i % 2 == 0 ? "0.04" : "0.05");
      Commit();
    }
    step_counts.push_back(memory_.undo.steps().size());
    const SessionMemory replayed = Again();
    const Bytes snapshot = WriteMemory(replayed).value();
    const SessionMemory loaded = ReadMemory(snapshot, {}, makers_).value();
    for (const SessionMemory* again : {&replayed, &loaded}) {
      EXPECT_EQ(again->history_bytes_max, asked);
      EXPECT_EQ(again->undo.steps().size(), memory_.undo.steps().size());
      // The first revision is stored whole: there is no diff to it.
      EXPECT_EQ(again->history.count(), std::min<std::size_t>(memory_.history.count(), 24));
    }
    EXPECT_EQ(WriteMemory(loaded).value(), snapshot);
  }
  EXPECT_EQ(step_counts.front(), 0U);
  EXPECT_GT(step_counts[1], 0U);
  EXPECT_LT(step_counts[1], 24U);
  EXPECT_EQ(step_counts.back(), 24U);
}

TEST_F(SavedStateTest, KeepsTheStage) {
  Commit();
  Stage("0.1 + 0.1*x");
  EXPECT_EQ(Again().engine->staged_count(), 1);
  EXPECT_EQ(WriteMemory(Again()).error().code, ErrorCode::kProtocolOrder);
  Record(AnswerRecord{.answer = {}, .effect = StageEffect::kTainted, .update = {}});
  EXPECT_TRUE(Again().engine->tainted());
  Record(AnswerRecord{.answer = {}, .effect = StageEffect::kEmptied, .update = {}});
  EXPECT_EQ(Again().engine->staged_count(), 0);
  EXPECT_FALSE(Again().engine->tainted());
  EXPECT_EQ(*CountSettled(records_), 1u) << "up to the commit";
  EXPECT_EQ(*CountUnstaged(records_), 4u) << "up to what emptied the stage";
  EXPECT_EQ(*CountUnstaged(std::span(records_).first(3)), 1u);
  Commit();
  EXPECT_EQ(*CountSettled(records_), records_.size());
  EXPECT_EQ(*CountSettled({}), 0u);
}

// Goal: records that do not belong together are refused, not applied.
TEST_F(SavedStateTest, RefusesAGapAndARepetition) {
  Commit();
  Stage("0.2");
  Commit();
  Stage("0.1");
  Commit();
  const std::vector<Bytes> all = records_;
  records_ = {all[0], all[3], all[4]};
  EXPECT_FALSE(ReadMemory(snapshot_, records_, makers_).ok()) << "without revision 2";
  records_ = {all[0], all[1], all[1]};
  EXPECT_EQ(ReadMemory(snapshot_, records_, makers_).error().code, ErrorCode::kDataCorrupt)
      << "an answer twice";
  records_ = {all[0], all[1], all[2], all[2]};
  EXPECT_FALSE(ReadMemory(snapshot_, records_, makers_).ok()) << "a commit twice";
  Bytes bad = snapshot_;
  bad.back() ^= std::byte{1};
  EXPECT_EQ(ReadMemory(bad, {}, makers_).error().code, ErrorCode::kDataCorrupt);
}

}  // namespace
}  // namespace pliant::server
