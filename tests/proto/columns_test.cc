#include "proto/columns.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace pliant::wire {
namespace {

using testing::HasSubstr;

struct Point {
  double x = 0;
  double y = 0;
  friend bool operator==(const Point&, const Point&) = default;
};

constexpr std::int64_t kBlobBytesMax = 4 * 1024 * 1024;

struct Sent {
  std::vector<v1::BlobChunk> chunks;
  ColumnWriter writer{[this](v1::BlobChunk chunk) { chunks.push_back(std::move(chunk)); }};
};

std::vector<Point> Points(std::size_t count) {
  std::vector<Point> points(count);
  for (std::size_t i = 0; i < count; ++i) {
    points[i] = {1.0 / static_cast<double>(i + 1), -static_cast<double>(i)};
  }
  return points;
}

// Goal: what was written is read, bit for bit, on both sides of every limit.
// Method: row counts around the inline limit (4,096 points) and around whole chunks (32,768).
TEST(Columns, RowsComeBackBitForBitAroundEveryLimit) {
  for (const std::size_t count : {0, 1, 4095, 4096, 4097, 32768, 32769, 65536, 100000}) {
    SCOPED_TRACE(count);
    const auto points = Points(count);
    Sent sent;
    const v1::Array array = sent.writer.Write<double, 2, Point>(points);

    EXPECT_EQ(sent.chunks.empty(), count <= 4096);
    ColumnReader reader(kBlobBytesMax);
    for (const auto& chunk : sent.chunks) {
      EXPECT_LE(chunk.data().size(), kChunkBytesMax);
      ASSERT_TRUE(reader.Add(chunk).ok());
    }
    const auto back = reader.Read<double, 2, Point>(array, "points");
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(*back, points);
  }
}

TEST(Columns, TheLayoutIsTheOneOfTheProtocol) {
  Sent sent;
  const std::vector<std::int32_t> ids = {1, -2};
  const v1::Array array = sent.writer.Write<std::int32_t, 1, std::int32_t>(ids);
  EXPECT_EQ(array.dtype(), v1::DTYPE_INT32);
  ASSERT_EQ(array.shape_size(), 1);
  EXPECT_EQ(array.shape(0), 2);
  EXPECT_EQ(array.data(), std::string("\x01\0\0\0\xfe\xff\xff\xff", 8));
}

TEST(Columns, BytesAreAColumnToo) {
  const std::vector<std::byte> bytes(3 * kChunkBytesMax + 7, std::byte{0x5a});
  Sent sent;
  const v1::Array array = sent.writer.Write<std::uint8_t, 1, std::byte>(bytes);
  EXPECT_EQ(array.dtype(), v1::DTYPE_UINT8);
  EXPECT_EQ(array.shape(0), static_cast<std::int64_t>(bytes.size()));
  EXPECT_EQ(sent.chunks.size(), 4U);
  ColumnReader reader(kBlobBytesMax);
  for (const auto& chunk : sent.chunks) ASSERT_TRUE(reader.Add(chunk).ok());
  EXPECT_EQ((*reader.Read<std::uint8_t, 1, std::byte>(array, "bytes")), bytes);
}

TEST(Columns, AnAbsentArrayHasNoRows) {
  ColumnReader reader(kBlobBytesMax);
  const auto rows = reader.Read<double, 2, Point>(v1::Array(), "points");
  ASSERT_TRUE(rows.ok());
  EXPECT_TRUE(rows->empty());
}

TEST(Columns, AnotherTypeOrShapeIsRefusedWithTheFieldsName) {
  Sent sent;
  const v1::Array array = sent.writer.Write<double, 2, Point>(Points(3));
  ColumnReader reader(kBlobBytesMax);
  const auto other_type = reader.Read<std::int32_t, 2, std::array<std::int32_t, 2>>(array, "edges");
  ASSERT_FALSE(other_type.ok());
  EXPECT_EQ(other_type.error().code, ErrorCode::kArrayType);
  EXPECT_EQ(other_type.error().field, "edges");

  const auto other_shape = reader.Read<double, 1, double>(array, "sizes");
  ASSERT_FALSE(other_shape.ok());
  EXPECT_EQ(other_shape.error().code, ErrorCode::kArrayLength);

  v1::Array short_array = array;
  short_array.mutable_data()->pop_back();
  const auto truncated = reader.Read<double, 2, Point>(short_array, "points");
  ASSERT_FALSE(truncated.ok());
  EXPECT_EQ(truncated.error().code, ErrorCode::kArrayLength);
  EXPECT_THAT(truncated.error().message, HasSubstr("47 bytes"));
}

TEST(Columns, ABlobIsUsedOnce) {
  Sent sent;
  const v1::Array array = sent.writer.Write<double, 2, Point>(Points(5000));
  ColumnReader reader(kBlobBytesMax);
  EXPECT_FALSE((reader.Read<double, 2, Point>(array, "points").ok()));
  for (const auto& chunk : sent.chunks) ASSERT_TRUE(reader.Add(chunk).ok());
  EXPECT_TRUE((reader.Read<double, 2, Point>(array, "points").ok()));
  const auto again = reader.Read<double, 2, Point>(array, "points");
  ASSERT_FALSE(again.ok());
  EXPECT_EQ(again.error().code, ErrorCode::kProtocolOrder);
}

// Goal: every way in which chunks can fail to fit together is noticed.
TEST(Columns, ChunksThatDoNotFitTogetherAreRefused) {
  Sent sent;
  static_cast<void>(sent.writer.Write<double, 2, Point>(Points(70000)));
  static_cast<void>(sent.writer.Write<double, 2, Point>(Points(70000)));
  ASSERT_EQ(sent.chunks.size(), 6U);
  const auto code_of = [&](const std::vector<v1::BlobChunk>& chunks) {
    ColumnReader reader(kBlobBytesMax);
    for (const auto& chunk : chunks) {
      if (const Status status = reader.Add(chunk); !status.ok()) return status.error().code;
    }
    return ErrorCode::kInternal;
  };
  const auto& c = sent.chunks;
  EXPECT_EQ(code_of({c[0], c[2]}), ErrorCode::kProtocolOrder) << "a gap";
  EXPECT_EQ(code_of({c[0], c[0]}), ErrorCode::kProtocolOrder) << "a repetition";
  EXPECT_EQ(code_of({c[0], c[3]}), ErrorCode::kProtocolOrder) << "mixed blobs";
  EXPECT_EQ(code_of({c[1]}), ErrorCode::kProtocolOrder) << "not from the start";
  EXPECT_EQ(code_of({c[3], c[4], c[5], c[0]}), ErrorCode::kProtocolOrder) << "numbers go down";
  v1::BlobChunk other_total = c[1];
  other_total.set_total_bytes(other_total.total_bytes() + 1);
  EXPECT_EQ(code_of({c[0], other_total}), ErrorCode::kProtocolOrder) << "another total";
  v1::BlobChunk empty = c[0];
  empty.clear_data();
  EXPECT_EQ(code_of({empty}), ErrorCode::kTooLarge) << "no bytes";
  v1::BlobChunk beyond = c[0];
  beyond.set_total_bytes(kBlobBytesMax + 1);
  EXPECT_EQ(code_of({beyond}), ErrorCode::kTooLarge) << "beyond the limit";
}

TEST(Columns, TheSixtyFifthWaitingBlobIsRefused) {
  ColumnReader reader(kBlobBytesMax);
  for (std::int64_t id = 1; id <= 65; ++id) {
    v1::BlobChunk chunk;
    chunk.set_blob_id(id);
    chunk.set_total_bytes(1);
    chunk.set_data("x");
    EXPECT_EQ(reader.Add(chunk).ok(), id <= 64) << id;
  }
}

}  // namespace
}  // namespace pliant::wire
