#include "client/io/number_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace pliant::io {
namespace {

using std::string_literals::operator""s;
using testing::HasSubstr;

TEST(NumberReader, ReadsNumbersWordsAndComments) {
  NumberReader reader("# title\n 3 +4.5e1 -7 Vertices#x\n1e-3");
  EXPECT_EQ(reader.Integer(), 3);
  EXPECT_EQ(reader.Real(), 45);
  EXPECT_EQ(reader.Tag(), -7);
  EXPECT_EQ(reader.Word(), "Vertices#x");
  EXPECT_EQ(reader.Real(), 0.001);
  EXPECT_TRUE(reader.AtEnd());
  EXPECT_TRUE(reader.ok());
}

TEST(NumberReader, KeepsTheFirstFailureWithItsLine) {
  NumberReader reader("1\n2\nx3 4");
  EXPECT_EQ(reader.Integer(), 1);
  EXPECT_EQ(reader.Integer(), 2);
  EXPECT_EQ(reader.Integer(), 0);
  EXPECT_EQ(reader.Real(), 0);
  ASSERT_FALSE(reader.ok());
  EXPECT_EQ(reader.status().error().code, ErrorCode::kFileSyntax);
  EXPECT_EQ(reader.status().error().index, 3);
  EXPECT_THAT(reader.status().error().message,
              HasSubstr("line 3: expected an integer, found 'x3'"));
}

ErrorCode CodeOfReal(const std::string& text) {
  NumberReader reader(text);
  reader.Real();
  return reader.ok() ? ErrorCode::kInternal : reader.status().error().code;
}

TEST(NumberReader, RefusesWhatIsNoFiniteDouble) {
  EXPECT_EQ(CodeOfReal("nan"), ErrorCode::kNotFinite);
  EXPECT_EQ(CodeOfReal("-inf"), ErrorCode::kNotFinite);
  EXPECT_EQ(CodeOfReal("1e999"), ErrorCode::kOutOfRange);
  EXPECT_EQ(CodeOfReal("1,5"), ErrorCode::kFileSyntax);
  EXPECT_EQ(CodeOfReal("+-1"), ErrorCode::kFileSyntax);
  EXPECT_EQ(CodeOfReal(""), ErrorCode::kFileSyntax);
  EXPECT_EQ(CodeOfReal("4.9e-324"), ErrorCode::kInternal);
}

TEST(NumberReader, BoundsCountsByWhatIsLeft) {
  NumberReader enough("0 0 0 0 ");
  EXPECT_EQ(enough.Count(4, 2), 4U);
  NumberReader too_few("0 0 0 0 ");
  EXPECT_EQ(too_few.Count(5, 2), 0U);
  EXPECT_EQ(too_few.status().error().code, ErrorCode::kFileSyntax);
  NumberReader negative("0");
  EXPECT_EQ(negative.Count(-1, 2), 0U);
  EXPECT_EQ(negative.status().error().code, ErrorCode::kFileSyntax);
  NumberReader huge("0");
  EXPECT_EQ(huge.Count(std::int64_t{1} << 31, 1), 0U);
  EXPECT_EQ(huge.status().error().code, ErrorCode::kTooLarge);
}

TEST(NumberReader, ChecksTheRangeOfTagsAndIndices) {
  NumberReader tag("2147483648");
  tag.Tag();
  EXPECT_EQ(tag.status().error().code, ErrorCode::kOutOfRange);
  NumberReader fraction("1.5");
  fraction.TagFromReal();
  EXPECT_EQ(fraction.status().error().code, ErrorCode::kOutOfRange);
  NumberReader index("0");
  index.Index(1);
  EXPECT_EQ(index.status().error().code, ErrorCode::kIndexOutOfRange);
}

TEST(NumberReader, ReadsBothByteOrders) {
  const std::string little_bytes = "\x01\x02\0\0\0\0\0\0\0\0\xf8\x3f"s;
  NumberReader little(little_bytes);
  little.set_encoding(NumberReader::Encoding::kBinary);
  EXPECT_EQ(little.Integer(), 0x201);
  EXPECT_EQ(little.Real(), 1.5);
  EXPECT_EQ(little.Short(), 0);
  EXPECT_EQ(little.status().error().code, ErrorCode::kFileSyntax);
  EXPECT_EQ(little.status().error().index, 12);
  const std::string big_bytes = "\0\0\x02\x01"s;
  NumberReader big(big_bytes);
  big.set_encoding(NumberReader::Encoding::kBinarySwapped);
  EXPECT_EQ(big.Integer(), 0x201);
}

}  // namespace
}  // namespace pliant::io
