#include "core/transfer/check_fields.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/field_testing.h"

namespace pliant {
namespace {

class CheckFields : public ::testing::Test {
 protected:
  CheckFields() : edited_(testing::ImportedMesh(testing::GridData(2, 1))) {
    (void)edited_->edit.Commit(Revision(1));
    known_.push_back({.name = "known", .values = std::vector<double>(6)});
  }

  Error ErrorOf(const FieldValues& values) { return ErrorOfUpdate({.values = {values}}); }
  Error ErrorOfUpdate(const FieldUpdate& update) {
    const Status status = CheckFieldUpdate(edited_->mesh, known_, update);
    return status.ok() ? Error{ErrorCode::kInternal, "accepted"} : status.error();
  }

  std::unique_ptr<testing::EditedMesh> edited_;
  std::vector<Field> known_;
};

TEST_F(CheckFields, AcceptsValuesAtAllAndAtSomeElements) {
  EXPECT_EQ(ErrorOf({.name = "new_1", .values = std::vector<double>(6)}).message, "accepted");
  EXPECT_EQ(ErrorOf({.name = "cells",
                     .location = FieldLocation::kTriangle,
                     .column_count = 3,
                     .values = std::vector<double>(12)})
                .message,
            "accepted");
  EXPECT_EQ(ErrorOf({.name = "known", .ids = {{0, 5}}, .values = {1, 2}}).message, "accepted");
}

TEST_F(CheckFields, RefusesNamesAndShapes) {
  for (const char* name : {"", "Name", "a b", "\xc3\xa4"}) {
    const Error error = ErrorOf({.name = name, .values = std::vector<double>(6)});
    EXPECT_EQ(error.code, ErrorCode::kOutOfRange) << name;
    EXPECT_EQ(error.field, "fields.name");
  }
  EXPECT_EQ(ErrorOf({.name = std::string(65, 'a'), .values = std::vector<double>(6)}).code,
            ErrorCode::kOutOfRange);
  EXPECT_EQ(ErrorOf({.name = "a", .column_count = 4, .values = std::vector<double>(24)}).code,
            ErrorCode::kOutOfRange);
  EXPECT_EQ(ErrorOf({.name = "a", .values = std::vector<double>(5)}).code, ErrorCode::kArrayLength);
  EXPECT_EQ(ErrorOf({.name = "known", .ids = {{1}}, .values = {1, 2}}).code,
            ErrorCode::kArrayLength);
}

TEST_F(CheckFields, NamesTheFirstBadEntry) {
  std::vector<double> values(6);
  values[4] = std::numeric_limits<double>::quiet_NaN();
  const Error not_finite = ErrorOf({.name = "a", .values = values});
  EXPECT_EQ(not_finite.code, ErrorCode::kNotFinite);
  EXPECT_EQ(not_finite.index, 4);
  const Error no_vertex = ErrorOf({.name = "known", .ids = {{2, 6}}, .values = {1, 2}});
  EXPECT_EQ(no_vertex.code, ErrorCode::kIndexOutOfRange);
  EXPECT_EQ(no_vertex.index, 1);
  const Error twice = ErrorOf({.name = "known", .ids = {{2, 4, 4}}, .values = {1, 2, 3}});
  EXPECT_EQ(twice.code, ErrorCode::kDuplicateId);
  EXPECT_EQ(twice.index, 2);
}

TEST_F(CheckFields, RefusesSomeValuesOfAFieldThatIsNotThere) {
  EXPECT_EQ(ErrorOf({.name = "other", .ids = {{1}}, .values = {1}}).code, ErrorCode::kEmpty);
  EXPECT_EQ(
      ErrorOf({.name = "known", .location = FieldLocation::kTriangle, .ids = {{1}}, .values = {1}})
          .code,
      ErrorCode::kEmpty);
}

TEST_F(CheckFields, RefusesTheSameNameTwiceAndUnknownDrops) {
  const FieldValues values{.name = "a", .ids = {}, .values = std::vector<double>(6)};
  EXPECT_EQ(ErrorOfUpdate({.values = {values, values}}).code, ErrorCode::kDuplicateId);
  EXPECT_EQ(ErrorOfUpdate({.dropped_names = {"a"}}).code, ErrorCode::kOutOfRange);
}

TEST_F(CheckFields, BoundsTheCountOfFields) {
  for (std::size_t i = known_.size(); i < FieldSet::kFieldsMax; ++i) {
    known_.push_back({.name = std::string("f").append(std::to_string(i)), .values = {}});
  }
  EXPECT_EQ(ErrorOf({.name = "one_more", .values = std::vector<double>(6)}).code,
            ErrorCode::kTooLarge);
  EXPECT_EQ(ErrorOf({.name = "known", .values = std::vector<double>(6)}).message, "accepted");
}

}  // namespace
}  // namespace pliant
