#include "core/mesh/slots.h"

#include <gtest/gtest.h>

#include <iterator>
#include <set>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "core/base/rng.h"

namespace pliant {
namespace {

TEST(SlotAllocator, TakesTheLowestFreeSlotWhateverTheOrderOfFreeing) {
  SlotAllocator slots;
  slots.Reset(10);
  for (const std::int32_t slot : {7, 2, 9, 4}) slots.Free(slot);
  EXPECT_EQ(slots.live_count(), 6);
  EXPECT_EQ(slots.size(), 10);
  for (const std::int32_t expected : {2, 4, 7, 9, 10, 11}) EXPECT_EQ(slots.Take(), expected);
  EXPECT_EQ(slots.live_count(), 12);
}

TEST(SlotAllocator, DoesNotReuseAParkedSlotBeforeItIsReleased) {
  SlotAllocator slots;
  slots.Reset(3);
  slots.Park(1);
  EXPECT_EQ(slots.live_count(), 2);
  EXPECT_EQ(slots.Take(), 3);
  slots.ReleaseParked();
  EXPECT_EQ(slots.Take(), 1);
  EXPECT_EQ(slots.Take(), 4);
}

// Goal: an id means one element within a revision, ids stay dense, and a rollback forgets all.
// Method: random takes and frees beside a naive model with ordered sets.
TEST(SlotAllocator, BehavesLikeASetOfFreeSlots) {
  constexpr std::uint64_t kSeed = 7;
  Rng rng(kSeed);
  SlotAllocator slots;
  slots.Reset(5);
  std::set<std::int32_t> live{0, 1, 2, 3, 4};
  std::set<std::int32_t> free;
  std::set<std::int32_t> parked;
  std::set<std::int32_t> committed = live;
  std::set<std::int32_t> committed_free;
  std::int32_t size = 5;
  std::int32_t committed_size = 5;
  for (int step = 0; step < 20'000; ++step) {
    SCOPED_TRACE(::testing::Message() << "seed " << kSeed << " step " << step);
    const std::uint64_t dice = rng.Below(100);
    if (dice < 50 || live.empty()) {
      const std::int32_t expected = free.empty() ? size++ : *free.begin();
      free.erase(expected);
      live.insert(expected);
      ASSERT_EQ(slots.Take(), expected);
    } else if (dice < 97) {
      const std::int32_t slot = *std::next(live.begin(), static_cast<int>(rng.Below(live.size())));
      live.erase(slot);
      if (committed.contains(slot)) {
        slots.Park(slot);
        parked.insert(slot);
      } else {
        slots.Free(slot);
        free.insert(slot);
      }
    } else if (dice < 99) {
      slots.ReleaseParked();
      free.insert(parked.begin(), parked.end());
      parked.clear();
      committed = live;
      committed_free = free;
      committed_size = size;
    } else {
      for (const std::int32_t slot : live) {
        if (!committed.contains(slot)) slots.Free(slot);
      }
      slots.Rollback(committed_size);
      live = committed;
      free = committed_free;
      size = committed_size;
      parked.clear();
    }
    ASSERT_EQ(slots.size(), size);
    ASSERT_EQ(slots.live_count(), static_cast<std::int32_t>(live.size()));
  }
}

// Goal: lent slots are the lowest free ones, then new ones; a lender sees what became of them when
// it counts, and has all that are free afterwards.
TEST(SlotAllocator, LendsSlots) {
  SlotAllocator whole;
  whole.Reset(10);
  whole.Free(7);
  whole.Free(2);
  whole.Free(4);
  SlotAllocator a = whole.Lend(2);
  SlotAllocator b = whole.Lend(3);
  EXPECT_EQ(whole.size(), 12);
  EXPECT_EQ(whole.live_count(), 7);
  EXPECT_EQ(whole.free_count(), 0U);
  EXPECT_EQ(a.Take(), 2);
  EXPECT_EQ(b.Take(), 7);
  EXPECT_EQ(b.Take(), 10);
  EXPECT_EQ(a.Take(), 4);
  EXPECT_THROW((void)a.Take(), InvariantViolation);  // Growth would meet another's slots.
  a.Free(0);                                         // An element that the whole has made.
  EXPECT_EQ(a.free_count(), 1U);
  whole.CountFrom(b);
  EXPECT_EQ(whole.live_count(), 9);
  whole.ReturnFrom(std::move(b));
  whole.ReturnFrom(std::move(a));
  whole.EndLoans();
  EXPECT_EQ(whole.live_count(), 10);
  EXPECT_EQ(whole.Take(), 0);
  EXPECT_EQ(whole.Take(), 11);
  EXPECT_EQ(whole.Take(), 12);
}

}  // namespace
}  // namespace pliant
