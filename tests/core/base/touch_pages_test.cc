#include "core/base/touch_pages.h"

#include <gtest/gtest.h>

#include <vector>

namespace pliant {
namespace {

// Goal: room for all, nothing in it, and what is there already stays.
TEST(ReserveTouched, ReservesAndKeeps) {
  InlineExecutor executor;
  for (const std::size_t count : {std::size_t{0}, std::size_t{10}, std::size_t{3'000'001}}) {
    std::vector<int> empty;
    ReserveTouched(empty, count, executor);
    EXPECT_GE(empty.capacity(), count);
    EXPECT_TRUE(empty.empty());
    std::vector<int> full(2'000'000, 7);
    ReserveTouched(full, count, executor);
    EXPECT_GE(full.capacity(), count);
    EXPECT_EQ(full, std::vector<int>(2'000'000, 7));
  }
}

}  // namespace
}  // namespace pliant
