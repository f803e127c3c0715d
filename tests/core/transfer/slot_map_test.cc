#include "core/transfer/slot_map.h"

#include <gtest/gtest.h>

#include <map>

#include "core/base/rng.h"

namespace pliant {
namespace {

// Method: against std::map, with few and with many more slots than were announced.
TEST(SlotMap, NumbersSlotsInTheOrderInWhichTheyCame) {
  Rng rng(7);
  SlotMap map(4);
  std::map<std::int32_t, std::int32_t> oracle;
  for (int i = 0; i < 5000; ++i) {
    const auto slot = static_cast<std::int32_t>(rng.Below(3000)) * 64;
    const auto [entry, is_new] = oracle.emplace(slot, static_cast<std::int32_t>(oracle.size()));
    ASSERT_EQ(map.Add(slot), entry->second) << "slot " << slot << " new " << is_new;
  }
  ASSERT_EQ(map.count(), static_cast<std::int32_t>(oracle.size()));
  for (std::int32_t slot = 0; slot < 64 * 3000; slot += 32) {
    const auto found = oracle.find(slot);
    EXPECT_EQ(map.Find(slot), found == oracle.end() ? -1 : found->second) << slot;
  }
}

}  // namespace
}  // namespace pliant
