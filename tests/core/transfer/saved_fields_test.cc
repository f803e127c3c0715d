#include "core/transfer/saved_fields.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace pliant {
namespace {

constexpr std::int32_t kVertices = 4;
constexpr std::int32_t kTriangles = 3;

SharedFields TwoFields() {
  const std::vector<Field> fields{{.name = "pressure", .values = {1, 2, 3, -0.0}},
                                  {.name = "stress",
                                   .location = FieldLocation::kTriangle,
                                   .transfer = TransferKind::kConservative,
                                   .column_count = 3,
                                   .values = std::vector<double>(9, 0.5)}};
  return KeepFields(fields);
}

Bytes Written(const SharedFields& fields) {
  ByteWriter writer;
  WriteFields(fields, writer);
  return std::move(writer).Take();
}

TEST(SavedFields, ComeBackAsTheyWere) {
  const Bytes bytes = Written(TwoFields());
  ByteReader reader(bytes);
  const SharedFields back = ReadFields(reader, kVertices, kTriangles);
  ASSERT_TRUE(reader.AtEnd());
  ASSERT_EQ(back->size(), 2U);
  EXPECT_EQ((*back)[1].name, "stress");
  EXPECT_EQ((*back)[1].location, FieldLocation::kTriangle);
  EXPECT_EQ((*back)[1].transfer, TransferKind::kConservative);
  EXPECT_EQ((*back)[1].column_count, 3U);
  EXPECT_EQ(Written(back), bytes);
  EXPECT_EQ(BytesOf(back), 2 * sizeof(Field) + 13 * sizeof(double));
}

TEST(SavedFields, NoneAreNone) {
  EXPECT_EQ(KeepFields({}), nullptr);
  EXPECT_EQ(BytesOf(nullptr), 0U);
  const Bytes bytes = Written(nullptr);
  ByteReader reader(bytes);
  EXPECT_EQ(ReadFields(reader, kVertices, kTriangles), nullptr);
  EXPECT_TRUE(reader.AtEnd());
}

TEST(SavedFields, OfAnotherMeshOrCutOffAreRefused) {
  const Bytes bytes = Written(TwoFields());
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    ByteReader reader(std::span<const std::byte>(bytes).first(size));
    EXPECT_EQ(ReadFields(reader, kVertices, kTriangles), nullptr);
    EXPECT_FALSE(reader.ok()) << size << " bytes";
  }
  for (const auto& [vertices, triangles] : {std::pair{5, 3}, std::pair{4, 2}}) {
    ByteReader reader(bytes);
    (void)ReadFields(reader, vertices, triangles);
    EXPECT_FALSE(reader.ok());
  }
}

}  // namespace
}  // namespace pliant
