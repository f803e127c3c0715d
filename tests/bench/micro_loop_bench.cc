// Pieces of the life of a session: visits of the loop, and commit, rollback and snapshot.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "core/pliant/remesher.h"
#include "tests/support/cases.h"

namespace pliant {
namespace {

std::unique_ptr<Remesher> NewGaussian(double nodes, Variant variant) {
  auto gaussian = testing::GaussianCase(nodes);
  auto remesher =
      Remesher::Create(gaussian.domain, std::move(gaussian.field), {.variant = variant});
  PLIANT_CHECK(remesher.ok());
  return std::move(*remesher);
}

// The loop from the triangulated square to the converged mesh: time for each visit, and visits for
// each node of the result.
void BM_Visit(benchmark::State& state, Variant variant) {
  std::int64_t visits = 0;
  std::int64_t nodes = 0;
  for (auto _ : state) {
    state.PauseTiming();
    auto remesher = NewGaussian(static_cast<double>(state.range(0)), variant);
    state.ResumeTiming();
    const auto progress = remesher->Step({});
    state.PauseTiming();
    PLIANT_CHECK(progress.ok());
    visits += progress->counts.visits;
    nodes += remesher->mesh().vertex_count();
    remesher.reset();
    state.ResumeTiming();
  }
  state.counters["s_per_visit"] = benchmark::Counter(
      static_cast<double>(visits), benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["visits_per_node"] = static_cast<double>(visits) / static_cast<double>(nodes);
  state.SetItemsProcessed(nodes);
}
BENCHMARK_CAPTURE(BM_Visit, nested, Variant::kNested)
    ->Arg(10'000)
    ->Arg(100'000)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Visit, cooled, Variant::kCooled)->Arg(10'000)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Visit, paper, Variant::kPaper)->Arg(10'000)->Unit(benchmark::kMillisecond);

/// A session with a committed uniform mesh, and a disc of 0.1 % of it to switch on and off.
class DiscSession {
 public:
  explicit DiscSession(double nodes) : nodes_(nodes) {
    auto disc = testing::DiscCase(nodes, testing::DiscState::kOff);
    auto remesher = Remesher::Create(disc.domain, std::move(disc.field), {});
    PLIANT_CHECK(remesher.ok());
    remesher_ = std::move(*remesher);
    PLIANT_CHECK(remesher_->Step({}).ok());
    (void)remesher_->Commit();
  }

  void Follow(testing::DiscState disc) {
    PLIANT_CHECK(remesher_->SetField(testing::DiscCase(nodes_, disc).field).ok());
    PLIANT_CHECK(remesher_->Step({}).ok());
  }
  Remesher& remesher() { return *remesher_; }

 private:
  double nodes_;
  std::unique_ptr<Remesher> remesher_;
};

// The diff of an update that refines the disc and of one that coarsens it, in turn.
void BM_Commit(benchmark::State& state) {
  DiscSession session(static_cast<double>(state.range(0)));
  bool on = false;
  std::size_t changed = 0;
  for (auto _ : state) {
    state.PauseTiming();
    on = !on;
    session.Follow(on ? testing::DiscState::kOn : testing::DiscState::kOff);
    state.ResumeTiming();
    const MeshDiff diff = session.remesher().Commit();
    changed += diff.vertex_ids.size() + diff.removed_vertices.size();
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(changed));
  state.counters["nodes_changed"] =
      static_cast<double>(changed) / static_cast<double>(state.iterations());
}
BENCHMARK(BM_Commit)->Arg(10'000)->Arg(100'000)->Unit(benchmark::kMicrosecond)->Iterations(200);

void BM_Rollback(benchmark::State& state) {
  DiscSession session(static_cast<double>(state.range(0)));
  for (auto _ : state) {
    state.PauseTiming();
    session.Follow(testing::DiscState::kOn);
    state.ResumeTiming();
    session.remesher().Rollback();
  }
}
BENCHMARK(BM_Rollback)->Arg(10'000)->Arg(100'000)->Unit(benchmark::kMicrosecond)->Iterations(200);

// The same field again through SetField, which cannot know that it is the same: what it costs to
// find out, per node.
void BM_UnchangedField(benchmark::State& state) {
  DiscSession session(static_cast<double>(state.range(0)));
  for (auto _ : state) session.Follow(testing::DiscState::kOff);
  state.SetItemsProcessed(state.iterations() * session.remesher().mesh().vertex_count());
}
BENCHMARK(BM_UnchangedField)->Arg(10'000)->Unit(benchmark::kMicrosecond);

void BM_Snapshot(benchmark::State& state) {
  DiscSession session(static_cast<double>(state.range(0)));
  for (auto _ : state) {
    benchmark::DoNotOptimize(SnapshotOf(session.remesher().mesh(), session.remesher().revision()));
  }
  state.SetItemsProcessed(state.iterations() * session.remesher().mesh().vertex_count());
}
BENCHMARK(BM_Snapshot)->Arg(10'000)->Arg(100'000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pliant
