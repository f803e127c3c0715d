#include "core/metric/function_field.h"

#include <gtest/gtest.h>

namespace pliant {
namespace {

TEST(FunctionField, AsksTheFunctionAndLeavesTheHint) {
  const FunctionField field([](Vec2 p) { return Metric{p.x, 0, p.y}; });
  std::int32_t hint = 17;
  EXPECT_EQ(field.At({2, 3}, hint), (Metric{2, 0, 3}));
  EXPECT_EQ(hint, 17);
  EXPECT_TRUE(field.status().ok());
}

}  // namespace
}  // namespace pliant
