// Goal: whatever domain replaces another one, the mesh is a valid triangulation of the new one, and
// what both have in common keeps its ids and its bits.
// Method: sequences of random domains made of the cells of a grid (holes appear, merge and vanish,
// loops touch, parts come apart, regions change, segments are joined and cut), and of domains that
// have nothing to do with each other; on meshes before and after the loop. Areas are sums over
// cells, kept vertices are found cell by cell.
//
//   PLIANT_SEED=17 core_tests --gtest_filter='*RandomDomainSwaps*'   replays the session of a
//   failure PLIANT_LONG_TESTS=1                                          25 times as many

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/validate.h"
#include "core/motion/replace_domain.h"
#include "tests/support/cell_domain.h"
#include "tests/support/mesh_testing.h"
#include "tests/support/random_domain.h"
#include "tests/support/seed.h"

namespace pliant {
namespace {

using testing::CellDomain;
using testing::Faults;

constexpr std::uint64_t kParts = 4;
constexpr test::Seeds kCells = {.count = 200, .long_count = 5000, .part_count = kParts};
constexpr test::Seeds kOthers = {.count = 100, .long_count = 2500, .part_count = kParts};
constexpr double kAreaTolerance = 1e-11;  // Of sums of some thousand terms of size 1.

MetricSpec Size(const std::string& size) {
  MetricSpec spec;
  spec.source = SizeMetric{size};
  return spec;
}

struct Known {
  VertexId id;
  Vec2 position;
};

std::vector<Known> KnownVertices(const Mesh& mesh) {
  std::vector<Known> known;
  for (const VertexId id : testing::LiveVertices(mesh)) known.push_back({id, mesh.position(id)});
  return known;
}

void ExpectSums(const std::map<std::int32_t, double>& wanted,
                const std::map<std::int32_t, double>& found, const char* what) {
  ASSERT_EQ(found.size(), wanted.size()) << what;
  for (const auto& [tag, size] : wanted) {
    ASSERT_TRUE(found.contains(tag)) << what << " " << tag;
    ASSERT_NEAR(found.at(tag), size, kAreaTolerance) << what << " " << tag;
  }
}

class CellSession {
 public:
  explicit CellSession(std::uint64_t seed)
      : rng_(seed * 2654435761U + 11), cells_(static_cast<std::int32_t>(2 + rng_.Below(4)), rng_) {}

  void Run() {
    static const char* const kSizes[] = {"0.5", "0.09", "0.03+0.2*abs(x-y)"};
    auto made = Remesher::Create(cells_.domain(), Size(kSizes[rng_.Below(3)]), {});
    ASSERT_TRUE(made.ok()) << made.error().message;
    remesher_ = std::move(*made);
    Settle();
    const int updates = 2 + static_cast<int>(rng_.Below(3));
    for (int i = 0; i < updates && !::testing::Test::HasFatalFailure(); ++i) {
      SCOPED_TRACE("update " + std::to_string(i));
      Replace();
      if (rng_.Below(4) == 0) Replace();  // Twice within a revision.
      if (!::testing::Test::HasFatalFailure()) End();
    }
  }

 private:
  void Replace() {
    cells_.Change(rng_);
    const std::vector<Known> before = KnownVertices(remesher_->mesh());
    const auto report = ReplaceDomain(*remesher_, cells_.domain());
    ASSERT_TRUE(report.ok()) << report.error().message;
    CheckDomain(*report);
    for (const Known& known : before) {
      if (!cells_.HoldsInside(known.position) && !cells_.HoldsOnSegment(known.position)) continue;
      ASSERT_TRUE(remesher_->mesh().IsLive(known.id)) << known.id;
      ASSERT_EQ(remesher_->mesh().position(known.id), known.position) << known.id;
    }
    for (std::int32_t i = 0; i < remesher_->mesh().vertex_slots(); ++i) {
      const VertexRecord& vertex = remesher_->mesh().vertex(VertexId(i));
      if (!vertex.live || vertex.edge.valid()) continue;
      ASSERT_TRUE(cells_.HoldsInside(vertex.position)) << i;
    }
  }

  void CheckDomain(const DomainReport& report) {
    const Mesh& mesh = remesher_->mesh();
    ASSERT_EQ(Faults(mesh), "");
    ASSERT_NEAR(Area(mesh), cells_.area(), kAreaTolerance);
    ExpectSums(cells_.region_areas(), testing::RegionAreas(mesh), "region");
    ExpectSums(cells_.tag_lengths(), testing::TagLengths(mesh), "tag");
    const auto& points = cells_.domain().points;
    ASSERT_EQ(report.vertex_of_point.size(), points.size());
    std::size_t fixed_count = 0;
    for (const VertexId id : testing::LiveVertices(mesh)) fixed_count += mesh.vertex(id).fixed;
    ASSERT_EQ(fixed_count, points.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      ASSERT_EQ(mesh.position(report.vertex_of_point[i]), points[i]);
      ASSERT_TRUE(mesh.vertex(report.vertex_of_point[i]).fixed);
    }
  }

