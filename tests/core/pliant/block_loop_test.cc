// Blocks: the same bits for any executor, valid meshes with borders anywhere.
//
//   PLIANT_SEED=17 core_tests --gtest_filter='*BlockDomains*'   replays the domain of a failure
//   PLIANT_LONG_TESTS=1                                         50 times as many
#include "core/pliant/block_loop.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/validate.h"
#include "core/metric/function_field.h"
#include "core/pliant/quality.h"
#include "core/pliant/remesher.h"
#include "core/threads/thread_pool.h"
#include "tests/support/backward_executor.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"
#include "tests/support/random_domain.h"
#include "tests/support/seed.h"

namespace pliant {
namespace {

using testing::Case;
using testing::Faults;

/// Small blocks, so that a mesh of some thousand nodes has many and most nodes are near a border.
constexpr BlockRule kSmallBlocks = {.nodes_min = 600, .nodes_per_block = 150};
constexpr BlockRule kTinyBlocks = {.nodes_min = 60, .nodes_per_block = 16};

std::unique_ptr<Remesher> Start(Case test_case, const Helpers& helpers,
                                const Options& options = {}) {
  auto remesher = Remesher::Create(test_case.domain, std::move(test_case.field), options);
  EXPECT_TRUE(remesher.ok());
  remesher.value()->UseHelpers(helpers);
  return std::move(remesher).value();
}

/// What a build came to: two are the same mesh by the same way if these are equal.
struct Outcome {
  std::uint64_t state_hash = 0;
  LoopCounts counts;

