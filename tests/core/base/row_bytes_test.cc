#include "core/base/row_bytes.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace pliant {
namespace {

using Row = std::array<std::int32_t, 3>;

Bytes Written(const std::vector<Row>& rows) {
  ByteWriter writer;
  PutRows<std::int32_t>(rows, writer);
  return std::move(writer).Take();
}

TEST(RowBytes, BringsRowsBack) {
  for (const std::vector<Row>& rows :
       {std::vector<Row>{}, std::vector<Row>{{1, -2, 3}, {4, 5, 6}}}) {
    const Bytes bytes = Written(rows);
    ByteReader reader(bytes);
    EXPECT_EQ((TakeRows<std::int32_t, Row>(reader)), rows);
    EXPECT_TRUE(reader.AtEnd());
  }
}

// Goal: rows are stored as a column of their numbers, so that a reader needs no other code.
TEST(RowBytes, AreOneColumn) {
  const Bytes bytes = Written({{1, -2, 3}});
  ByteReader reader(bytes);
  EXPECT_EQ(reader.TakeColumn<std::int32_t>(), (std::vector<std::int32_t>{1, -2, 3}));
}

TEST(RowBytes, RefuseAnIncompleteRow) {
  ByteWriter writer;
  writer.PutColumn(std::vector<std::int32_t>{1, 2, 3, 4});
  const Bytes bytes = std::move(writer).Take();
  ByteReader reader(bytes);
  EXPECT_TRUE((TakeRows<std::int32_t, Row>(reader).empty()));
  EXPECT_FALSE(reader.ok());
}

}  // namespace
}  // namespace pliant