  /// Runs the loop, or not, and commits or rolls back.
  void End() {
    if (rng_.Below(4) != 0) {
      const auto progress = remesher_->Step({.visits_max = 1'000'000});
      ASSERT_TRUE(progress.ok()) << progress.error().message;
      ASSERT_EQ(progress->stop_reason, StopReason::kConverged);
      ASSERT_EQ(Faults(remesher_->mesh()), "");
      ASSERT_NEAR(Area(remesher_->mesh()), cells_.area(), kAreaTolerance);
      ExpectSums(cells_.region_areas(), testing::RegionAreas(remesher_->mesh()), "region");
    }
    if (rng_.Below(4) == 0) {
      remesher_->Rollback();
      ASSERT_EQ(Faults(remesher_->mesh()), "");
      ASSERT_EQ(testing::DifferenceOf(remesher_->mesh(), committed_->mesh()), "");
      return;
    }
    Commit();
  }

  void Settle() {
    const auto progress = remesher_->Step({.visits_max = 1'000'000});
    ASSERT_TRUE(progress.ok()) << progress.error().message;
    Commit();
  }

  void Commit() {
    const MeshDiff diff = remesher_->CommitAndTransfer();
    ASSERT_EQ(replica_.Apply(diff), "");
    ASSERT_EQ(replica_.DifferenceTo(remesher_->mesh()), "");
    const auto saved = remesher_->Save();
    ASSERT_TRUE(saved.ok()) << saved.error().message;
    auto loaded = Remesher::Load(*saved);
    ASSERT_TRUE(loaded.ok()) << loaded.error().message;
    committed_ = std::move(*loaded);
    ASSERT_EQ(testing::DifferenceOf(remesher_->mesh(), committed_->mesh()), "");
  }

  Rng rng_;
  CellDomain cells_;
  std::unique_ptr<Remesher> remesher_;
  std::unique_ptr<Remesher> committed_;  // As it was saved at the last commit.
  testing::Replica replica_;
};

class RandomDomainSwaps : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(RandomDomainSwaps, OfCellsKeepWhatTheyHaveInCommon) {
  for (const std::uint64_t seed : kCells.OfPart(GetParam())) {
    SCOPED_TRACE(test::Replay(seed, "core_tests", "*RandomDomainSwaps*Cells*/0"));
    CellSession(seed).Run();
    if (HasFailure()) return;
  }
}

// Domains of triangulated clusters, with gaps down to 1e-6; two of them have no more in common than
// chance wants.
TEST_P(RandomDomainSwaps, OfOtherKindsReplaceEachOther) {
  for (const std::uint64_t seed : kOthers.OfPart(GetParam())) {
    SCOPED_TRACE(test::Replay(seed, "core_tests", "*RandomDomainSwaps*Other*/0"));
    const testing::RandomCase first = testing::MakeRandomCase(seed);
    const testing::RandomCase second = testing::MakeRandomCase(seed + 1'000'000);
    auto made = Remesher::Create(first.domain, Size("0.1"), {});
    ASSERT_TRUE(made.ok()) << made.error().message;
    Remesher& remesher = **made;
    if (seed % 2 == 0) {
      ASSERT_TRUE(remesher.Step({.visits_max = 20'000}).ok());
    }
    (void)remesher.Commit();
    for (const testing::RandomCase* next : {&second, &first}) {
      const auto report = ReplaceDomain(remesher, next->domain);
      ASSERT_TRUE(report.ok()) << report.error().message;
      ASSERT_EQ(Faults(remesher.mesh()), "");
      const double tolerance = 1e-9 * next->extent * next->extent;
      ASSERT_NEAR(Area(remesher.mesh()), next->area, tolerance);
      const auto regions = testing::RegionAreas(remesher.mesh());
      ASSERT_EQ(regions.size(), next->region_areas.size());
      for (const auto& [tag, area] : next->region_areas) {
        ASSERT_NEAR(regions.at(tag), area, tolerance);
      }
      const auto tags = testing::TagLengths(remesher.mesh());
      ASSERT_EQ(tags.size(), next->tag_lengths.size());
      for (const auto& [tag, length] : next->tag_lengths) {
        ASSERT_NEAR(tags.at(tag), length, 1e-9 * next->extent);
      }
      (void)remesher.CommitAndTransfer();
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Part, RandomDomainSwaps, ::testing::Range<std::uint64_t>(0, kParts));

}  // namespace
}  // namespace pliant
