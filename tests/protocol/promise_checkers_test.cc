// Goal: one checker for each of the promises Ordered, Atomic, Complete, Resumable, Isolated and
// Bounded, whose failure is the sentence of proto/README.md.
// Method: each is applied to what real sessions show, and then to the same with a fault put in that
// the promise excludes: a checker that cannot fail is none.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <fstream>
#include <memory>
#include <span>
#include <sstream>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "tests/protocol/follow.h"
#include "tests/protocol/promises.h"
#include "tests/support/in_process_server.h"
#include "tests/support/subscribe_client.h"

namespace pliant::test {
namespace {

using testing::HasSubstr;

/// A client that keeps what it sent and saw.
class Recorder {
 public:
  Recorder(InProcessServer& server, const std::string& id) : edit_(server, id) {}

  void Stage(const std::string& size) {
    transcript.updates.insert(++update_);
    edit_.Size(update_, size);
    Read();
  }
  void Advance() {
    transcript.advances.insert(++update_);
    edit_.Advance(update_);
    Read();
  }
  Transcript transcript;

 private:
  void Read() {
    for (v1::EditResponse& response : edit_.Until(update_)) {
      transcript.seen.push_back(std::move(response));
    }
  }
  EditClient edit_;
  std::int64_t update_ = 0;
};

/// Steps with good and refused updates, in a session of its own.
struct Story {
  Story() {
    std::string id;
    EXPECT_TRUE(server.Create(UnitSquare("0.1"), &id).ok());
    Recorder recorder(server, id);
    recorder.Advance();
    for (const char* size : {"0.08", "0.05 +", "0.07"}) {
      recorder.Stage(size);
      recorder.Stage("0.06");
      recorder.Advance();
    }
    recorder.Stage("0.05 + 0.1*x");
    recorder.Advance();
    transcript = std::move(recorder.transcript);
    truth = Fetch(server, id);
  }
  /// The places of diffs in what was seen.
  std::vector<std::size_t> Diffs() const {
    std::vector<std::size_t> places;
    for (std::size_t i = 0; i < transcript.seen.size(); ++i) {
      if (transcript.seen[i].has_diff()) places.push_back(i);
    }
    return places;
  }
  InProcessServer server;
  Transcript transcript;
  Mirror truth;
};

TEST(PromiseCheckers, Ordered) {
  const Story story;
  EXPECT_EQ(CheckOrdered(story.transcript), "");
  const auto diffs = story.Diffs();
  ASSERT_GE(diffs.size(), 4U);
  Transcript swapped = story.transcript;
  std::swap(*swapped.seen[diffs[1]].mutable_diff(), *swapped.seen[diffs[2]].mutable_diff());
  EXPECT_THAT(CheckOrdered(swapped), HasSubstr(kOrdered));
  Transcript twice = story.transcript;
  twice.seen.insert(twice.seen.begin() + static_cast<std::ptrdiff_t>(diffs[2]),
                    twice.seen[diffs[1]]);
  EXPECT_THAT(CheckOrdered(twice), HasSubstr(kOrdered));
  Transcript falling = story.transcript;
  falling.seen.back().set_revision(1);
  EXPECT_THAT(CheckOrdered(falling), HasSubstr(kOrdered));
}

TEST(PromiseCheckers, Atomic) {
  const Story story;
  EXPECT_EQ(CheckAtomic(story.transcript), "");
  // A step of which a part was refused is committed all the same.
  Transcript half = story.transcript;
  const auto refused =
      std::find_if(half.seen.begin(), half.seen.end(), [&](const v1::EditResponse& response) {
        return response.has_rejected() && half.advances.contains(response.update_id());
      });
  ASSERT_NE(refused, half.seen.end()) << "the story has a refused step";
  refused->mutable_advanced()->set_base_revision(2);
  refused->mutable_advanced()->set_revision(3);
  EXPECT_THAT(CheckAtomic(half), HasSubstr(kAtomic));
  // One step in two revisions.
  Transcript split = story.transcript;
  split.seen.back().mutable_advanced()->set_revision(split.seen.back().advanced().base_revision() +
                                                     2);
  EXPECT_THAT(CheckAtomic(split), HasSubstr(kAtomic));
  // A step that is not staged yet, committed all the same.
  Transcript early = story.transcript;
  early.seen.back().mutable_advanced()->set_stop_reason(v1::STOP_REASON_STAGING);
  EXPECT_THAT(CheckAtomic(early), HasSubstr(kAtomic));
  // A refused step that left something behind.
  Transcript leaking = story.transcript;
  for (v1::EditResponse& response : leaking.seen) {
    if (response.has_rejected() && leaking.advances.contains(response.update_id())) {
      response.set_revision(response.revision() + 1);
    }
  }
  EXPECT_THAT(CheckAtomic(leaking), HasSubstr(kAtomic));
}

TEST(PromiseCheckers, Complete) {
  const Story story;
  EXPECT_EQ(CheckComplete(story.transcript, story.truth), "");
  const auto diffs = story.Diffs();
  Transcript gap = story.transcript;
  gap.seen.erase(gap.seen.begin() + static_cast<std::ptrdiff_t>(diffs[1]));
  EXPECT_THAT(CheckComplete(gap, story.truth), HasSubstr(kComplete));
  Transcript bent = story.transcript;
  std::string& positions =
      *bent.seen[diffs[1]].mutable_diff()->mutable_vertex_positions()->mutable_data();
  positions[0] = static_cast<char>(positions[0] ^ 1);  // The last bit of a coordinate.
  EXPECT_THAT(CheckComplete(bent, story.truth), HasSubstr(kComplete));
  Transcript cut = story.transcript;
  cut.seen.resize(diffs.back());
  EXPECT_THAT(CheckComplete(cut, story.truth), HasSubstr(kComplete));
}

// Method: the stream is given up after every possible number of answers; the client opens again at
//         its mirror's revision and repeats what had no answer.
Mirror EditWithBreakAfter(InProcessServer& server, int answers) {
  std::string id;
  EXPECT_TRUE(server.Create(UnitSquare("0.1"), &id).ok());
  Mirror mirror;
  std::int64_t answered = 0;
  const auto run = [&](int answers_max) {
    EditClient edit(server, id, mirror.revision);
    const std::vector<std::string> sizes{"", "0.08", "", "0.06", ""};
    for (std::size_t i = static_cast<std::size_t>(answered); i < sizes.size(); ++i) {
      const auto update = static_cast<std::int64_t>(i + 1);
      if (sizes[i].empty()) {
        edit.Advance(update);
      } else {
        edit.Size(update, sizes[i]);
      }
    }
    for (int seen = 0; seen < answers_max && answered < 5; ++seen) {
      const v1::EditResponse response = edit.Next();
      std::string wrong;
      if (response.has_diff()) wrong = mirror.Apply(response.diff());
      if (response.has_snapshot()) wrong = mirror.Take(response.snapshot());
      EXPECT_EQ(wrong, "");
      if (response.has_accepted() || response.has_advanced()) answered = response.update_id();
    }
    edit.Cancel();
  };
  run(answers);
  for (int tries = 0; answered < 5 && tries < 100; ++tries) run(1000);
  return mirror;
}

TEST(PromiseCheckers, Resumable) {
  InProcessServer server;
  const Mirror whole = EditWithBreakAfter(server, 1000);
  EXPECT_EQ(whole.revision, 3);
  Mirror broken;
  for (int answers = 1; answers <= 8; ++answers) {
    SCOPED_TRACE(answers);
    broken = EditWithBreakAfter(server, answers);
    EXPECT_EQ(CheckResumable(broken, whole), "");
  }
  Mirror applied_twice = broken;
  ++applied_twice.revision;
  EXPECT_THAT(CheckResumable(applied_twice, whole), HasSubstr(kResumable));
  Mirror another = broken;
  another.vertices.begin()->second[0] += 1e-9;
  EXPECT_THAT(CheckResumable(another, whole), HasSubstr(kResumable));
}

/// An engine that meets a bug in its second step.
server::EngineFactory BuggyWhere(const std::string& size) {
  return [size](const server::EngineInput& input) {
    const auto* metric = std::get_if<SizeMetric>(&input.metric.source);
    PLIANT_CHECK(metric == nullptr || metric->size != size, "test", size);
    return server::RemesherFactory()(input);
  };
}

Share Drive(InProcessServer& server, const std::string& id) {
  EditClient edit(server, id);
  edit.Advance(1);
  edit.Size(2, "0.05");
  edit.Advance(3);
  const v1::EditResponse last = edit.Until(3).back();
  return {last.advanced().state_hash(), last.advanced().revision(), !last.has_advanced()};
}

// Method: a neighbour sends bad input, meets a bug, is cancelled and vanishes, and builds a mesh a
//         hundred times as large, all before and while the session works.
TEST(PromiseCheckers, Isolated) {
  InProcessServer alone_server;
  std::string id;
  ASSERT_TRUE(alone_server.Create(UnitSquare("0.1"), &id).ok());
  const Share alone = Drive(alone_server, id);

  InProcessServer server(BuggyWhere("0.123"));
  std::string huge;
  ASSERT_TRUE(server.Create(UnitSquare("0.005"), &huge).ok());
  EditClient huge_edit(server, huge);
  huge_edit.Advance(1);
  std::string bad;
  EXPECT_EQ(server.Create(UnitSquare("0.123"), &bad).error_code(), grpc::StatusCode::INTERNAL);
  ASSERT_TRUE(server.Create(UnitSquare("0.1"), &bad).ok());
  EditClient bad_edit(server, bad);
  bad_edit.Size(1, "0.1 +");
  bad_edit.Size(2, "-1");
  bad_edit.Advance(3);
  EditClient vanishing(server, bad);
  vanishing.Cancel();
  ASSERT_TRUE(server.Create(UnitSquare("0.1"), &id).ok());
  const Share beside = Drive(server, id);
  EXPECT_EQ(CheckIsolated(beside, alone), "");
  huge_edit.Cancel();

  Share ended = beside;
  ended.ended = true;
  EXPECT_THAT(CheckIsolated(ended, alone), HasSubstr(kIsolated));
  Share corrupted = beside;
  ++corrupted.state_hash;
  EXPECT_THAT(CheckIsolated(corrupted, alone), HasSubstr(kIsolated));
}

/// Where a session's engine meets bugs, from when a test says so; and who is told when it has.
struct Bugs {
  std::atomic<bool> in_step = false;
  std::atomic<bool> in_commit = false;
  std::atomic<int> met_count = 0;
};

/// The real engine of a session whose metric is `size`, with bugs; those of other sessions have
/// none.
class EngineWithBugs final : public server::Engine {
 public:
  EngineWithBugs(std::unique_ptr<server::Engine> engine, std::shared_ptr<Bugs> bugs)
      : engine_(std::move(engine)), bugs_(std::move(bugs)) {}

