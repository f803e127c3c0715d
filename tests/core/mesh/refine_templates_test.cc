#include "core/mesh/refine_templates.h"

#include <gtest/gtest.h>

#include <bit>

#include "core/geometry/vec2.h"

namespace pliant {
namespace {

constexpr std::array<Vec2, 6> kPoints = {{{0, 0}, {4, 0}, {0, 4}, {2, 2}, {0, 2}, {2, 0}}};

// Goal: every template covers its parent once, uses the middles of the split sides and no other,
// and knows what lies behind every side.
// Method: coordinates; areas of children must be positive and add up, and a side and the one behind
// it must have the same ends.
TEST(RefineTemplates, CoverTheParentAndKnowTheirNeighbors) {
  for (std::size_t code = 0; code < 15; ++code) {
    const bool two_sides = std::popcount(code & 7) == 2;
    if (code > 7 && !two_sides) continue;
    SCOPED_TRACE(code);
    const RefineTemplate& t = kRefineTemplates[code];
    ASSERT_EQ(t.count, static_cast<std::size_t>(std::popcount(code & 7)) + 1);
    double area = 0;
    for (std::size_t c = 0; c < t.count; ++c) {
      const auto& v = t.points[c];
      const double twice = Cross(kPoints[v[1]] - kPoints[v[0]], kPoints[v[2]] - kPoints[v[0]]);
      EXPECT_GT(twice, 0);
      area += 0.5 * twice;
      for (std::size_t side = 0; side < 3; ++side) {
        EXPECT_TRUE(v[side] < 3 || ((code >> (v[side] - 3)) & 1) != 0) << "of a whole side";
        const std::size_t from = v[(side + 1) % 3];
        const std::size_t to = v[(side + 2) % 3];
        const std::size_t behind = t.behind[c][side];
        if (behind < RefineTemplate::kOutside) {
          int shared = 0;
          for (const std::size_t point : t.points[behind]) shared += point == from || point == to;
          EXPECT_EQ(shared, 2);
          EXPECT_NE(behind, c);
          continue;
        }
        const std::size_t s = (behind - RefineTemplate::kOutside) / 2;
        const std::size_t half = (behind - RefineTemplate::kOutside) % 2;
        const bool split = ((code >> s) & 1) != 0;
        EXPECT_EQ(t.child_at[s][half], c);
        EXPECT_EQ(from, half == 0 ? (s + 1) % 3 : 3 + s);
        EXPECT_EQ(to, half == 0 && split ? 3 + s : (s + 2) % 3);
      }
    }
    EXPECT_EQ(area, 8);
    for (std::size_t point = 0; point < 6; ++point) {
      if (point > 2 && ((code >> (point - 3)) & 1) == 0) continue;
      const auto& v = t.points[t.child_of_point[point]];
      EXPECT_TRUE(v[0] == point || v[1] == point || v[2] == point);
    }
  }
}

// Goal: with two split sides, the two templates differ in the diagonal and in nothing else.
TEST(RefineTemplates, HaveBothDiagonals) {
  for (const std::size_t code : {3U, 5U, 6U}) {
    const RefineTemplate& one = kRefineTemplates[code];
    const RefineTemplate& other = kRefineTemplates[code + RefineTemplate::kOtherDiagonal];
    EXPECT_EQ(one.points[0], other.points[0]);
    EXPECT_NE(one.points[1], other.points[1]);
    EXPECT_NE(one.points[2], other.points[2]);
  }
}

}  // namespace
}  // namespace pliant
