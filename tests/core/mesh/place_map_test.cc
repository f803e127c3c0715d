#include "core/mesh/place_map.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <map>

#include "core/base/rng.h"

namespace pliant {
namespace {

TEST(PlaceMap, KnowsWhatAMapKnows) {
  // Both forms, the second of which turns into an array on the way.
  for (PlaceMap places : {PlaceMap(), PlaceMap(8000)}) {
    Rng rng(5);
    std::map<std::int32_t, std::int32_t> expected;
    EXPECT_EQ(places.At(VertexId(3)), PlaceMap::kNone);
    for (std::int32_t i = 0; i < 5000; ++i) {
      const auto slot = static_cast<std::int32_t>(rng.Below(8000));
      EXPECT_EQ(places.Add(VertexId(slot), i), expected.emplace(slot, i).second);
    }
    for (std::int32_t slot = 0; slot < 8000; ++slot) {
      const auto known = expected.find(slot);
      EXPECT_EQ(places.At(VertexId(slot)),
                known == expected.end() ? PlaceMap::kNone : known->second);
    }
  }
}

}  // namespace
}  // namespace pliant
