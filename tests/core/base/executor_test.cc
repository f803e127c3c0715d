#include "core/base/executor.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

namespace pliant {
namespace {

TEST(InlineExecutor, RunsEachTaskOnceInOrder) {
  std::vector<std::int32_t> seen;
  InlineExecutor().Run(5, [&](std::int32_t index) { seen.push_back(index); });
  EXPECT_EQ(seen, (std::vector<std::int32_t>{0, 1, 2, 3, 4}));
  InlineExecutor().Run(0, [&](std::int32_t /*index*/) { FAIL(); });
  EXPECT_THROW(InlineExecutor().Run(2, [](std::int32_t) { throw std::runtime_error("x"); }),
               std::runtime_error);
}

// Goal: chunks cover every item once, whatever the remainder.
TEST(Chunks, CoverTheItems) {
  for (const std::int64_t count : {std::int64_t{0}, std::int64_t{1}, Chunks::kLength - 1,
                                   Chunks::kLength, 3 * Chunks::kLength + 7}) {
    const Chunks chunks(count);
    std::int64_t next = 0;
    for (std::int32_t chunk = 0; chunk < chunks.count(); ++chunk) {
      EXPECT_EQ(chunks.begin(chunk), next);
      EXPECT_GT(chunks.end(chunk), next);
      next = chunks.end(chunk);
    }
    EXPECT_EQ(next, count);
    std::vector<int> visits(static_cast<std::size_t>(count), 0);
    InlineExecutor executor;
    chunks.ForEach(executor, [&](std::int32_t item) { ++visits[static_cast<std::size_t>(item)]; });
    EXPECT_EQ(visits, std::vector<int>(static_cast<std::size_t>(count), 1));
  }
}

}  // namespace
}  // namespace pliant
