#include "client/cli/loop_options.h"

#include <gtest/gtest.h>

namespace pliant::cli {
namespace {

LoopOptions ParsedLoop(const std::string& text) {
  CLI::App app;
  LoopOptions options;
  AddLoopOptions(app, options);
  app.parse(text);
  return options;
}

TEST(LoopOptions, NothingGivenMeansTheDefaults) {
  const LoopOptions loop = ParsedLoop("");
  EXPECT_EQ(loop.options, Options());
  EXPECT_FALSE(loop.advance().visits_max.has_value());
  EXPECT_FALSE(loop.advance().time_max.has_value());
}

TEST(LoopOptions, EachOptionReachesItsField) {
  const LoopOptions loop = ParsedLoop(
      "--variant paper --smoothing lennard-jones --seed 18446744073709551615 "
      "--no-insert --no-swap --no-move --vertices-max 77 --step 0.25 --speed-threshold 0.125 "
      "--visits-max 9 --seconds-max 0.0001");
  Options expected;
  expected.variant = Variant::kPaper;
  expected.smoothing = Smoothing::kLennardJones;
  expected.seed = ~std::uint64_t{0};
  expected.permissions = {.insert = false, .swap = false, .move = false};
  expected.vertices_max = 77;
  expected.step = 0.25;
  expected.speed_threshold = 0.125;
  EXPECT_EQ(loop.options, expected);
  EXPECT_EQ(loop.advance().visits_max, 9);
  EXPECT_EQ(loop.advance().time_max, std::chrono::milliseconds(1)) << "never 0, which is no limit";
}

TEST(LoopOptions, UnknownNamesAreRefused) {
  EXPECT_THROW(ParsedLoop("--variant paperish"), CLI::ParseError);
  EXPECT_THROW(ParsedLoop("--smoothing 1.5"), CLI::ParseError);
  EXPECT_THROW(ParsedLoop("--visits-max -1"), CLI::ParseError);
}

}  // namespace
}  // namespace pliant::cli
