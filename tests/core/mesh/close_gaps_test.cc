#include "core/mesh/close_gaps.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/base/rng.h"
#include "tests/support/backward_executor.h"

namespace pliant {
namespace {

struct Record {
  std::int32_t value = 0;
  bool live = false;

  friend bool operator==(const Record&, const Record&) = default;
};

// Goal: live records keep their order and move to 0, 1, 2...; for few and many gaps over several
// chunks, and whatever the order of the chunks. Oracle: std::erase_if.
TEST(CloseGaps, IsErasureOfTheDead) {
  Rng rng(7);
  for (const std::uint64_t share_of_dead : {0, 1, 50, 500, 990, 1000}) {
    for (const std::int64_t count : {std::int64_t{0}, std::int64_t{5}, 3 * Chunks::kLength + 100}) {
      std::vector<Record> records;
      for (std::int32_t i = 0; i < count; ++i)
        records.push_back({i, rng.Below(1000) >= share_of_dead});
      std::vector<Record> expected = records;
      std::erase_if(expected, [](const Record& record) { return !record.live; });
      testing::BackwardExecutor executor;
      const std::vector<std::int32_t> numbers = DenseNumbers(records, executor);
      for (std::size_t i = 0; i < records.size(); ++i) {
        if (!records[i].live) {
          ASSERT_EQ(numbers[i], -1);
        } else {
          ASSERT_EQ(expected.at(static_cast<std::size_t>(numbers[i])), records[i]);
        }
      }
      CloseGaps(records, numbers, executor);
      ASSERT_EQ(records, expected);
    }
  }
}

}  // namespace
}  // namespace pliant
