#include "client/plot/chart.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/client/plot/support.h"

namespace pliant::plot {
namespace {

TEST(Chart, BarsAreAsHighAsTheirCounts) {
  const Drawing drawing =
      PlotHistogram({.title = "t", .x_label = "x", .low = 0, .high = 4, .counts = {0, 10, 20, 5}});
  // The first shape is the bars: three rectangles, because an empty bin has none.
  const Shape* bars = nullptr;
  for (const Item& item : drawing.items) {
    if (bars == nullptr) bars = std::get_if<Shape>(&item);
  }
  ASSERT_NE(bars, nullptr);
  ASSERT_EQ(bars->path.points.size(), 12U);
  const auto height = [bars](std::size_t i) {
    return bars->path.points[4 * i + 2].y - bars->path.points[4 * i].y;
  };
  EXPECT_NEAR(height(1) / height(0), 2, 1e-12);
  EXPECT_NEAR(height(2) / height(0), 0.5, 1e-12);
  EXPECT_GT(height(0), 50);
}

TEST(Chart, QualityHasTwoPanels) {
  const std::vector<std::int64_t> counts = {1, 2, 3};
  const Drawing drawing = PlotQuality({.angle_counts = counts, .length_counts = counts});
  EXPECT_GT(drawing.width, 2 * ChartSize{}.width);
  int count_of_titles = 0;
  for (const Item& item : drawing.items) {
    const Text* text = std::get_if<Text>(&item);
    if (text != nullptr && text->weight == Weight::kBold) ++count_of_titles;
  }
  EXPECT_EQ(count_of_titles, 2);
}

TEST(Chart, HistogramWithoutCountsIsEmptyButWhole) {
  EXPECT_EQ(CountElements(PlotHistogram({.title = "t", .x_label = "x", .counts = {}})).substr(0, 5),
            "path ");
}

TEST(Chart, FitsThePowerLaw) {
  std::vector<Vec2> points;
  for (const double n : {1e3, 1e4, 3e5, 1e6}) points.push_back({n, 2e-6 * std::pow(n, 1.07)});
  const PowerLaw law = FitPowerLaw(points);
  EXPECT_NEAR(law.slope, 1.07, 1e-12);
  EXPECT_NEAR(law.factor / 2e-6, 1, 1e-10);
}

TEST(Chart, ScalingShowsTheSlopeAndLeavesOutWhatHasNoLogarithm) {
  const Drawing drawing = PlotScaling(
      {.title = "Time",
       .x_label = "nodes",
       .y_label = "s",
       .series = {{"a", {{1000, 0.1}, {10000, 1}, {0, 1}}}, {"b", {{2000, 3}}}, {"c", {}}}});
  std::string all;
  for (const Item& item : drawing.items) {
    if (const Text* text = std::get_if<Text>(&item)) all += text->text + "|";
  }
  EXPECT_NE(all.find("a: slope 1.00|"), std::string::npos) << all;
  EXPECT_NE(all.find("b|"), std::string::npos) << all;
  EXPECT_EQ(CountElements(drawing).find("nan"), std::string::npos);
}

}  // namespace
}  // namespace pliant::plot
