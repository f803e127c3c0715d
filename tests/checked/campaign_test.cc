// Goal: no operation on any domain under any metric leaves a mesh that is not valid, and no visit
// breaks what the proof of termination rests on.
// Method: random sessions (domain, options, metric, updates, budgets, commits, rollbacks) on the
// core that checks itself: MeshEdit checks every triangle that an operation touched and their
// neighbours, PliantLoop the ages and the potential around every visit (kValidateEvery). An
// operation is one call of MeshEdit that changes connectivity or a position. At every commit
// Validate looks at the whole mesh and the domain is compared. One seed makes one session.
//
//   PLIANT_SEED=17 checked_tests --gtest_filter='*Campaign*/0'   replays the session of a failure
//   PLIANT_LONG_TESTS=1                                          10,000 sessions instead of 500
//   PLIANT_OPERATIONS=1e8    goes on, in `LongRun`, until so many operations have been validated

#include <gtest/gtest.h>

#include <cstdlib>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "core/base/check.h"
#include "core/base/rng.h"
#include "core/mesh/validate_local.h"
#include "core/pliant/remesher.h"
#include "tests/support/mesh_testing.h"
#include "tests/support/random_domain.h"
#include "tests/support/seed.h"

namespace pliant {
namespace {

using testing::FaultsAgainst;
using testing::MakeRandomCase;
using testing::RandomCase;
using testing::RandomMetric;

static_assert(kValidateEvery, "this program must be built with PLIANT_VALIDATE_EVERY");

constexpr std::uint64_t kParts = 10;
constexpr test::Seeds kSeeds = {.count = 500, .long_count = 10'000, .part_count = kParts};
constexpr std::int64_t kVisitsMax = 5'000'000;  // Far above what any of them needs.

Options RandomOptions(Rng& rng) {
  Options options;
  options.vertices_max = 3'000;
  if (rng.Below(4) == 0) options.variant = Variant::kCooled;
  if (rng.Below(10) == 0) {
    options.variant = Variant::kPaper;
    options.visits_per_vertex_max = 40;
  }
  if (rng.Below(10) == 0) options.smoothing = Smoothing::kLaplacian;
  if (rng.Below(10) == 0) options.smoothing = Smoothing::kBubble;
  if (rng.Below(10) == 0) options.smoothing = Smoothing::kLennardJones;
  if (rng.Below(10) == 0) options.permissions.swap = false;
  if (rng.Below(10) == 0) options.permissions.move = false;
  if (rng.Below(10) == 0) options.hops_max = 2;
  if (rng.Below(10) == 0) {
    options.age_cooling = 3;
    options.age_max = 6;
  }
  return options;
}

class RandomSession {
 public:
  explicit RandomSession(std::uint64_t seed)
      : seed_(seed), rng_(seed ^ 0x63616d70), random_(MakeRandomCase(seed)) {}

  void Run() {
    const Options options = RandomOptions(rng_);
    auto made = Remesher::Create(random_.domain, RandomMetric(random_, 150, seed_), options);
    ASSERT_TRUE(made.ok()) << made.error().message;
    remesher_ = std::move(*made);
    if (rng_.Below(4) != 0) RunToTheEnd();
    Commit();
    for (std::uint64_t rounds = 1 + rng_.Below(4); rounds > 0; --rounds) {
      if (::testing::Test::HasFailure()) return;
      Update();
      const auto budget = static_cast<std::int64_t>(1 + rng_.Below(3'000));
      ASSERT_TRUE(remesher_->Step({.visits_max = budget}).ok());
      if (rng_.Below(4) == 0) {
        remesher_->Rollback();
        EXPECT_EQ(testing::DifferenceOf(remesher_->mesh(), committed_), "");
      } else {
        Commit();
      }
    }
    RunToTheEnd();
    Commit();
  }

 private:
  void Update() {
    if (rng_.Below(2) == 0) {
      ASSERT_TRUE(remesher_->SetField(RandomMetric(random_, 150, rng_.Next())).ok());
      return;
    }
    std::vector<VertexId> vertices;
    std::vector<Metric> tensors;
    for (const VertexId id : testing::LiveVertices(remesher_->mesh())) {
      if (rng_.Below(4) != 0) continue;
      vertices.push_back(id);
      tensors.push_back(rng_.Uniform(0.3, 3) * remesher_->mesh().metric(id));
    }
    if (vertices.empty()) return;
    const Status status = remesher_->SetTensors(vertices, tensors);
    ASSERT_TRUE(status.ok()) << status.error().message;
  }

  void RunToTheEnd() {
    const auto progress = remesher_->Step({.visits_max = kVisitsMax});
    ASSERT_TRUE(progress.ok()) << progress.error().message;
    EXPECT_NE(progress->stop_reason, StopReason::kVisitBudget);
  }

  void Commit() {
    (void)remesher_->Commit();
    EXPECT_EQ(FaultsAgainst(random_, remesher_->mesh()), "");
    committed_ = remesher_->mesh();
  }

  std::uint64_t seed_;
  Rng rng_;
  RandomCase random_;
  std::unique_ptr<Remesher> remesher_;
  Mesh committed_;
};

void RunSession(std::uint64_t seed) {
  SCOPED_TRACE(test::Replay(seed, "checked_tests", "*Campaign*/0"));
  try {
    RandomSession(seed).Run();
  } catch (const InvariantViolation& violation) {
    ADD_FAILURE() << violation.what();
  }
}

class Campaign : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(Campaign, EveryOperationIsValidAndEveryVisitFalls) {
  for (const std::uint64_t seed : kSeeds.OfPart(GetParam())) {
    RunSession(seed);
    if (HasFailure()) return;
  }
  if (std::getenv("PLIANT_SEED") != nullptr) return;
  RecordProperty("validated_operations", std::to_string(ValidatedOperationCount()));
  EXPECT_GT(ValidatedOperationCount(), 100'000);
}

INSTANTIATE_TEST_SUITE_P(All, Campaign, ::testing::Range<std::uint64_t>(0, kParts));

TEST(LongRun, ValidatesAsManyOperationsAsAsked) {
  const char* asked = std::getenv("PLIANT_OPERATIONS");
  // Few unless asked, so that the way to ask is tested too.
  const auto wanted = static_cast<std::int64_t>(std::strtod(asked ? asked : "1e5", nullptr));
  const char* first = std::getenv("PLIANT_SEED");
  std::uint64_t seed = first == nullptr ? 1'000'000 : std::strtoull(first, nullptr, 10);
  std::uint64_t count = 0;
  while (ValidatedOperationCount() < wanted && !HasFailure()) {
    RunSession(seed++);
    if (++count % 1'000 == 0) {
      std::cout << count << " sessions, " << ValidatedOperationCount() << " operations"
                << std::endl;
    }
  }
  std::cout << count << " sessions, " << ValidatedOperationCount() << " operations" << std::endl;
  EXPECT_GT(count, 0U);
}

}  // namespace
}  // namespace pliant
