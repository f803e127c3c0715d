#pragma once

#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

namespace pliant::test {

/// The first seed of a random test: PLIANT_SEED, or 0.
inline std::uint64_t FirstSeed() {
  const char* seed = std::getenv("PLIANT_SEED");
  return seed != nullptr ? std::strtoull(seed, nullptr, 10) : 0;
}

/// The seeds 0, 1, 2... of a random test.
struct Seeds {
  std::uint64_t count = 0;       ///< How many.
  std::uint64_t long_count = 0;  ///< How many with PLIANT_LONG_TESTS.
  std::uint64_t part_count = 1;  ///< Of the tests that share them.

  /// Those of one of these tests; with PLIANT_SEED that seed alone, in the first of them.
  [[nodiscard]] std::vector<std::uint64_t> OfPart(std::uint64_t part) const {
    std::vector<std::uint64_t> seeds;
    if (std::getenv("PLIANT_SEED") != nullptr) {
      if (part == 0) seeds.push_back(FirstSeed());
      return seeds;
    }
    const bool is_long = std::getenv("PLIANT_LONG_TESTS") != nullptr;
    for (std::uint64_t seed = part; seed < (is_long ? long_count : count); seed += part_count) {
      seeds.push_back(seed);
    }
    return seeds;
  }
};

/// The path of the program that runs, so that a command can be pasted; `otherwise` where the system
/// does not tell.
inline std::string ProgramOr(std::string_view otherwise) {
  std::error_code error;
  const std::filesystem::path path = std::filesystem::read_symlink("/proc/self/exe", error);
  return error ? std::string(otherwise) : path.string();
}

/// How to run one seed again: `program`, which is the one that runs, with the tests that match
/// `filter`.
inline std::string Replay(std::uint64_t seed, std::string_view program, std::string_view filter) {
  return "replay: PLIANT_SEED=" + std::to_string(seed) + " " + ProgramOr(program) +
         " --gtest_filter='" + std::string(filter) + "'";
}

}  // namespace pliant::test
