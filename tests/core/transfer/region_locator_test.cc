#include "core/transfer/region_locator.h"

#include <gtest/gtest.h>

#include "tests/support/random_transfer.h"

namespace pliant {
namespace {

// Method: against a search of all old triangles, without any hint.
TEST(RegionLocator, FindsWhatASearchWithoutHintsFinds) {
  for (const MeshData& data : {testing::GridData(8, 8), testing::ThinGrid()}) {
    const testing::RandomTransfer edited(data, /*seed=*/3, /*steps=*/80);
    const TouchedRegion& region = edited.transfer->region();
    const RegionLocator locator(region);
    const TriangleLocator plain(region.before.points, region.before.triangles);
    for (std::size_t v = 0; v < region.after.points.size(); ++v) {
      for (const Vec2 offset : {Vec2{0, 0}, Vec2{0.01, 0.0003}, Vec2{50, -3}}) {
        const Vec2 p = region.after.points[v] + offset;
        const Location found = locator.Locate(p, static_cast<std::int32_t>(v));
        const Location expected = plain.Locate(p, -1);
        EXPECT_EQ(found.triangle, expected.triangle) << "vertex " << v;
        EXPECT_EQ(found.weights, expected.weights) << "vertex " << v;
      }
    }
  }
}

}  // namespace
}  // namespace pliant