  // Some visits, then a bug in the midst of them.
  Result<Progress> Step(const Budget& budget) override {
    Budget part = budget;
    if (bugs_->in_step) part.visits_max = std::min<std::int64_t>(budget.visits_max, 50);
    Result<Progress> progress = engine_->Step(part);
    Meet(bugs_->in_step);
    return progress;
  }
  MeshDiff Commit() override {
    Meet(bugs_->in_commit);
    return engine_->Commit();
  }
  MeshDiff CommitAndTransfer() override { return Commit(); }

  Status SetMetric(const MetricSpec& metric) override { return engine_->SetMetric(metric); }
  Status SetTensors(std::span<const VertexId> vertices, std::span<const Metric> tensors,
                    const server::TensorTerms& terms) override {
    return engine_->SetTensors(vertices, tensors, terms);
  }
  Status SetLimits(const MetricLimits& limits) override { return engine_->SetLimits(limits); }
  MetricLimits limits() const override { return engine_->limits(); }
  Result<MotionReport> Move(const MotionRequest& request) override {
    return engine_->Move(request);
  }
  std::vector<VertexId> Vertices() const override { return engine_->Vertices(); }
  TroubleSearch WhereTroublesMayBe() const override { return engine_->WhereTroublesMayBe(); }
  std::vector<Trouble> FindTroubles(const TroubleSearch& search) const override {
    return engine_->FindTroubles(search);
  }
  Status SetSolution(const server::SolutionRequest& request,
                     const server::TensorTerms& terms) override {
    return engine_->SetSolution(request, terms);
  }
  Status SetFields(const FieldUpdate& update) override { return engine_->SetFields(update); }
  void Rollback() override { engine_->Rollback(); }
  MeshDiff Snapshot() const override { return engine_->Snapshot(); }
  std::unique_ptr<server::Measurement> Measure(server::MetricBasis basis) const override {
    return engine_->Measure(basis);
  }
  std::vector<std::string> Validate() const override { return engine_->Validate(); }
  Revision revision() const override { return engine_->revision(); }
  std::int32_t vertex_count() const override { return engine_->vertex_count(); }

