#include "core/base/result.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <regex>
#include <string>
#include <vector>

namespace pliant {
namespace {

// The enumerators of ErrorCode in the order of its declaration, read from the header.
std::vector<std::string> DeclaredCodes() {
  std::ifstream header(PLIANT_SOURCE_DIR "/core/base/result.h");
  std::vector<std::string> names;
  const std::regex enumerator(R"(^  k([A-Za-z]+),.*)");
  bool inside = false;
  for (std::string line; std::getline(header, line);) {
    std::smatch match;
    inside = line == "enum class ErrorCode {" || (inside && line != "};");
    if (inside && std::regex_match(line, match, enumerator)) names.push_back(match[1]);
  }
  return names;
}

// OpenLoop -> OPEN_LOOP
std::string UpperSnakeCase(const std::string& name) {
  std::string result;
  for (const char c : name) {
    const bool is_upper = c >= 'A' && c <= 'Z';
    if (is_upper && !result.empty()) result += '_';
    result += is_upper ? c : static_cast<char>(c - 'a' + 'A');
  }
  return result;
}

// Goal: a code's name on the wire is its name in C++, for every code.
// Method: the declaration itself is the oracle.
TEST(ErrorCode, NameOnTheWireIsTheNameOfTheEnumerator) {
  const std::vector<std::string> names = DeclaredCodes();
  ASSERT_EQ(names.size(), static_cast<std::size_t>(ErrorCode::kInternal) + 1);
  for (std::size_t i = 0; i < names.size(); ++i) {
    EXPECT_EQ(ErrorCodeName(static_cast<ErrorCode>(i)), UpperSnakeCase(names[i]));
  }
}

Result<int> Half(int x) {
  if (x % 2 != 0) return Error{ErrorCode::kOutOfRange, "odd", "x", x};
  return x / 2;
}

Result<int> Quarter(int x) {
  PLIANT_ASSIGN_OR_RETURN(const int half, Half(x));
  return Half(half);
}

Status CheckEven(int x) {
  PLIANT_RETURN_IF_ERROR(Half(x));
  return {};
}

TEST(Result, HoldsAValueOrAnError) {
  EXPECT_EQ(*Half(8), 4);
  const Result<int> odd = Half(7);
  ASSERT_FALSE(odd.ok());
  EXPECT_EQ(odd.error().code, ErrorCode::kOutOfRange);
  EXPECT_EQ(odd.error().field, "x");
  EXPECT_EQ(odd.error().index, 7);
  EXPECT_EQ(odd.error().other_index, -1);
}

TEST(Result, AskingForWhatIsNotThereIsABug) {
  EXPECT_THROW(static_cast<void>(Half(7).value()), InvariantViolation);
  EXPECT_THROW(static_cast<void>(Half(8).error()), InvariantViolation);
  EXPECT_THROW(static_cast<void>(CheckEven(8).error()), InvariantViolation);
}

TEST(Result, MacrosHandOnTheFirstError) {
  EXPECT_EQ(*Quarter(8), 2);
  EXPECT_EQ(Quarter(6).error().index, 3);
  EXPECT_EQ(Quarter(5).error().index, 5);
  EXPECT_TRUE(CheckEven(4).ok());
  EXPECT_EQ(CheckEven(5).error().index, 5);
}

TEST(Result, MovesValuesThatCannotBeCopied) {
  Result<std::unique_ptr<int>> result(std::make_unique<int>(3));
  const std::unique_ptr<int> owned = *std::move(result);
  EXPECT_EQ(*owned, 3);
}

}  // namespace
}  // namespace pliant
