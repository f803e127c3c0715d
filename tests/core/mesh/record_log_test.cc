#include "core/mesh/record_log.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "core/base/ids.h"
#include "core/base/rng.h"

namespace pliant {
namespace {

struct Row {
  std::int32_t value = 0;
  std::int32_t filling = 0;
};
using RowLog = RecordLog<VertexId, Row>;

std::vector<std::int32_t> ValuesOf(const RowLog& log) {
  std::vector<std::int32_t> values;
  for (const auto& [id, row] : log) values.push_back(row.value);
  return values;
}

/// Slots below a bound, each once and in no order.
std::vector<VertexId> Shuffled(std::int32_t count, std::int32_t stride, Rng& rng) {
  std::vector<VertexId> ids;
  for (std::int32_t i = 0; i < count; ++i) ids.emplace_back(stride * i);
  for (std::size_t i = ids.size(); i > 1; --i) std::swap(ids[i - 1], ids[rng.Below(i)]);
  return ids;
}

// Method: an ordered map. Many of the slots, where a table finds the order, and few of them.
TEST(RecordLog, SortsBySlot) {
  Rng rng(17);
  for (const auto& [count, stride] : std::vector<std::pair<std::int32_t, std::int32_t>>{
           {0, 1}, {1, 5}, {2, 1}, {1'000, 1}, {1'000, 15}, {1'000, 400}}) {
    RowLog log;
    std::map<VertexId, std::int32_t> expected;
    for (const VertexId id : Shuffled(count, stride, rng)) {
      const auto value = static_cast<std::int32_t>(rng.Below(1'000'000));
      log.Add(id, {value}, 400'000);
      expected[id] = value;
    }
    const std::vector<std::uint32_t> order = log.Order();
    ASSERT_EQ(order.size(), expected.size());
    std::size_t place = 0;
    for (const auto& [id, value] : expected) EXPECT_EQ(log[order[place++]].first, id);
    log.Sort();
    ASSERT_EQ(log.size(), expected.size());
    place = 0;
    for (const auto& [id, value] : expected) {
      EXPECT_EQ(log[place].first, id);
      EXPECT_EQ(log[place++].second.value, value);
    }
    log.Clear();
    EXPECT_TRUE(log.empty());
    EXPECT_TRUE(log.Order().empty());
  }
}

// Goal: every record goes where it came from, and who asks sees both sides before. Method: runs of
// neighbouring slots of many lengths, shorter and longer than a block, with gaps in between.
TEST(RecordLog, WritesBackInRuns) {
  std::vector<Row> rows(5'000);
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i].value = static_cast<std::int32_t>(i);
  const std::vector<Row> before = rows;
  RowLog log;
  for (std::int32_t begin = 0, length = 1; begin + length <= 5'000; begin += length + 2) {
    for (std::int32_t i = begin; i < begin + length; ++i) {
      log.Add(VertexId(i), rows[static_cast<std::size_t>(i)], rows.size());
      rows[static_cast<std::size_t>(i)].value = -i - 1;
    }
    length = length * 3 / 2 + 1;
  }
  std::size_t seen = 0;
  log.WriteTo(rows, [&](const auto& entry, const Row& now) {
    ++seen;
    EXPECT_EQ(entry.second.value, entry.first.value());
    EXPECT_EQ(now.value, -entry.first.value() - 1);
  });
  EXPECT_EQ(seen, log.size());
  for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(rows[i].value, before[i].value) << i;
}

// Goal: a log that becomes large is not moved again while it grows to the size of a mesh: that
// would take tens of milliseconds between two looks at a stop signal.
TEST(RecordLog, DoesNotMoveOnceItIsLarge) {
  constexpr std::int32_t kSlots = 2'000'000;
  RowLog log;
  const Row* stands = nullptr;
  std::int32_t moved_at = 0;
  for (std::int32_t i = 0; i < kSlots; ++i) {
    log.Add(VertexId(i), {i}, kSlots);
    if (&log[0].second == stands) continue;
    stands = &log[0].second;
    moved_at = i;
  }
  EXPECT_LT(moved_at, kSlots / 2);
  EXPECT_EQ(log[kSlots - 1].second.value, kSlots - 1);
}

// Goal: what is given away holds no more memory than it needs, and is not copied where it is large.
TEST(RecordLog, GivesItsArraysAway) {
  constexpr std::int32_t kSlots = 2'000'000;
  for (const std::int32_t count : {0, 5'000, 600'000}) {
    RowLog log;
    for (std::int32_t i = 0; i < count; ++i) log.Add(VertexId(i), {i}, kSlots);
    const Row* const stood = count > 0 ? &log[0].second : nullptr;
    const auto [ids, records] = log.Take();
    EXPECT_TRUE(log.empty());
    EXPECT_EQ(std::ssize(ids), count);
    ASSERT_EQ(std::ssize(records), count);
    if (count > 0) {
      EXPECT_EQ(records.back().value, count - 1);
    }
    if (count == 600'000) {
      EXPECT_EQ(records.data(), stood);
    } else {
      EXPECT_LE(records.capacity(), records.size() + records.size() / 8);
      EXPECT_LE(ids.capacity(), ids.size() + ids.size() / 8);
    }
    log.Add(VertexId(3), {4}, kSlots);
    EXPECT_EQ(ValuesOf(log), std::vector<std::int32_t>{4});
  }
}

}  // namespace
}  // namespace pliant
