#include "core/metric/function_field.h"

#include <gtest/gtest.h>

#include <array>

namespace pliant {
namespace {

TEST(FunctionField, AsksTheFunctionAndLeavesTheHint) {
  const FunctionField field([](Vec2 p) { return Metric{p.x, 0, p.y}; });
  std::int32_t hint = 17;
  EXPECT_EQ(field.At({2, 3}, hint), (Metric{2, 0, 3}));
  EXPECT_EQ(hint, 17);
  EXPECT_TRUE(field.status().ok());

  std::array<Metric, 2> metrics;
  std::array hints = {17, 18};
  field.AtEach(std::array{Vec2{2, 3}, Vec2{4, 5}}, hints, metrics);
  EXPECT_EQ(metrics, (std::array{Metric{2, 0, 3}, Metric{4, 0, 5}}));
  EXPECT_EQ(hints, (std::array{17, 18}));
}

}  // namespace
}  // namespace pliant
