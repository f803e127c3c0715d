// Goal: whatever the domain and the metric, the loop ends, and the mesh is a valid triangulation of
// the domain: same area, same regions, every segment covered by edges that carry its tag.
// Method: random domains and metrics (tests/support/random_domain.h); nothing here knows how the
// meshes are made. One seed makes one domain.
//
//   PLIANT_SEED=17 core_tests --gtest_filter='*RandomDomains*'   replays the domain of a failure
//   PLIANT_LONG_TESTS=1                                          50 times as many

#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/pliant/remesher.h"
#include "tests/support/mesh_testing.h"
#include "tests/support/random_domain.h"
#include "tests/support/seed.h"

namespace pliant {
namespace {

using testing::Faults;
using testing::FaultsAgainst;
using testing::MakeRandomCase;
using testing::RandomCase;
using testing::RandomMetric;

constexpr std::uint64_t kParts = 8;
constexpr test::Seeds kMany = {.count = 1'000, .long_count = 50'000, .part_count = kParts};
constexpr test::Seeds kFew = {.count = 100, .long_count = 5'000, .part_count = kParts};
constexpr std::int64_t kVisitsMax = 5'000'000;  // Far above what any of them needs.

Options RandomOptions(Rng& rng) {
  Options options;
  options.vertices_max = 4'000;
  if (rng.Below(8) == 0) options.smoothing = Smoothing::kLaplacian;
  if (rng.Below(8) == 0) options.smoothing = Smoothing::kBubble;
  if (rng.Below(8) == 0) options.smoothing = Smoothing::kLennardJones;
  if (rng.Below(10) == 0) options.permissions.swap = false;
  if (rng.Below(10) == 0) options.permissions.move = false;
  return options;
}

void ExpectAnEnd(Remesher& remesher) {
  const auto progress = remesher.Step({.visits_max = kVisitsMax});
  ASSERT_TRUE(progress.ok()) << progress.error().message;
  EXPECT_TRUE(progress->stop_reason == StopReason::kConverged ||
              progress->stop_reason == StopReason::kVertexLimit)
      << "it did not end within " << kVisitsMax << " visits";
  EXPECT_EQ(progress->active_count, 0);
  EXPECT_LE(remesher.mesh().vertex_count(), remesher.options().vertices_max);
}

class RandomDomains : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(RandomDomains, EndWithAValidMesh) {
  for (const std::uint64_t seed : kMany.OfPart(GetParam())) {
    const RandomCase random = MakeRandomCase(seed);
    std::string description;
    auto field = RandomMetric(random, 300, seed, &description);
    SCOPED_TRACE(::testing::Message()
                 << description << "; "
                 << test::Replay(seed, "core_tests", "*RandomDomains.EndWithAValidMesh/0"));
    Rng rng(seed);
    auto made = Remesher::Create(random.domain, std::move(field), RandomOptions(rng));
    ASSERT_TRUE(made.ok()) << made.error().message << ' ' << made.error().index;
    EXPECT_EQ(FaultsAgainst(random, (*made)->mesh()), "");
    ExpectAnEnd(**made);
    (void)(*made)->Commit();
    EXPECT_EQ(FaultsAgainst(random, (*made)->mesh()), "");
    if (HasFailure()) return;
  }
}

INSTANTIATE_TEST_SUITE_P(All, RandomDomains, ::testing::Range<std::uint64_t>(0, kParts));

class PaperOnRandomDomains : public ::testing::TestWithParam<std::uint64_t> {};

// The paper's loop need not converge; it must stop at its limit and be valid at any time.
TEST_P(PaperOnRandomDomains, StopsWithAValidMesh) {
  for (const std::uint64_t seed : kFew.OfPart(GetParam())) {
    const RandomCase random = MakeRandomCase(seed);
    SCOPED_TRACE(test::Replay(seed, "core_tests", "*PaperOnRandomDomains.StopsWithAValidMesh/0"));
    Options options;
    options.variant = Variant::kPaper;
    options.seed = seed;
    options.vertices_max = 4'000;
    options.visits_per_vertex_max = 60;
    auto made = Remesher::Create(random.domain, RandomMetric(random, 100, seed), options);
    ASSERT_TRUE(made.ok()) << made.error().message;
    const auto progress = (*made)->Step({.visits_max = kVisitsMax});
    ASSERT_TRUE(progress.ok());
    EXPECT_NE(progress->stop_reason, StopReason::kVisitBudget);
    EXPECT_EQ(FaultsAgainst(random, (*made)->mesh()), "");
    if (HasFailure()) return;
  }
}

INSTANTIATE_TEST_SUITE_P(All, PaperOnRandomDomains, ::testing::Range<std::uint64_t>(0, kParts));

/// One session with random updates, budgets, commits and rollbacks, and a replica that follows.
class UpdateCampaign {
 public:
  explicit UpdateCampaign(std::uint64_t seed)
      : seed_(seed), rng_(seed), random_(MakeRandomCase(seed)) {}

  void Run() {
    Options options;
    options.vertices_max = 4'000;
    auto made = Remesher::Create(random_.domain, RandomMetric(random_, 200, seed_), options);
    ASSERT_TRUE(made.ok()) << made.error().message;
    remesher_ = std::move(*made);
    if (rng_.Below(2) == 0) ExpectAnEnd(*remesher_);
    Commit();
    for (int round = 0; round < 6 && !::testing::Test::HasFailure(); ++round) {
      SCOPED_TRACE(::testing::Message() << "round " << round);
      Update();
      Advance();
      if (rng_.Below(3) == 0) {
        RollBack();
      } else {
        Commit();
      }
    }
    ExpectAnEnd(*remesher_);
    Commit();
    EXPECT_EQ(FaultsAgainst(random_, remesher_->mesh()), "");
  }

 private:
  void Update() {
    if (rng_.Below(2) == 0) {
      ASSERT_TRUE(remesher_->SetField(RandomMetric(random_, 200, rng_.Next())).ok());
      return;
    }
    const std::vector<VertexId> live = testing::LiveVertices(remesher_->mesh());
    std::vector<VertexId> vertices;
    std::vector<Metric> tensors;
    for (const VertexId id : live) {
      if (rng_.Below(4) != 0) continue;
      vertices.push_back(id);
      tensors.push_back(rng_.Uniform(0.5, 2) * remesher_->mesh().metric(id));
    }
    if (vertices.empty()) return;
    const Status status = remesher_->SetTensors(vertices, tensors);
    ASSERT_TRUE(status.ok()) << status.error().message;
  }

  void Advance() {
    for (std::uint64_t steps = rng_.Below(4); steps > 0; --steps) {
      const auto budget = static_cast<std::int64_t>(1 + rng_.Below(2'000));
      ASSERT_TRUE(remesher_->Step({.visits_max = budget}).ok());
      EXPECT_EQ(Faults(remesher_->mesh()), "");
    }
  }

  void Commit() {
    const MeshDiff diff = remesher_->Commit();
    EXPECT_EQ(replica_.Apply(diff), "");
    EXPECT_EQ(replica_.DifferenceTo(remesher_->mesh()), "");
    EXPECT_EQ(diff.summary, SnapshotOf(remesher_->mesh(), diff.revision).summary);
    committed_ = remesher_->mesh();
  }

  void RollBack() {
    remesher_->Rollback();
    EXPECT_EQ(testing::DifferenceOf(remesher_->mesh(), committed_), "");
  }

  std::uint64_t seed_;
  Rng rng_;
  RandomCase random_;
  std::unique_ptr<Remesher> remesher_;
  testing::Replica replica_;
  Mesh committed_;
};

class UpdatesOfRandomDomains : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(UpdatesOfRandomDomains, KeepTheReplicaEqualAndTheMeshValid) {
  for (const std::uint64_t seed : kFew.OfPart(GetParam())) {
    SCOPED_TRACE(test::Replay(seed, "core_tests",
                              "*UpdatesOfRandomDomains.KeepTheReplicaEqualAndTheMeshValid/0"));
    UpdateCampaign(seed).Run();
    if (HasFailure()) return;
  }
}

INSTANTIATE_TEST_SUITE_P(All, UpdatesOfRandomDomains, ::testing::Range<std::uint64_t>(0, kParts));

}  // namespace
}  // namespace pliant
