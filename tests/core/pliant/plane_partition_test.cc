#include "core/pliant/plane_partition.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/base/rng.h"

namespace pliant {
namespace {

std::vector<Vec2> RandomPoints(std::int32_t count, std::uint64_t seed) {
  Rng rng(seed);
  std::vector<Vec2> points;
  const auto coordinate = [&] { return static_cast<double>(rng.Below(1 << 20)) / (1 << 20); };
  for (std::int32_t i = 0; i < count; ++i) {
    const double x = coordinate();
    points.push_back({x * x * x, coordinate()});  // Dense on the left.
  }
  return points;
}

std::vector<std::int32_t> CountsOf(const PlanePartition& partition, const std::vector<Vec2>& points,
                                   std::int32_t part_count) {
  std::vector<std::int32_t> counts(static_cast<std::size_t>(part_count), 0);
  for (const Vec2 p : points) ++counts.at(static_cast<std::size_t>(partition.PartOf(p)));
  return counts;
}

// Goal: every part gets its share of the points, for any number of parts and any cut.
TEST(PlanePartition, SharesPointsEqually) {
  const std::vector<Vec2> points = RandomPoints(10'000, 1);
  for (const std::int32_t part_count : {1, 2, 3, 7, 16, 61}) {
    for (const double low_share : {0.5, 0.4, 0.6}) {
      const PlanePartition partition(points, part_count, low_share);
      const std::vector<std::int32_t> counts = CountsOf(partition, points, part_count);
      const auto [least, most] = std::ranges::minmax(counts);
      EXPECT_GE(least, 10'000 / part_count - 8) << part_count << " parts";
      EXPECT_LE(most, 10'000 / part_count + 8) << part_count << " parts";
    }
  }
}

// Goal: the order of the points has no say, and other shares put the borders elsewhere.
TEST(PlanePartition, DependsOnTheSetOfPointsAndTheShare) {
  std::vector<Vec2> points = RandomPoints(3'000, 2);
  const PlanePartition one(points, 16, 0.5);
  std::ranges::reverse(points);
  const PlanePartition same(points, 16, 0.5);
  const PlanePartition other(points, 16, 0.4);
  int different = 0;
  for (const Vec2 p : RandomPoints(1'000, 3)) {
    EXPECT_EQ(one.PartOf(p), same.PartOf(p));
    different += one.PartOf(p) != other.PartOf(p);
  }
  EXPECT_GT(different, 100);
}

// Goal: points that coincide end in one part; nothing is out of range.
TEST(PlanePartition, AllowsEqualPoints) {
  const std::vector<Vec2> points(100, Vec2{1, 2});
  const PlanePartition partition(points, 8, 0.5);
  const std::vector<std::int32_t> counts = CountsOf(partition, points, 8);
  EXPECT_EQ(std::ranges::max(counts), 100);
  EXPECT_LT(partition.PartOf({-1e300, 1e300}), 8);
  EXPECT_GE(partition.PartOf({1e300, -1e300}), 0);
}

}  // namespace
}  // namespace pliant
