#include "core/transfer/overlap.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/random_transfer.h"

namespace pliant {
namespace {

/// What coordinates of size 10 leave unknown of an area: random edits make triangles of any height.
double Rounding(const std::array<Vec2, 3>& corners) {
  double length = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    length = std::max(length, Length(corners[(i + 1) % 3] - corners[i]));
  }
  return 4e-15 * length;
}

// Goal: the overlaps are a common refinement: they cover each new triangle and each old one.
TEST(OverlapFinder, CoversEveryTriangleOfBothMeshes) {
  for (const MeshData& data : {testing::GridData(9, 8), testing::ThinGrid()}) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      SCOPED_TRACE(::testing::Message() << "seed " << seed);
      const testing::RandomTransfer edited(data, seed, 100);
      const TouchedRegion& region = edited.transfer->region();
      OverlapFinder finder(region, edited.transfer->locator());
      std::vector<double> covered(region.before.triangles.size(), 0.0);
      for (std::size_t t = 0; t < region.after.triangles.size(); ++t) {
        finder.Find(static_cast<std::int32_t>(t));
        double sum = 0;
        for (const Overlap& overlap : finder.overlaps()) {
          EXPECT_GE(overlap.polygon.Area(), -1e-15);
          sum += overlap.polygon.Area();
          covered[static_cast<std::size_t>(overlap.before)] += overlap.polygon.Area();
        }
        const auto corners = CornersOf(region.after, static_cast<std::int32_t>(t));
        EXPECT_NEAR(sum, AreaOf(corners), Rounding(corners));
      }
      for (std::size_t t = 0; t < covered.size(); ++t) {
        const auto corners = CornersOf(region.before, static_cast<std::int32_t>(t));
        EXPECT_NEAR(covered[t], AreaOf(corners), Rounding(corners)) << "old triangle " << t;
      }
    }
  }
}

// Goal: no pair of triangles with common interior is left out, none without is taken.
// Method: all pairs, by the area of the clipped polygon as a second finder computes it from the
// other side: old and new swapped.
TEST(OverlapFinder, FindsTheSamePairsWithOldAndNewSwapped) {
  const testing::RandomTransfer edited(testing::ThinGrid(), /*seed=*/5, /*steps=*/150);
  const TouchedRegion& region = edited.transfer->region();
  TouchedRegion swapped{region.after, region.before, {}};
  const RegionLocator swapped_locator(swapped);
  OverlapFinder finder(region, edited.transfer->locator());
  OverlapFinder other(swapped, swapped_locator);
  std::vector<std::pair<std::int32_t, std::int32_t>> pairs;
  std::vector<std::pair<std::int32_t, std::int32_t>> swapped_pairs;
  for (std::size_t t = 0; t < region.after.triangles.size(); ++t) {
    finder.Find(static_cast<std::int32_t>(t));
    for (const Overlap& overlap : finder.overlaps()) {
      pairs.emplace_back(overlap.before, static_cast<std::int32_t>(t));
    }
  }
  for (std::size_t t = 0; t < region.before.triangles.size(); ++t) {
    other.Find(static_cast<std::int32_t>(t));
    for (const Overlap& overlap : other.overlaps()) {
      swapped_pairs.emplace_back(static_cast<std::int32_t>(t), overlap.before);
    }
  }
  std::ranges::sort(pairs);
  std::ranges::sort(swapped_pairs);
  EXPECT_EQ(pairs, swapped_pairs);
}

// Goal: where the boundary moved outwards, what lies outside of the old domain is not covered.
TEST(OverlapFinder, LeavesOpenWhatTheOldDomainDidNotHave) {
  auto edited = testing::ImportedMesh(testing::GridData(1, 1));
  (void)edited->edit.Commit(Revision(1));
  edited->edit.MoveVertex(VertexId(3), {2, 2});
  const MeshTransfer transfer(edited->mesh, edited->edit.log());
  OverlapFinder finder(transfer.region(), transfer.locator());
  double covered = 0;
  for (std::size_t t = 0; t < transfer.region().after.triangles.size(); ++t) {
    finder.Find(static_cast<std::int32_t>(t));
    for (const Overlap& overlap : finder.overlaps()) covered += overlap.polygon.Area();
  }
  EXPECT_NEAR(covered, 1, 1e-15);  // Of the new area of 2.
}

}  // namespace
}  // namespace pliant
