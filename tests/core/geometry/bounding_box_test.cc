#include "core/geometry/bounding_box.h"

#include <gtest/gtest.h>

#include <array>

namespace pliant {
namespace {

TEST(BoundingBox, HoldsAllPoints) {
  const BoundingBox box = BoxOf(std::array{Vec2{1, 5}, Vec2{-2, 6}, Vec2{0, 7}});
  EXPECT_EQ(box, (BoundingBox{{-2, 5}, {1, 7}}));
  EXPECT_EQ(BoxOf(std::array{Vec2{3, 4}}), (BoundingBox{{3, 4}, {3, 4}}));
}

TEST(BoundingBox, IsAsFarAsItsNearestPoint) {
  const BoundingBox box{{0, 0}, {2, 1}};
  EXPECT_EQ(SquaredDistance(box, {1, 0.5}), 0) << "inside";
  EXPECT_EQ(SquaredDistance(box, {2, 1}), 0) << "on the border";
  EXPECT_EQ(SquaredDistance(box, {1, 4}), 9) << "above a side";
  EXPECT_EQ(SquaredDistance(box, {-3, -4}), 25) << "beyond a corner";
  EXPECT_EQ(SquaredDistance(box, {5, 5}), 25) << "beyond the other corner";
}

TEST(BoundingBox, MeetsWhatTouchesIt) {
  const BoundingBox box{{0, 0}, {2, 1}};
  EXPECT_TRUE(Meet(box, {{1, 0.5}, {1, 0.5}}));
  EXPECT_TRUE(Meet(box, {{2, 1}, {3, 3}})) << "a corner";
  EXPECT_FALSE(Meet(box, {{2.5, 0}, {3, 1}}));
  EXPECT_FALSE(Meet(box, {{0, -2}, {2, -1}}));
}

}  // namespace
}  // namespace pliant
