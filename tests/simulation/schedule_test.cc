// Goal: in whatever order things happen, every mirror ends as the server's mesh, every update is
// answered once and the same way each time, and no advance is applied twice.
// Method: random schedules on one thread and a clock of its own; a seed is a schedule.
#include "tests/simulation/schedule.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "tests/support/seed.h"

namespace pliant::simulation {
namespace {

constexpr std::uint64_t kSchedules = 10'000;
constexpr std::uint64_t kSchedulesLong = 300'000;
constexpr std::uint64_t kParts = 4;  // Tests that run at the same time.

class Simulation : public testing::TestWithParam<std::uint64_t> {};

std::string Replay(std::uint64_t seed) {
  return "replay: PLIANT_SIMULATION_SEED=" + std::to_string(seed) + " " +
         test::ProgramOr("simulation_tests") + " --gtest_filter='*Simulation*/0'";
}

TEST_P(Simulation, EveryMirrorEqualsTheServer) {
  if (const char* seed = std::getenv("PLIANT_SIMULATION_SEED"); seed != nullptr) {
    EXPECT_EQ(Schedule(std::strtoull(seed, nullptr, 10)).Run(), "") << Replay(std::atoll(seed));
    return;
  }
  const std::uint64_t count =
      (std::getenv("PLIANT_LONG_TESTS") != nullptr ? kSchedulesLong : kSchedules) / kParts;
  Tally sum;
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::uint64_t seed = 1 + GetParam() * count + i;
    Schedule schedule(seed);
    ASSERT_EQ(schedule.Run(), "") << Replay(seed);
    sum.Add(schedule.tally());
  }
  // A simulation in which nothing goes wrong proves nothing.
  const auto many = static_cast<std::int64_t>(count / 10);
  EXPECT_GT(sum.commits, many);
  EXPECT_GT(sum.refusals, many);
  EXPECT_GT(sum.reopens, many);
  EXPECT_GT(sum.deaths, many);
  EXPECT_GT(sum.repeats, many);
  EXPECT_GT(sum.collisions, many);
  EXPECT_GT(sum.rollbacks, many);
  EXPECT_GT(sum.put_off, many / 10);
  EXPECT_GT(sum.saved, many);
  EXPECT_GT(sum.forks, many);
  EXPECT_GT(sum.unfinished, many);
  EXPECT_GT(sum.merged, many);
  EXPECT_GT(sum.snapshots, many);
  EXPECT_GT(sum.busy, many);
}

INSTANTIATE_TEST_SUITE_P(Parts, Simulation, testing::Range(std::uint64_t{0}, kParts));

}  // namespace
}  // namespace pliant::simulation
