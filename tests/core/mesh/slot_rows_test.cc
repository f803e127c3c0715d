#include "core/mesh/slot_rows.h"

#include <gtest/gtest.h>

#include <map>

#include "core/base/rng.h"

namespace pliant {
namespace {

TEST(SlotRows, FindsWhatAMapFinds) {
  Rng rng(1);
  SlotRows<int> rows;
  std::map<std::int32_t, int> expected;
  for (int i = 0; i < 5000; ++i) {
    const auto slot = static_cast<std::int32_t>(rng.Below(20000));
    int* row = rows.Find(slot);
    ASSERT_EQ(row != nullptr, expected.count(slot) == 1) << slot;
    if (row != nullptr) {
      ASSERT_EQ(*row, expected[slot]);
      *row = expected[slot] = i;
    } else {
      rows.Insert(slot, i);
      expected[slot] = i;
    }
  }
  ASSERT_EQ(rows.entries().size(), expected.size());
  for (const auto& [slot, row] : rows.entries()) EXPECT_EQ(row, expected[slot]);
}

TEST(SlotRows, KeepsTheOrderOfInsertion) {
  SlotRows<char> rows;
  EXPECT_EQ(rows.Find(3), nullptr);
  for (const std::int32_t slot : {7, 3, 1 << 30, 0}) rows.Insert(slot, 'x');
  std::vector<std::int32_t> slots;
  for (const auto& [slot, row] : rows.entries()) slots.push_back(slot);
  EXPECT_EQ(slots, (std::vector<std::int32_t>{7, 3, 1 << 30, 0}));
}

}  // namespace
}  // namespace pliant
