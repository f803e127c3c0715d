#include "core/pliant/revision_delta.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/rng.h"
#include "core/metric/function_field.h"
#include "core/pliant/remesher.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"
#include "tests/support/seed.h"
#include "tests/support/session_script.h"

namespace pliant {
namespace {

using testing::DifferenceOf;
using testing::Faults;
using testing::SessionScript;

Bytes Saved(const Remesher& session) {
  const Result<Bytes> bytes = session.Save();
  PLIANT_CHECK(bytes.ok(), "error", bytes.ok() ? "" : bytes.error().message);
  return *bytes;
}

std::unique_ptr<Remesher> Loaded(const Bytes& bytes) {
  Result<std::unique_ptr<Remesher>> session = Remesher::Load(bytes);
  PLIANT_CHECK(session.ok(), "error", session.ok() ? "" : session.error().message);
  return *std::move(session);
}

/// One session that takes ways back, beside what it was the first time through.
class Walk {
 public:
  Walk(std::uint64_t seed, int revision_count)
      : script_(seed), rng_(seed), revision_count_(revision_count) {
    session_ = script_.Start();
    for (int n = 1; n <= revision_count_; ++n) {
      diffs_.push_back(script_.Run(*session_, n));
      states_.push_back(Saved(*session_));
    }
    session_ = script_.Start();
    Next();
  }

  void TakeOneStep() {
    switch (rng_.Below(6)) {
      case 0:
        return Undo();
      case 1:
        return UndoMany();
      case 2:
        return Redo();
      case 3:
        what_ = "saved and loaded";
        session_ = Loaded(Saved(*session_));
        return;
      case 4:
        return Disturb();
      default:
        return Next();
    }
  }

  /// What is not as it was the first time; empty if nothing.
  [[nodiscard]] std::string Difference() {
    const auto at = static_cast<std::size_t>(at_ - 1);
    std::string text = "after " + what_ + " at revision " + std::to_string(at_) + ": ";
    if (session_->revision() != Revision(at_)) return text + "another revision";
    if (Saved(*session_) != states_[at]) return text + "other bytes";
    const std::string mesh = DifferenceOf(session_->mesh(), Loaded(states_[at])->mesh());
    if (!mesh.empty()) return text + mesh;
    return diff_problem_.empty() ? "" : text + diff_problem_;
  }

  /// To the last revision, by the updates themselves.
  void Finish() {
    while (at_ < revision_count_) Next();
  }

 private:
  void Next() {
    what_ = "an update";
    if (at_ == revision_count_) return;
    const MeshDiff diff = script_.Run(*session_, at_ + 1);
    const MeshDiff& first = diffs_[static_cast<std::size_t>(at_)];
    if (diff.summary != first.summary || diff.vertex_ids != first.vertex_ids ||
        diff.triangle_ids != first.triangle_ids || diff.metrics != first.metrics) {
      diff_problem_ = "the diff is another one";
    }
    ++at_;
    std::optional<RevisionDelta> undo = session_->TakeUndo();
    if (!undo) return;  // The first revision has none.
    undo_.resize(static_cast<std::size_t>(at_ - 2));
    undo_.push_back(*std::move(undo));
  }

  /// Deltas that lead back; none before `kept` of them.
  void Undo() {
    what_ = "an undo";
    if (undo_.empty()) return;
    Apply(undo_.back());
    undo_.pop_back();
  }

  void UndoMany() {
    if (undo_.empty()) return Next();
    const auto count = static_cast<std::size_t>(1 + rng_.Below(undo_.size()));
    what_ = "an undo of " + std::to_string(count);
    std::vector<const RevisionDelta*> chain;
    for (std::size_t i = 0; i < count; ++i) chain.push_back(&undo_[undo_.size() - 1 - i]);
    Apply(Merge(chain));
    undo_.resize(undo_.size() - count);
  }