  friend bool operator==(const Outcome&, const Outcome&) = default;
};

Outcome Finish(Remesher& remesher) {
  const Result<Progress> progress = remesher.Step({});
  EXPECT_TRUE(progress.ok());
  EXPECT_EQ(progress->active_count, 0);
  EXPECT_EQ(Faults(remesher.mesh()), "");
  return {remesher.Commit().summary.state_hash, progress->counts};
}

/// Counts the tasks of the calls with more than one.
class CountingExecutor final : public Executor {
 public:
  void Run(std::int32_t count, const Task& task) override {
    if (count > 1) task_count += count;
    InlineExecutor().Run(count, task);
  }
  int task_count = 0;
};

// Goal: the bits depend on neither the number of threads nor the order of the blocks.
// Method: each case with the calling thread alone, backwards, and with 1, 2, 3 and 8 threads; the
// first with the rule that ships, at a size that is over its threshold on two levels.
TEST(BlockLoop, GivesTheSameBitsWithAnyExecutor) {
  struct Run {
    const char* name;
    std::function<Case()> make;
    BlockRule rule;
  };
  const Run runs[] = {
      {"gaussian", [] { return testing::GaussianCase(150'000); }, {}},
      {"shock", [] { return testing::ShockCase(9'000); }, kSmallBlocks},
      {"sharp shock", [] { return testing::SharpShockCase(9'000); }, kSmallBlocks},
      {"checkerboard", [] { return testing::CheckerboardCase(); }, kSmallBlocks},
  };
  for (const Run& run : runs) {
    SCOPED_TRACE(run.name);
    CountingExecutor counting;
    const Outcome alone = Finish(*Start(run.make(), Helpers(&counting, run.rule)));
    EXPECT_GT(counting.task_count, 4);
    testing::BackwardExecutor backwards;
    EXPECT_EQ(Finish(*Start(run.make(), Helpers(&backwards, run.rule))), alone);
    EXPECT_EQ(Finish(*Start(run.make(), Helpers(nullptr, run.rule))), alone);
    for (const int thread_count : {1, 2, 3, 8}) {
      SCOPED_TRACE(thread_count);
      ThreadPool threads(thread_count);
      EXPECT_EQ(Finish(*Start(run.make(), Helpers(&threads, run.rule))), alone);
    }
  }
}

// Goal: blocks cost no quality that matters, and no visits. Method: the same case without and with.
TEST(BlockLoop, IsAsGoodAsTheLoopOnTheWholeMesh) {
  const auto measure = [](const BlockRule& rule) {
    const auto remesher = Start(testing::GaussianCase(20'000), Helpers(nullptr, rule));
    const Outcome outcome = Finish(*remesher);
    return std::pair(MeasureQuality(remesher->mesh(), remesher->field()), outcome.counts.visits);
  };
  const auto [whole, whole_visits] = measure({});
  const auto [blocks, block_visits] = measure({.nodes_min = 4'000, .nodes_per_block = 500});
  EXPECT_GT(blocks.q_mean, whole.q_mean - 0.001);
  EXPECT_GT(blocks.q_min, 0.6);
  EXPECT_LT(static_cast<double>(block_visits), 1.05 * static_cast<double>(whole_visits));
}

// Goal: a budget stops the blocks at a valid mesh with right counts, and cuts change nothing.
TEST(BlockLoop, DoesNotDependOnHowARunIsCutIntoBudgets) {
  const auto make = [] {
    return Start(testing::GaussianCase(4'000), Helpers(nullptr, kSmallBlocks));
  };
  const Outcome whole = Finish(*make());
  for (const std::int64_t visits_max : {7, 1'000, 3'001}) {
    const auto remesher = make();
    Progress progress;
    std::int64_t visits = 0;
    do {
      progress = *remesher->Step({.visits_max = visits_max});
      EXPECT_LE(progress.counts.visits, visits + visits_max);
      visits = progress.counts.visits;
      if (visits_max > 7) {
        ASSERT_EQ(Faults(remesher->mesh()), "");
      }
      EXPECT_EQ(progress.active_count > 0, progress.stop_reason == StopReason::kVisitBudget);
    } while (progress.stop_reason == StopReason::kVisitBudget);
    EXPECT_EQ((Outcome{remesher->Commit().summary.state_hash, progress.counts}), whole);
  }
}

// Goal: a commit in the midst of the blocks loses no active node, and a cancel stops them.
TEST(BlockLoop, CanBeLeftAtAnyPoint) {
  for (const std::int64_t visits : {3'000, 5'000, 6'000, 9'000, 10'000, 11'000}) {
    const auto remesher = Start(testing::GaussianCase(4'000), Helpers(nullptr, kSmallBlocks));
    ASSERT_EQ(remesher->Step({.visits_max = visits})->stop_reason, StopReason::kVisitBudget);
    const StopFlag stop(true);
    EXPECT_EQ(remesher->Step({.stop = &stop})->stop_reason, StopReason::kCancelled);
    remesher->Commit();
    ASSERT_EQ(Faults(remesher->mesh()), "");
    ASSERT_EQ(remesher->Step({})->stop_reason, StopReason::kConverged);
    ASSERT_EQ(Faults(remesher->mesh()), "");
    for (const VertexId id : testing::LiveVertices(remesher->mesh())) {
      ASSERT_FALSE(remesher->mesh().vertex(id).visit.active) << "after " << visits << " visits";
    }
    EXPECT_NEAR(remesher->mesh().vertex_count(), 4'000, 300);
    EXPECT_GT(MeasureQuality(remesher->mesh(), remesher->field()).q_mean, 0.96);
  }
}

// Goal: where the border lies does not matter: domains with holes, touching loops, constraints and
// regions in blocks of some 16 nodes stay valid triangulations of the domain, with the same bits on
// one thread and on three. Method: random domains; most nodes are next to a border.
TEST(BlockDomains, StayValidWithBordersEverywhere) {
  ThreadPool threads(3);
  std::size_t in_blocks = 0;
  const auto seeds = test::Seeds{.count = 40, .long_count = 2000}.OfPart(0);
  for (const std::uint64_t seed : seeds) {
    const testing::RandomCase random = testing::MakeRandomCase(seed);
    SCOPED_TRACE(test::Replay(seed, "core_tests", "*BlockDomains*"));
    // The random metrics make most domains a few elements wide, and such meshes are not nested;
    // every other domain gets a constant size.
    const auto metric = [&]() -> std::unique_ptr<MetricField> {
      if (seed % 2 == 0) return testing::RandomMetric(random, 5'000, seed);
      const Metric constant = Metric::Isotropic(std::sqrt(random.area / 3'000));
      const auto function = [constant](Vec2) { return constant; };
      return std::make_unique<FunctionField<decltype(function)>>(function);
    };
    const auto start = [&](Executor* executor) {
      return Start({random.domain, metric()}, Helpers(executor, kTinyBlocks),
                   {.vertices_max = 12'000});
    };
    CountingExecutor counting;
    const auto remesher = start(&counting);
    Result<Progress> progress = remesher->Step({.visits_max = 2'000});
    for (int step = 0; step < 40 && progress->stop_reason == StopReason::kVisitBudget; ++step) {
      ASSERT_EQ(Faults(remesher->mesh()), "") << "after step " << step;
      progress = remesher->Step({.visits_max = 5'000});
    }
    const Outcome alone = Finish(*remesher);
    in_blocks += counting.task_count > 0 ? 1 : 0;
    EXPECT_NEAR(Area(remesher->mesh()), random.area, 1e-12 * random.extent * random.extent);
    const auto areas = testing::RegionAreas(remesher->mesh());
    for (const auto& [region, area] : random.region_areas) {
      ASSERT_TRUE(areas.contains(region)) << "region " << region;
      EXPECT_NEAR(areas.at(region), area, 1e-12 * random.extent * random.extent);
    }
    for (std::size_t i = 0; i < random.domain.points.size(); ++i) {
      EXPECT_EQ(remesher->mesh().position(VertexId::FromIndex(i)), random.domain.points[i]);
    }
    EXPECT_EQ(Finish(*start(&threads)), alone);
    if (HasFatalFailure()) return;
  }
  if (seeds.size() > 1) {
    EXPECT_GT(in_blocks, seeds.size() / 3);
  }
}

// Goal: as Remesher.GivesTheGoldenHashes, for a mesh that is large enough for blocks.
TEST(BlockLoop, GivesTheGoldenHash) {
  const auto remesher = Start(testing::GaussianCase(150'000), Helpers());
  EXPECT_EQ(Finish(*remesher).state_hash, 10275217910943385072U);
}

}  // namespace
}  // namespace pliant
