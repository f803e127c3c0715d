#include "client/plot/svg.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/client/plot/support.h"

namespace pliant::plot {
namespace {

using testing::HasSubstr;

TEST(Svg, IsWellFormedWithOneElementPerItem) {
  Drawing drawing{.width = 40, .height = 30, .items = {}};
  Shape shape{.path = {}, .fill = Color{1, 0, 0, 0.5}, .stroke = {}};
  shape.path.Rectangle({1, 2}, {3, 4});
  drawing.items = {BeginClip{{0, 0}, {20, 20}},
                   shape,
                   Segments{{{Vec2{0, 0}, Vec2{1, 1}}, {Vec2{2, 2}, Vec2{3, 3}}}, {}},
                   EndClip{},
                   Text{.at = {5, 5}, .text = "a < b & \"c\" > \x01"},
                   Segments{}};
  // The clip and the white background are rectangles.
  EXPECT_EQ(CountElements(drawing), "clipPath 1 g 1 path 2 rect 2 svg 1 text 1");
}

TEST(Svg, WritesShortNumbersAndColors) {
  Drawing drawing{.width = 40, .height = 30, .items = {}};
  Shape shape{.path = {}, .fill = Color{1, 0, 0.2, 0.5}, .stroke = Stroke{{0, 0, 0, 1}, 0.25}};
  shape.path.MoveTo({-0.00001, 1.0 / 3});
  shape.path.LineTo({1e9, 2});
  drawing.items.emplace_back(shape);
  EXPECT_THAT(FormatSvg(drawing),
              HasSubstr("<path fill=\"#ff0033\" fill-opacity=\"0.5\" stroke=\"#000000\" "
                        "stroke-width=\"0.25\" d=\"M0 0.333L1000000000 2\"/>"));
}

}  // namespace
}  // namespace pliant::plot
