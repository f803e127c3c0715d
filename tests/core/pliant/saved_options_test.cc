#include "core/pliant/saved_options.h"

#include <gtest/gtest.h>

#include "core/base/bytes.h"

namespace pliant {
namespace {

// Every field differs from its default, so that one that is not written shows.
Options AllDifferent() {
  return {.variant = Variant::kPaper,
          .smoothing = Smoothing::kBubble,
          .permissions = {.insert = false, .swap = false, .move = false, .surface = false},
          .seed = 99,
          .step = 0.7,
          .speed_threshold = 0.01,
          .age_cooling = 12,
          .age_max = 33,
          .hops_max = 5,
          .metric_tolerance = 0.2,
          .boundary_tolerance = 0.004,
          .vertices_max = 1234,
          .visits_per_vertex_max = 17};
}

TEST(SavedOptions, ComeBackAsTheyWere) {
  ByteWriter writer;
  WriteOptions(AllDifferent(), writer);
  const Bytes bytes = std::move(writer).Take();
  ByteReader reader(bytes);
  EXPECT_EQ(ReadOptions(reader), AllDifferent());
  EXPECT_TRUE(reader.AtEnd());
}

TEST(SavedOptions, ImpossibleOnesFailTheReader) {
  Options options = AllDifferent();
  options.age_max = 5;  // Below age_cooling.
  ByteWriter writer;
  WriteOptions(options, writer);
  Bytes bytes = std::move(writer).Take();
  ByteReader reader(bytes);
  (void)ReadOptions(reader);
  EXPECT_FALSE(reader.ok());
  bytes[2] = std::byte{200};  // Permissions that do not exist.
  ByteReader second(bytes);
  (void)ReadOptions(second);
  EXPECT_FALSE(second.ok());
}

}  // namespace
}  // namespace pliant
