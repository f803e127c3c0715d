#include "core/mesh/id_bits.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "core/base/ids.h"
#include "core/base/rng.h"

namespace pliant {
namespace {

// Goal: a set like any other. Method: std::set, for bounds around the length of a word.
TEST(IdBits, IsTheSetOfWhatWasAdded) {
  Rng rng(64);
  for (const std::int32_t slot_count : {0, 1, 63, 64, 65, 128, 1000}) {
    IdBits<VertexId> bits(slot_count);
    std::set<VertexId> expected;
    for (std::int32_t i = 0; i < slot_count / 3 + (slot_count > 0); ++i) {
      const VertexId id(
          static_cast<std::int32_t>(rng.Below(static_cast<std::uint64_t>(slot_count))));
      bits.Add(id);
      expected.insert(id);
    }
    if (slot_count > 0)
      bits.Add(VertexId(slot_count - 1)), expected.insert(VertexId(slot_count - 1));
    EXPECT_EQ(bits.Ascending(), std::vector<VertexId>(expected.begin(), expected.end()));
    for (std::int32_t i = 0; i < slot_count; ++i) {
      EXPECT_EQ(bits.Has(VertexId(i)), expected.contains(VertexId(i))) << i;
    }
  }
}

TEST(IdBits, DoesNotHaveWhatIsNoIdOrBeyondItsBound) {
  IdBits<TriangleId> bits(3);
  bits.Add(TriangleId(2));
  EXPECT_FALSE(bits.Has(TriangleId()));
  EXPECT_FALSE(bits.Has(TriangleId(64)));
  EXPECT_FALSE(bits.Has(TriangleId(1'000'000)));
}

}  // namespace
}  // namespace pliant
