#include "client/plot/axis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace pliant::plot {
namespace {

using testing::DoubleNear;
using testing::Pointwise;

TEST(Axis, MapsValuesOntoPositions) {
  const Axis linear{.low = 10, .high = 20, .from = 100, .to = 0};
  EXPECT_DOUBLE_EQ(linear.Position(10), 100);
  EXPECT_DOUBLE_EQ(linear.Position(12.5), 75);
  const Axis logarithmic{
      .low = 1, .high = 10000, .from = 0, .to = 4, .scaling = Scaling::kLogarithmic};
  EXPECT_DOUBLE_EQ(logarithmic.Position(100), 2);
}

TEST(Axis, PutsTicksOnRoundValues) {
  const auto near = [](const std::vector<double>& values) {
    return Pointwise(DoubleNear(1e-12), values);
  };
  EXPECT_THAT((Axis{.low = 0, .high = 2}.Ticks(4)), near({0, 0.5, 1, 1.5, 2}));
  EXPECT_THAT((Axis{.low = -0.31, .high = 0.3}.Ticks(6)), near({-0.2, 0, 0.2}));
  EXPECT_THAT((Axis{.low = 0, .high = 0.3}.Ticks(3)), near({0, 0.1, 0.2, 0.3}));
  EXPECT_THAT((Axis{.low = 0, .high = 180, .tick_step = 60}.Ticks(9)), near({0, 60, 120, 180}));
  EXPECT_THAT((Axis{.low = 5, .high = 1000, .scaling = Scaling::kLogarithmic}.Ticks(9)),
              near({10, 100, 1000}));
}

TEST(Axis, LabelsReadWell) {
  EXPECT_EQ(Label(0), "0");
  EXPECT_EQ(Label(0.30000000000000004), "0.3");
  EXPECT_EQ(Label(-0.25), "-0.25");
  EXPECT_EQ(Label(1500), "1,500");
  EXPECT_EQ(Label(20000), "20,000");
  EXPECT_EQ(Label(-1234567), "-1,234,567");
  EXPECT_EQ(Label(2e-6), "2e-06");
}

}  // namespace
}  // namespace pliant::plot
