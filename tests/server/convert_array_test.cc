#include "server/convert_array.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/wire_arrays.h"

namespace pliant::server {
namespace {

using test::Doubles;
using test::Ints;

TEST(ConvertArray, ReadsAndWritesRowsBitForBit) {
  const std::vector<Vec2> rows = {{-0.0, 1e-310}, {3, -1e300}};
  v1::Array array;
  WriteRows(std::span<const Vec2>(rows), array);
  EXPECT_EQ(array.dtype(), v1::DTYPE_FLOAT64);
  EXPECT_EQ(array.shape(0), 2);
  EXPECT_EQ(array.shape(1), 2);
  const auto back = ReadRows<Vec2>(array, "points");
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(std::memcmp(back->data(), rows.data(), sizeof(Vec2) * 2), 0);
}

TEST(ConvertArray, TakesAnAbsentArrayAsEmpty) {
  const auto rows = ReadRows<Vec2>(v1::Array(), "points");
  ASSERT_TRUE(rows.ok());
  EXPECT_TRUE(rows->empty());
}

ErrorCode CodeOf(const v1::Array& array) {
  const auto rows = ReadRows<Vec2>(array, "points");
  if (rows.ok()) return ErrorCode::kUnavailable;
  EXPECT_EQ(rows.error().field, "points");
  return rows.error().code;
}

TEST(ConvertArray, RefusesAnotherType) {
  EXPECT_EQ(CodeOf(Ints({1, 2, 3, 4}, 2)), ErrorCode::kArrayType);
  v1::Array unspecified = Doubles({1, 2}, 2);
  unspecified.set_dtype(v1::DTYPE_UNSPECIFIED);
  EXPECT_EQ(CodeOf(unspecified), ErrorCode::kArrayType);
}

TEST(ConvertArray, RefusesAnotherShape) {
  EXPECT_EQ(CodeOf(Doubles({1, 2, 3}, 3)), ErrorCode::kArrayLength);
  EXPECT_EQ(CodeOf(Doubles({1, 2}, 1)), ErrorCode::kArrayLength);
}

TEST(ConvertArray, RefusesAShapeThatItsBytesDoNotHave) {
  for (const std::int64_t rows : {std::int64_t{1}, std::int64_t{3}, std::int64_t{-1}, INT64_MAX,
                                  // Times 16 bytes this is 32 modulo 2^64.
                                  (std::int64_t{1} << 60) + 2}) {
    v1::Array array = Doubles({1, 2, 3, 4}, 2);
    array.set_shape(0, rows);
    EXPECT_EQ(CodeOf(array), ErrorCode::kArrayLength) << rows;
  }
  v1::Array cut = Doubles({1, 2, 3, 4}, 2);
  cut.mutable_data()->pop_back();
  EXPECT_EQ(CodeOf(cut), ErrorCode::kArrayLength);
}

TEST(ConvertArray, RefusesABlobThatWasNotPutInPlace) {
  v1::Array array = Doubles({1, 2}, 2);
  array.set_blob_id(1);
  EXPECT_EQ(CodeOf(array), ErrorCode::kProtocolOrder);
}

}  // namespace
}  // namespace pliant::server