 private:
  void Meet(std::atomic<bool>& bug) {
    if (!bug) return;
    ++bugs_->met_count;
    PLIANT_CHECK(false, "test", "a bug");
  }
  const std::unique_ptr<server::Engine> engine_;
  const std::shared_ptr<Bugs> bugs_;
};

server::EngineFactory WithBugsWhere(const std::string& size, std::shared_ptr<Bugs> bugs) {
  return [size, bugs](const server::EngineInput& input) -> Result<std::unique_ptr<server::Engine>> {
    PLIANT_ASSIGN_OR_RETURN(std::unique_ptr<server::Engine> engine,
                            server::RemesherFactory()(input));
    const auto* metric = std::get_if<SizeMetric>(&input.metric.source);
    if (metric == nullptr || metric->size != size) return engine;
    return std::unique_ptr<server::Engine>(
        std::make_unique<EngineWithBugs>(std::move(engine), bugs));
  };
}

// Method: one session meets a bug again and again, in the steps of its advances and in their
//         commits, while the other goes on; the other must see what it sees alone, and the first
//         one is told with a reference each time, is where it was, and works once the bug is gone.
TEST(PromiseCheckers, IsolatedFromABugWhileANeighbourWorks) {
  InProcessServer alone_server;
  std::string id;
  ASSERT_TRUE(alone_server.Create(UnitSquare("0.1"), &id).ok());
  const auto drive = [](InProcessServer& server, const std::string& session) {
    EditClient edit(server, session);
    edit.Advance(1);
    std::int64_t update = 1;
    for (int step = 0; step < 12; ++step) {
      edit.Size(++update, step % 2 == 0 ? "0.02" : "0.03");
      edit.Advance(++update);
    }
    const v1::EditResponse last = edit.Until(update).back();
    return Share{last.advanced().state_hash(), last.advanced().revision(), !last.has_advanced()};
  };
  const Share alone = drive(alone_server, id);

  const auto bugs = std::make_shared<Bugs>();
  InProcessServer server(WithBugsWhere("0.2", bugs));
  std::string bad;
  ASSERT_TRUE(server.Create(UnitSquare("0.2"), &bad).ok());
  ASSERT_TRUE(server.Create(UnitSquare("0.1"), &id).ok());
  EditClient edit(server, bad);
  edit.Advance(1);
  const v1::AdvanceResult before = edit.Until(1).back().advanced();
  ASSERT_EQ(before.revision(), 1);

  std::atomic<bool> is_over = false;
  Share beside;
  std::thread neighbour([&] {
    beside = drive(server, id);
    is_over = true;
  });
  std::int64_t update = 1;
  for (int round = 0; round < 4 || (!is_over && round < 100); ++round) {
    bugs->in_step = round % 2 == 0;
    bugs->in_commit = round % 2 == 1;
    edit.Size(++update, "0.05");
    edit.Advance(++update);
    const v1::EditResponse answer = edit.Until(update).back();
    if (!answer.has_rejected()) {
      ADD_FAILURE() << answer.DebugString();
      break;
    }
    EXPECT_EQ(answer.rejected().error().reason(), "INTERNAL");
    EXPECT_NE(answer.rejected().error().reference(), "");
    EXPECT_EQ(answer.revision(), 1) << "back at its last revision";
  }
  neighbour.join();
  EXPECT_GE(bugs->met_count, 4);
  EXPECT_EQ(CheckIsolated(beside, alone), "");

  EXPECT_EQ(Fetch(server, bad).Hash(), before.state_hash()) << "its mesh, too";
  bugs->in_step = bugs->in_commit = false;
  edit.Size(++update, "0.05");
  edit.Advance(++update);
  EXPECT_EQ(edit.Until(update).back().advanced().revision(), 2);
}

// Method: two subscribers, of which one stops reading, while diffs of far more bytes than the bound
//         are made. What is in use afterwards, beyond what it was when the history was full, is
//         what is held for the one that does not read.
TEST(PromiseCheckers, Bounded) {
  constexpr std::int64_t kBytesMax = 24 << 20;
  InProcessServer server;
  std::string id;
  ASSERT_TRUE(server.Create(UnitSquare("0.02"), &id).ok());
  EditClient edit(server, id);
  edit.Advance(1);
  edit.Until(1);
  std::int64_t update = 1;
  std::int64_t diff_bytes = 0;
  const auto steps = [&](int count) {
    for (int i = 0; i < count; ++i) {
      edit.Size(++update, i % 2 == 0 ? "0.025" : "0.02");
      edit.Advance(++update);
      for (const v1::EditResponse& response : edit.Until(update)) {
        if (response.has_diff()) diff_bytes += static_cast<std::int64_t>(response.ByteSizeLong());
      }
    }
  };
  const auto in_use = [] { return static_cast<std::int64_t>(mallinfo2().uordblks); };
  steps(150);  // History and undo data reach their bounds, or nearly.
  SubscribeClient slow(server, id);
  const std::int64_t before = in_use();
  diff_bytes = 0;
  steps(250);
  const std::int64_t held = in_use() - before;
  EXPECT_GT(diff_bytes, kBytesMax) << "too little was sent to tell";
  EXPECT_EQ(CheckBounded(held, kBytesMax), "");
  EXPECT_THAT(CheckBounded(diff_bytes, kBytesMax), HasSubstr(kBounded));
  Mirror mirror;
  EXPECT_EQ(slow.Follow(mirror, Fetch(server, id).revision), "");
}

// The sentences are those that users read.
TEST(PromiseCheckers, SayWhatTheReadmeSays) {
  std::ifstream file(PLIANT_SOURCE_DIR "/proto/README.md");
  std::stringstream text;
  text << file.rdbuf();
  for (const char* promise : {kOrdered, kAtomic, kComplete, kResumable, kIsolated, kBounded}) {
    EXPECT_THAT(text.str(), HasSubstr(promise));
  }
}

}  // namespace
}  // namespace pliant::test
