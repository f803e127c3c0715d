#include "client/plot/drawing.h"

#include <gtest/gtest.h>

#include <cmath>

namespace pliant::plot {
namespace {

Vec2 OnCurve(const Path& path, std::size_t curve, double t) {
  const Vec2* p = path.points.data() + 3 * curve;
  const double s = 1 - t;
  return s * s * s * p[0] + 3 * s * s * t * p[1] + 3 * s * t * t * p[2] + t * t * t * p[3];
}

// Goal: the four curves are the ellipse that they stand for.
// Method: points all along them, mapped back to the unit circle.
TEST(Drawing, EllipseIsTheImageOfTheUnitCircle) {
  const Vec2 center = {3, -1};
  const Vec2 u = {2, 1};
  const Vec2 v = {-0.3, 0.5};
  Path path;
  path.Ellipse(center, u, v);
  ASSERT_EQ(path.verbs, "MCCCCZ");
  for (std::size_t curve = 0; curve < 4; ++curve) {
    for (int i = 0; i <= 20; ++i) {
      const Vec2 d = OnCurve(path, curve, i / 20.0) - center;
      const double x = Cross(d, v) / Cross(u, v);
      const double y = Cross(u, d) / Cross(u, v);
      EXPECT_NEAR(std::sqrt(x * x + y * y), 1, 3e-4);
    }
  }
}

TEST(Drawing, PanelsStandBesideAndBelowEachOther) {
  Drawing a{.width = 100, .height = 50, .items = {Text{.at = {1, 2}, .text = "a"}}};
  Drawing b{.width = 30, .height = 70, .items = {Text{.at = {3, 4}, .text = "b"}}};
  const Drawing row = Beside({a, b}, 10);
  EXPECT_EQ(row.width, 140);
  EXPECT_EQ(row.height, 70);
  EXPECT_EQ(std::get<Text>(row.items[0]).at, (Vec2{1, 2}));
  EXPECT_EQ(std::get<Text>(row.items[1]).at, (Vec2{113, 4}));
  const Drawing column = Below({a, b}, 10);
  EXPECT_EQ(column.width, 100);
  EXPECT_EQ(column.height, 130);
  EXPECT_EQ(std::get<Text>(column.items[1]).at, (Vec2{38, 64})) << "centred";
}

TEST(Drawing, ColorsRunFromDarkToLightAndRepeatAfterTen) {
  double last = -1;
  for (int i = 0; i <= 50; ++i) {
    const Color c = ScaleColor(i / 50.0);
    const double brightness = 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
    EXPECT_GT(brightness, last);
    last = brightness;
  }
  EXPECT_EQ(CategoryColor(13), CategoryColor(3));
  EXPECT_EQ(CategoryColor(-1), CategoryColor(9));
  EXPECT_EQ(Lighter(kInk, 1), (Color{1, 1, 1, 1}));
}

}  // namespace
}  // namespace pliant::plot
