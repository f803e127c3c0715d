#include "server/convert_fields.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/wire_arrays.h"

namespace pliant::server {
namespace {

using test::Doubles;
using test::Ints;
using testing::ElementsAre;

v1::FieldUpdate Pressure() {
  v1::FieldUpdate update;
  update.set_revision(3);
  v1::FieldValues& values = *update.add_values();
  values.set_name("p");
  values.set_location(v1::FIELD_LOCATION_VERTEX);
  *values.mutable_values() = Doubles({1, 2, 3, 4}, 1);
  return update;
}

TEST(ConvertFields, ReadsValuesIdsAndTransfer) {
  v1::FieldUpdate wire = Pressure();
  v1::FieldValues& stress = *wire.add_values();
  stress.set_name("stress");
  stress.set_location(v1::FIELD_LOCATION_TRIANGLE);
  *stress.mutable_ids() = Ints({5, 7});
  *stress.mutable_values() = Doubles({1, 2, 3, 4, 5, 6}, 3);
  wire.set_transfer(v1::TRANSFER_CONSERVATIVE);
  wire.add_dropped_names("old");
  const Result<FieldsUpdate> result = ConvertFields(wire);
  ASSERT_TRUE(result.ok());
  EXPECT_EQ(result->revision, Revision(3));
  EXPECT_EQ(result->update.transfer, TransferKind::kConservative);
  EXPECT_THAT(result->update.dropped_names, ElementsAre("old"));
  ASSERT_EQ(result->update.values.size(), 2U);
  const FieldValues& first = result->update.values[0];
  EXPECT_EQ(first.name, "p");
  EXPECT_EQ(first.location, FieldLocation::kVertex);
  EXPECT_EQ(first.column_count, 1U);
  EXPECT_FALSE(first.ids.has_value());
  EXPECT_THAT(first.values, ElementsAre(1, 2, 3, 4));
  const FieldValues& second = result->update.values[1];
  EXPECT_EQ(second.location, FieldLocation::kTriangle);
  EXPECT_EQ(second.column_count, 3U);
  EXPECT_THAT(*second.ids, ElementsAre(5, 7));
  EXPECT_EQ(second.values.size(), 6U);
}

TEST(ConvertFields, NamesWhatIsWrong) {
  const auto error = [](const v1::FieldUpdate& wire) {
    const auto result = ConvertFields(wire);
    return result.ok() ? Error{ErrorCode::kInternal, "accepted"} : result.error();
  };
  v1::FieldUpdate wire = Pressure();
  wire.mutable_values(0)->set_location(v1::FIELD_LOCATION_UNSPECIFIED);
  EXPECT_EQ(error(wire).field, "fields.location");
  wire = Pressure();
  wire.set_transfer(v1::TRANSFER_UNSPECIFIED);
  EXPECT_EQ(error(wire).field, "fields.transfer");
  wire = Pressure();
  *wire.mutable_values(0)->mutable_values() = Ints({1, 2});
  EXPECT_EQ(error(wire).code, ErrorCode::kArrayType);
  *wire.mutable_values(0)->mutable_values() = Doubles({1, 2, 3, 4}, 4);
  EXPECT_EQ(error(wire).code, ErrorCode::kArrayLength);
  EXPECT_EQ(error(wire).field, "fields.values");
  wire = Pressure();
  for (std::size_t i = 0; i <= FieldSet::kFieldsMax; ++i)
    *wire.add_dropped_names() = std::string(1, 'x');
  EXPECT_EQ(error(wire).code, ErrorCode::kTooLarge);
}

TEST(ConvertSolution, ReadsValuesNamesAndTargets) {
  v1::SolutionMetric wire;
  wire.mutable_field()->set_name("u");
  wire.set_complexity(500);
  Result<SolutionRequest> request = ConvertSolution(wire);
  ASSERT_TRUE(request.ok());
  EXPECT_EQ(request->name, "u");
  EXPECT_FALSE(request->values.has_value());
  EXPECT_EQ(std::get<TargetComplexity>(request->target.target).complexity, 500);
  EXPECT_EQ(request->target.norm_exponent, 2);
  wire.mutable_field()->set_location(v1::FIELD_LOCATION_VERTEX);
  *wire.mutable_field()->mutable_values() = Doubles({1, 2, 3, 4}, 2);
  wire.set_norm_exponent(1);
  wire.set_error(0.25);
  request = ConvertSolution(wire);
  ASSERT_TRUE(request.ok());
  EXPECT_THAT(*request->values, ElementsAre(1, 2, 3, 4));
  EXPECT_EQ(request->column_count, 2U);
  EXPECT_EQ(std::get<TargetError>(request->target.target).error, 0.25);
  EXPECT_EQ(request->target.norm_exponent, 1);
}

TEST(ConvertSolution, NamesWhatIsWrong) {
  v1::SolutionMetric wire;
  EXPECT_EQ(ConvertSolution(wire).error().field, "metric.solution.field");
  wire.mutable_field()->set_name("u");
  EXPECT_EQ(ConvertSolution(wire).error().field, "metric.solution.target");
  wire.set_complexity(5);
  *wire.mutable_field()->mutable_values() = Doubles({1, 2}, 1);
  wire.mutable_field()->set_location(v1::FIELD_LOCATION_TRIANGLE);
  EXPECT_EQ(ConvertSolution(wire).error().field, "metric.solution.field.location");
  wire.mutable_field()->set_location(v1::FIELD_LOCATION_VERTEX);
  *wire.mutable_field()->mutable_ids() = Ints({1, 2});
  EXPECT_EQ(ConvertSolution(wire).error().field, "metric.solution.field.ids");
}

TEST(WriteTransferRows, WritesThreeColumns) {
  TransferRows rows;
  rows.vertex_ids = {VertexId(4)};
  rows.rows = {{.sources = {VertexId(1), VertexId(2), VertexId()}, .weights = {0.25, 0.75, 0}}};
  v1::TransferRows wire;
  WriteTransferRows(rows, wire);
  EXPECT_THAT(test::NumbersOf<std::int32_t>(wire.vertex_ids()), ElementsAre(4));
  EXPECT_THAT(test::NumbersOf<std::int32_t>(wire.sources()), ElementsAre(1, 2, -1));
  EXPECT_THAT(test::NumbersOf<double>(wire.weights()), ElementsAre(0.25, 0.75, 0));
  EXPECT_THAT(wire.weights().shape(), ElementsAre(1, 3));
}

TEST(WriteFields, WritesEveryField) {
  google::protobuf::RepeatedPtrField<v1::FieldValues> wire;
  WriteFields({{.name = "v",
                .location = FieldLocation::kTriangle,
                .column_count = 2,
                .rows = {.slots = {3, 9}, .values = {1, 2, 3, 4}}}},
              wire);
  ASSERT_EQ(wire.size(), 1);
  EXPECT_EQ(wire[0].name(), "v");
  EXPECT_EQ(wire[0].location(), v1::FIELD_LOCATION_TRIANGLE);
  EXPECT_THAT(test::NumbersOf<std::int32_t>(wire[0].ids()), ElementsAre(3, 9));
  EXPECT_THAT(test::NumbersOf<double>(wire[0].values()), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(wire[0].values().shape(), ElementsAre(2, 2));
}

}  // namespace
}  // namespace pliant::server