  /// Back and forth again, forth by the written form of the delta, as after a crash.
  void Redo() {
    if (undo_.empty()) return Next();
    what_ = "a redo";
    const RevisionDelta redo = session_->InverseOf(undo_.back());
    const Result<Bytes> written = WriteDelta(redo);
    PLIANT_CHECK(written.ok());
    Apply(undo_.back());
    if (rng_.Below(2) == 0) session_ = Loaded(Saved(*session_));
    const Result<RevisionDelta> read = session_->ReadDelta(*written);
    PLIANT_CHECK(read.ok(), "error", read.ok() ? "" : read.error().message);
    Apply(*read);
    undo_.back() = *session_->TakeUndo();
  }

  /// Something that is begun and given up.
  void Disturb() {
    what_ = "a rollback";
    PLIANT_CHECK(session_->SetMetric({.source = SizeMetric{"0.3"}}).ok());
    PLIANT_CHECK(session_->Step({.visits_max = 100}).ok());
    session_->Rollback();
  }

  void Apply(const RevisionDelta& delta) {
    const Result<MeshDiff> diff = session_->Apply(delta, delta.revision);
    PLIANT_CHECK(diff.ok(), "error", diff.ok() ? "" : diff.error().message);
    at_ = static_cast<int>(delta.revision);
  }

