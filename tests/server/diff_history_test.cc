#include "server/diff_history.h"

#include <gtest/gtest.h>

#include "core/mesh/merge_diffs.h"

namespace pliant::server {
namespace {

// Vertex 0 moves to x = revision; vertex `revision` is new.
std::shared_ptr<const MeshDiff> Diff(std::int64_t revision) {
  MeshDiff diff;
  diff.base_revision = Revision(revision - 1);
  diff.revision = Revision(revision);
  diff.vertex_ids = {VertexId(0), VertexId(static_cast<std::int32_t>(revision))};
  diff.vertex_positions = {{static_cast<double>(revision), 0}, {1, 1}};
  diff.created_vertices = {VertexId(static_cast<std::int32_t>(revision))};
  return std::make_shared<const MeshDiff>(std::move(diff));
}

TEST(DiffHistory, TellsWhatAReaderMissedAsOneDiff) {
  DiffHistory history(1 << 20);
  EXPECT_EQ(history.Since(Revision(0)), nullptr);
  for (std::int64_t revision = 5; revision <= 12; ++revision) history.Add(Diff(revision));
  EXPECT_EQ(history.Since(Revision(3)), nullptr);
  EXPECT_EQ(history.Since(Revision(12)), nullptr);
  EXPECT_EQ(history.Since(Revision(20)), nullptr);
  const auto newest = history.Since(Revision(11));
  EXPECT_EQ(newest->revision, Revision(12));
  EXPECT_EQ(newest->vertex_ids.size(), 2U);
  for (std::int64_t from = 4; from < 11; ++from) {
    const auto merged = history.Since(Revision(from));
    ASSERT_NE(merged, nullptr);
    EXPECT_EQ(merged->base_revision, Revision(from));
    EXPECT_EQ(merged->revision, Revision(12));
    EXPECT_EQ(merged->vertex_ids.size(), static_cast<std::size_t>(13 - from));
    EXPECT_EQ(merged->vertex_positions[0].x, 12);
  }
}

TEST(DiffHistory, IsBoundedByBytesAndDropsTheOldest) {
  const std::size_t each = BytesOf(*Diff(1));
  DiffHistory history(3 * each);
  for (std::int64_t revision = 1; revision <= 3; ++revision) history.Add(Diff(revision));
  EXPECT_NE(history.Since(Revision(0)), nullptr);
  history.Add(Diff(4));
  EXPECT_EQ(history.bytes(), 3 * each);
  EXPECT_EQ(history.Since(Revision(0)), nullptr);
  EXPECT_NE(history.Since(Revision(1)), nullptr);
}

TEST(DiffHistory, TakesAnotherBound) {
  const std::size_t each = BytesOf(*Diff(1));
  DiffHistory history(100 * each);
  for (std::int64_t revision = 1; revision <= 5; ++revision) history.Add(Diff(revision));
  history.SetBytesMax(2 * each);
  history.Add(Diff(6));
  EXPECT_EQ(history.bytes(), 2 * each);
  EXPECT_EQ(history.Since(Revision(3)), nullptr);
  EXPECT_NE(history.Since(Revision(4)), nullptr);
}

TEST(DiffHistory, KeepsOneThatIsTooLargeUntilItIsTrimmed) {
  DiffHistory history(10);
  history.Add(Diff(1));
  EXPECT_NE(history.Since(Revision(0)), nullptr);
  history.Trim();
  EXPECT_EQ(history.Since(Revision(0)), nullptr);
  EXPECT_EQ(history.bytes(), 0U);
  history.Add(Diff(2));
  EXPECT_NE(history.Since(Revision(1)), nullptr);
}

TEST(DiffHistory, AGapEmptiesIt) {
  DiffHistory history(1 << 20);
  history.Add(Diff(1));
  history.Add(Diff(2));
  history.Add(Diff(7));
  EXPECT_EQ(history.count(), 1U);
  EXPECT_EQ(history.Since(Revision(1)), nullptr);
  EXPECT_NE(history.Since(Revision(6)), nullptr);
}

}  // namespace
}  // namespace pliant::server
