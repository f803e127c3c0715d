// Goal: whatever arrives as chunks and arrays is read as rows that were stated, or refused.
// Method: right ones, mutated; the same trial is what tests/fuzz/columns_fuzz.cc runs.
// Replay: PLIANT_SEED=17 proto_tests --gtest_filter='ColumnBytes.*'
#include <google/protobuf/stubs/logging.h>
#include <gtest/gtest.h>

#include <vector>

#include "tests/support/columns_trial.h"
#include "tests/support/seed.h"

namespace pliant::test {
namespace {

/// Arrays inside their message and one that is sent ahead, of every kind of column.
std::vector<Piece> Corpus() {
  std::vector<Piece> pieces;
  wire::ColumnWriter writer([&](const v1::BlobChunk& chunk) {
    pieces.push_back({.choice = 0, .bytes = chunk.SerializeAsString()});
  });
  const auto add = [&](std::uint8_t choice, const v1::Array& array) {
    pieces.push_back({.choice = choice, .bytes = array.SerializeAsString()});
  };
  const std::vector<VertexId> ids{VertexId(0), VertexId(7)};
  const std::vector<Vec2> points{{0, 1}, {2, 3}};
  const std::vector<Metric> tensors{Metric::Isotropic(1), Metric::Isotropic(2)};
  add(1, writer.Write<std::int32_t, 1, VertexId>(ids));
  add(2, writer.Write<double, 2, Vec2>(points));
  add(4, writer.Write<double, 3, Metric>(tensors));
  v1::BlobChunk chunk;  // Smaller than a writer would send ahead, but right.
  chunk.set_blob_id(1);
  chunk.set_total_bytes(16);
  chunk.set_data(std::string(8, '\1'));
  pieces.push_back({.choice = 0, .bytes = chunk.SerializeAsString()});
  chunk.set_offset_bytes(8);
  pieces.push_back({.choice = 0, .bytes = chunk.SerializeAsString()});
  v1::Array named;
  named.set_dtype(v1::DTYPE_FLOAT64);
  named.add_shape(2);
  named.set_blob_id(1);
  add(5, named);
  return pieces;
}

TEST(ColumnBytes, TheCorpusIsTaken) {
  WriteSeed("columns", Corpus());
  EXPECT_EQ(TryColumns(Join(Corpus())), "");
  wire::ColumnReader reader(1 << 20);
  int count = 0;
  for (const Piece& piece : Corpus()) {
    v1::BlobChunk chunk;
    v1::Array array;
    if (piece.choice == 0) {
      ASSERT_TRUE(chunk.ParseFromString(piece.bytes) && reader.Add(chunk).ok());
    } else if (piece.choice == 5) {
      ASSERT_TRUE(array.ParseFromString(piece.bytes));
      EXPECT_EQ((reader.Read<double, 1, double>(array, "x"))->size(), 2U);
      ++count;
    }
  }
  EXPECT_EQ(count, 1);
}

TEST(ColumnBytes, NothingIsReadThatWasNotStated) {
  const google::protobuf::LogSilencer silencer;
  const std::uint64_t first = FirstSeed();
  for (std::uint64_t seed = first; seed < first + 50'000; ++seed) {
    Rng rng(seed);
    ASSERT_EQ(TryColumns(Join(Mutated(Corpus(), rng))), "") << "seed " << seed;
  }
}

}  // namespace
}  // namespace pliant::test