  SessionScript script_;
  Rng rng_;
  int revision_count_;
  std::vector<Bytes> states_;
  std::vector<MeshDiff> diffs_;
  std::unique_ptr<Remesher> session_;
  std::vector<RevisionDelta> undo_;  // From revision i + 2 to i + 1.
  int at_ = 0;
  std::string what_;
  std::string diff_problem_;
};

// Goal: after any way back, by undo, merged undo, redo from bytes, rollback, saving and loading,
// the
//       session has every bit that it had there the first time, and goes on with the same bits.
// Method: random lives of a session, once straight through and once with ways back in between; the
//         whole written state is compared after every step. PLIANT_SEED=n runs one of them.
TEST(RevisionDelta, LeadsToTheBitsOfTheFirstTimeAndOnWithThem) {
  for (const std::uint64_t seed : test::Seeds{.count = 30, .long_count = 300}.OfPart(0)) {
    SCOPED_TRACE(test::Replay(seed, "core_tests", "RevisionDelta.LeadsTo*"));
    Walk walk(seed, 8);
    ASSERT_EQ(walk.Difference(), "");
    for (int step = 0; step < 40; ++step) {
      walk.TakeOneStep();
      ASSERT_EQ(walk.Difference(), "") << "step " << step;
    }
    walk.Finish();
    ASSERT_EQ(walk.Difference(), "");
  }
}

// Goal: a second session from a revision and the first go different ways without touching each
//       other.
TEST(RevisionDelta, AForkIsASessionOfItsOwn) {
  const SessionScript script(3);
  const auto one = script.Start();
  (void)script.Run(*one, 1);
  (void)script.Run(*one, 2);
  const Bytes state = Saved(*one);
  const auto two = Loaded(state);
  (void)script.Run(*one, 3);
  EXPECT_EQ(Saved(*two), state);
  (void)script.Run(*two, 3);
  EXPECT_EQ(Saved(*two), Saved(*one));
  (void)script.Run(*two, 4);
  EXPECT_NE(Saved(*two), Saved(*one));
}

struct Change {
  std::size_t undo_bytes = 0;
  std::size_t journal_bytes = 0;
  std::size_t state_bytes = 0;
};

/// Tensors at one vertex of a mesh of about `nodes` nodes.
Change OneVertex(double nodes) {
  MetricSpec spec;
  spec.source = SizeMetric{std::to_string(std::sqrt(1.1547 / nodes))};
  auto session = *Remesher::Create(testing::Rectangle({0, 0}, {1, 1}), spec, {});
  PLIANT_CHECK(session->Step({}).ok());
  (void)session->Commit();
  const VertexId vertex(session->mesh().vertex_count() / 2);
  const std::vector<Metric> tensors{4 * session->mesh().metric(vertex)};
  PLIANT_CHECK(session->SetTensors(std::span(&vertex, 1), tensors).ok());
  PLIANT_CHECK(session->Step({}).ok());
  (void)session->Commit();
  const RevisionDelta undo = *session->TakeUndo();
  return {undo.bytes(), WriteDelta(session->InverseOf(undo))->size(), Saved(*session).size()};
}

// Goal: the price of an undo, and of a line in the journal, is that of the diff.
TEST(RevisionDelta, CostsWhatChangedAndNotTheMesh) {
  const Change small = OneVertex(1000);
  const Change large = OneVertex(16000);
  EXPECT_GT(large.state_bytes, 10 * small.state_bytes);
  EXPECT_LT(large.undo_bytes, 3 * small.undo_bytes);
  EXPECT_LT(large.journal_bytes, 3 * small.journal_bytes);
  EXPECT_LT(large.journal_bytes, large.state_bytes / 20);
}

TEST(RevisionDelta, OfAnotherRevisionIsRefusedAndChangesNothing) {
  const SessionScript script(1);
  const auto session = script.Start();
  for (int n = 1; n <= 3; ++n) (void)script.Run(*session, n);
  RevisionDelta undo = *session->TakeUndo();
  const Bytes written = *WriteDelta(undo);
  ASSERT_TRUE(session->Apply(undo, undo.revision).ok());
  const Bytes state = Saved(*session);
  const Result<MeshDiff> again = session->Apply(undo, undo.revision);
  ASSERT_FALSE(again.ok());
  EXPECT_EQ(again.error().code, ErrorCode::kDataCorrupt);
  const Result<RevisionDelta> read = session->ReadDelta(written);
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.error().code, ErrorCode::kRevisionMismatch);
  EXPECT_EQ(Saved(*session), state);
}

TEST(RevisionDelta, RefusesDamagedBytes) {
  const SessionScript script(2);
  const auto session = script.Start();
  for (int n = 1; n <= 3; ++n) (void)script.Run(*session, n);
  const RevisionDelta undo = *session->TakeUndo();
  Bytes bytes = *WriteDelta(undo);
  ASSERT_TRUE(session->ReadDelta(bytes).ok());
  Rng rng(5);
  for (int i = 0; i < 500; ++i) {
    Bytes damaged = bytes;
    const std::size_t at = rng.Below(bytes.size());
    if (at >= 4 && at < 8) continue;  // The version, which may be that of an older format.
    damaged[at] ^= std::byte{1} << rng.Below(8);
    const Result<RevisionDelta> read = session->ReadDelta(damaged);
    ASSERT_FALSE(read.ok()) << "byte " << at;
    EXPECT_THAT(read.error().code,
                ::testing::AnyOf(ErrorCode::kDataCorrupt, ErrorCode::kDataVersion));
  }
}

TEST(RevisionDelta, AFieldOfTheCallersOwnGoesBackButIsNotWritten) {
  auto made = testing::DiscCase(300, testing::DiscState::kOff);
  auto session = *Remesher::Create(made.domain, std::move(made.field), {});
  ASSERT_TRUE(session->Step({}).ok());
  (void)session->Commit();
  const MeshSummary before = SnapshotOf(session->mesh(), Revision(1)).summary;
  ASSERT_TRUE(session->SetField(testing::DiscCase(500, testing::DiscState::kOn).field).ok());
  ASSERT_TRUE(session->Step({}).ok());
  (void)session->Commit();
  const RevisionDelta undo = *session->TakeUndo();
  const Result<Bytes> written = WriteDelta(undo);
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().code, ErrorCode::kUnimplemented);
  const Result<Bytes> saved = session->Save();
  ASSERT_FALSE(saved.ok());
  EXPECT_EQ(saved.error().code, ErrorCode::kUnimplemented);
  ASSERT_TRUE(session->Apply(undo, undo.revision).ok());
  EXPECT_EQ(SnapshotOf(session->mesh(), Revision(1)).summary, before);
}

}  // namespace
}  // namespace pliant
