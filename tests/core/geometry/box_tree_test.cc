#include "core/geometry/box_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "core/base/rng.h"

namespace pliant {
namespace {

std::vector<BoundingBox> RandomBoxes(int count, Rng& rng) {
  std::vector<BoundingBox> boxes;
  for (int i = 0; i < count; ++i) {
    const Vec2 low = {static_cast<double>(rng.Below(40)), static_cast<double>(rng.Below(40))};
    const Vec2 size = {static_cast<double>(rng.Below(6)), static_cast<double>(rng.Below(6))};
    boxes.push_back({low, low + size});
  }
  return boxes;
}

// Goal: exactly the boxes that meet a box, borders included, at every size of tree.
TEST(BoxTree, FindsEveryBoxThatMeetsABox) {
  Rng rng(40);
  for (int count : {1, 2, 4, 5, 9, 100, 1000}) {
    const std::vector<BoundingBox> boxes = RandomBoxes(count, rng);
    const BoxTree tree(boxes);
    for (int trial = 0; trial < 200; ++trial) {
      BoundingBox asked = RandomBoxes(1, rng)[0];
      if (trial % 2 == 0) asked.high = asked.low;
      std::vector<std::int32_t> found;
      tree.ForEachMeeting(asked, [&found](std::int32_t i) {
        found.push_back(i);
        return true;
      });
      std::ranges::sort(found);
      std::vector<std::int32_t> want;
      for (std::size_t i = 0; i < boxes.size(); ++i) {
        const bool is_apart = boxes[i].high.x < asked.low.x || asked.high.x < boxes[i].low.x ||
                              boxes[i].high.y < asked.low.y || asked.high.y < boxes[i].low.y;
        if (!is_apart) want.push_back(static_cast<std::int32_t>(i));
      }
      ASSERT_EQ(found, want) << "seed 40, count " << count << ", trial " << trial;
    }
  }
}

// Goal: the search for the nearest finds it and looks at few boxes.
// Method: boxes that are points, compared with all of them.
TEST(BoxTree, FindsTheNearestAndLooksAtFew) {
  Rng rng(41);
  std::vector<BoundingBox> boxes;
  for (int i = 0; i < 4000; ++i) {
    const Vec2 p = {rng.Unit(), rng.Unit()};
    boxes.push_back({p, p});
  }
  const BoxTree tree(boxes);
  int visit_count = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Vec2 p = {rng.Uniform(-1, 2), rng.Uniform(-1, 2)};
    const auto squared_distance = [&](const BoundingBox& box) {
      return Dot(box.low - p, box.low - p);
    };
    double found = std::numeric_limits<double>::infinity();
    tree.ForEachNear(p, [&](std::int32_t i) {
      ++visit_count;
      found = std::min(found, squared_distance(boxes[static_cast<std::size_t>(i)]));
      return found;
    });
    double want = std::numeric_limits<double>::infinity();
    for (const BoundingBox& box : boxes) want = std::min(want, squared_distance(box));
    ASSERT_EQ(found, want) << "seed 41, trial " << trial;
  }
  EXPECT_LT(visit_count, 200 * 60);
}

TEST(BoxTree, IsEmptyWithoutBoxes) {
  const BoxTree tree;
  EXPECT_TRUE(tree.empty());
  tree.ForEachMeeting({}, [](std::int32_t) {
    ADD_FAILURE();
    return true;
  });
}

}  // namespace
}  // namespace pliant
