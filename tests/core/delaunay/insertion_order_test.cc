#include "core/delaunay/insertion_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <vector>

#include "core/base/rng.h"

namespace pliant {
namespace {

std::vector<Vec2> RandomPoints(int count, Rng& rng) {
  std::vector<Vec2> points;
  for (int i = 0; i < count; ++i) points.push_back({rng.Unit(), rng.Unit()});
  return points;
}

void ExpectPermutation(std::vector<std::int32_t> order, std::size_t count) {
  std::vector<std::int32_t> want(count);
  std::iota(want.begin(), want.end(), 0);
  std::ranges::sort(order);
  EXPECT_EQ(order, want);
}

TEST(InsertionOrder, NamesEveryPointOnce) {
  Rng rng(1);
  for (int count : {0, 1, 2, 63, 64, 65, 1000}) {
    const std::vector<Vec2> points = RandomPoints(count, rng);
    ExpectPermutation(InsertionOrder(points), points.size());
  }
}

TEST(InsertionOrder, TakesFlatAndHugeInput) {
  constexpr double kMax = std::numeric_limits<double>::max();
  ExpectPermutation(InsertionOrder(std::vector<Vec2>{{1, 1}, {2, 1}, {3, 1}}), 3);
  ExpectPermutation(InsertionOrder(std::vector<Vec2>{{1, 1}}), 1);
  ExpectPermutation(InsertionOrder(std::vector<Vec2>{{-kMax, kMax}, {kMax, -kMax}, {0, 0}}), 3);
}

// Goal: steps as short as those of a space-filling curve: a few times 1 / sqrt(n) on average, where
// a random order would step half the width of the square.
TEST(InsertionOrder, TakesShortSteps) {
  Rng rng(2);
  const std::vector<Vec2> points = RandomPoints(10000, rng);
  const std::vector<std::int32_t> order = InsertionOrder(points);
  double sum = 0;
  for (std::size_t i = 1; i < order.size(); ++i) {
    sum += Length(points[static_cast<std::size_t>(order[i])] -
                  points[static_cast<std::size_t>(order[i - 1])]);
  }
  EXPECT_LT(sum / 10000, 0.03);
}

// Goal: the first rounds are a random sample of the whole, whatever the order of the input.
TEST(InsertionOrder, StartsWithASampleOfTheWhole) {
  std::vector<Vec2> points;
  for (int i = 0; i < 10000; ++i) points.push_back({static_cast<double>(i), 0});
  const std::vector<std::int32_t> order = InsertionOrder(points);
  const auto low = std::count_if(order.begin(), order.begin() + 1000,
                                 [](std::int32_t point) { return point < 5000; });
  EXPECT_GT(low, 400);
  EXPECT_LT(low, 600);
}

// Goal: one sweep over all points whose steps are shorter than those of rounds: below 1.5 / sqrt(n)
// on average, and never far.
TEST(HilbertOrder, SweepsOverThePoints) {
  Rng rng(3);
  const std::vector<Vec2> points = RandomPoints(10000, rng);
  const std::vector<std::int32_t> order = HilbertOrder(points);
  ExpectPermutation(order, points.size());
  double sum = 0;
  for (std::size_t i = 1; i < order.size(); ++i) {
    sum += Length(points[static_cast<std::size_t>(order[i])] -
                  points[static_cast<std::size_t>(order[i - 1])]);
  }
  EXPECT_LT(sum / 10000, 0.015);
  EXPECT_TRUE(HilbertOrder({}).empty());
}

}  // namespace
}  // namespace pliant
