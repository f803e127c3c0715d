#include "core/metric/expression.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <clocale>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>

#include "core/base/rng.h"

namespace pliant {
namespace {

using ::testing::HasSubstr;

double Value(std::string_view text, Vec2 p = {}, double t = 0) {
  const Result<Expression> expression = Expression::Parse(text);
  EXPECT_TRUE(expression.ok()) << text << ": " << expression.error().message;
  return expression.ok() ? expression->Evaluate(p, t) : std::nan("");
}

Error Refusal(std::string_view text) {
  const Result<Expression> expression = Expression::Parse(text);
  EXPECT_FALSE(expression.ok()) << text;
  return expression.ok() ? Error{} : expression.error();
}

TEST(Expression, HasVariablesConstantsAndNumbers) {
  EXPECT_EQ(Value("x + 10*y + 100*t", {1, 2}, 3), 321);
  EXPECT_EQ(Value("pi"), std::numbers::pi);
  EXPECT_EQ(Value("e"), std::numbers::e);
  EXPECT_EQ(Value("1.5e-3"), 1.5e-3);
  EXPECT_EQ(Value(".5"), 0.5);
  EXPECT_EQ(Value("2."), 2);
  EXPECT_EQ(Value("1E3"), 1000);
  EXPECT_EQ(Value(" \t\r\n1 \n"), 1);
  EXPECT_EQ(Value("x", {7, 8}), 7);
}

TEST(Expression, HasTheUsualPrecedence) {
  EXPECT_EQ(Value("2+3*4^2/8-1"), 7);
  EXPECT_EQ(Value("-x^2", {3, 0}), -9);
  EXPECT_EQ(Value("(-x)^2", {3, 0}), 9);
  EXPECT_EQ(Value("2^3^2"), 512);
  EXPECT_EQ(Value("2^-1"), 0.5);
  EXPECT_EQ(Value("2*-x", {3, 0}), -6);
  EXPECT_EQ(Value("+x", {3, 0}), 3);
  EXPECT_EQ(Value("10-4-3"), 3);
  EXPECT_EQ(Value("100/10/5"), 2);
  EXPECT_EQ(Value("x^-2*y", {2, 8}), 2);
  EXPECT_EQ(Value("1+2 < 4 && 3 == 3"), 1);
}

TEST(Expression, HasConditionsAndLogic) {
  EXPECT_EQ(Value("x < 0 ? 1 : x > 0 ? 2 : 3", {-1, 0}), 1);
  EXPECT_EQ(Value("x < 0 ? 1 : x > 0 ? 2 : 3", {1, 0}), 2);
  EXPECT_EQ(Value("x < 0 ? 1 : x > 0 ? 2 : 3", {0, 0}), 3);
  EXPECT_EQ(Value("(x < 0 ? y < 0 ? 1 : 2 : 3) + 10", {-1, 1}), 12);
  EXPECT_EQ(Value("0.5 && 1"), 1);
  EXPECT_EQ(Value("0 || 0.25"), 1);
  EXPECT_EQ(Value("!x", {0, 0}), 1);
  EXPECT_EQ(Value("x != y", {1, 2}), 1);
  EXPECT_EQ(Value("(x <= 1) + (x >= 1) + (x == 1)", {1, 0}), 3);
  EXPECT_EQ(Value("max(x > 0 ? 1 : 2, 0)", {-1, 0}), 2);
  EXPECT_EQ(Value("max(0, x > 0 ? 1 : 2)", {-1, 0}), 2);
}

TEST(Expression, CallsFunctions) {
  EXPECT_EQ(Value("min(3, 1, 2)"), 1);
  EXPECT_EQ(Value("max(x)", {4, 0}), 4);
  EXPECT_EQ(Value("clamp(x, 0, 1)", {4, 0}), 1);
  EXPECT_EQ(Value("sqrt (16)"), 4);
  EXPECT_DOUBLE_EQ(Value("exp(-(x^2+y^2)/2)", {1, 2}), std::exp(-2.5));
  EXPECT_DOUBLE_EQ(Value("atan2(sin(x), cos(x))", {1, 0}), 1);
  EXPECT_DOUBLE_EQ(Value("x^0.3", {2, 0}), std::pow(2, 0.3));
}

// Goal: a whole exponent means multiplication, constant or not, so that a formula has no rounding
// of its own. Method: compare bits at random bases.
TEST(Expression, RaisesToWholePowersByMultiplication) {
  Rng rng(1996);
  for (int i = 0; i < 1000; ++i) {
    const double x = rng.Uniform(-3, 3);
    EXPECT_EQ(Value("x^2", {x, 0}), x * x);
    EXPECT_EQ(Value("x^y", {x, 2}), x * x);
    EXPECT_EQ(Value("x^4", {x, 0}), (x * x) * (x * x));
    EXPECT_EQ(Value("x^-1", {x, 0}), 1 / x);
  }
}

TEST(Expression, GivesNaNOrInfinityWhereItIsNotDefined) {
  EXPECT_TRUE(std::isnan(Value("sqrt(x)", {-1, 0})));
  EXPECT_TRUE(std::isinf(Value("1/x", {0, 0})));
  EXPECT_TRUE(std::isnan(Value("0/x", {0, 0})));
}

TEST(Expression, IgnoresTheLocale) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "C.UTF-8"}) {
    std::setlocale(LC_ALL, name);
    EXPECT_EQ(Value("1.25 + max(1,5)"), 6.25);
  }
  std::setlocale(LC_ALL, before.c_str());
}

TEST(Expression, NamesTheOffendingTokenAndItsPosition) {
  struct Case {
    const char* text;
    std::int64_t index;
    const char* part;
  };
  const Case cases[] = {
      {"1 + foo*2", 4, "unknown name 'foo' at position 4"},
      {"1 + foo*2", 4, "atan2"},
      {"sim(x)", 0, "unknown name 'sim'"},
      {"X", 0, "unknown name 'X'"},
      {"sin x", 0, "needs its arguments in parentheses"},
      {"1 + sin", 4, "needs its arguments in parentheses"},
      {"x = 3", 2, "to compare, write '=='"},
      {"1e999", 0, "'1e999' at position 0 is not a number"},
      {"1 + .", 4, "not a number"},
      {"1 # 2", 2, "'#' at position 2 has no meaning"},
      {"\"a\"", 0, "has no meaning"},
      {"1 + \x01", 4, "a character at position 4"},
      {"\xc3\xa9", 0, "a character at position 0"},
      {"1 +", 3, "ends too early"},
      {"", 0, "ends too early"},
      {"   ", 3, "ends too early"},
      {"(1 + 2", 6, "closing parenthesis is missing"},
      {"1 + 2)", 5, "unexpected ')' at position 5"},
      {"2 x", 2, "unexpected 'x' at position 2"},
      {"x y", 2, "unexpected 'y' at position 2"},
      {"1 * / 2", 4, "unexpected '/' at position 4"},
      {"2 3", 2, "unexpected '3' at position 2"},
      {"atan2(1)", 7, "too few arguments for the function 'atan2'"},
      {"sin(1, 2)", 8, "too many arguments for the function 'sin'"},
      {"x ? 1", 5, "incomplete conditional"},
      {"1 : 2", 3, "incomplete conditional"},
      {"1, 2", 0, "must have one value"},
      {"x & 1", 2, "unexpected"},
      {"()", 1, "unexpected"},
      {"max()", 5, "too few arguments"},
  };
  for (const Case& c : cases) {
    const Error error = Refusal(c.text);
    EXPECT_EQ(error.code, ErrorCode::kExpressionSyntax) << c.text;
    EXPECT_EQ(error.index, c.index) << c.text << ": " << error.message;
    EXPECT_THAT(error.message, HasSubstr(c.part)) << c.text;
  }
}

TEST(Expression, BoundsLengthNestingAndDepth) {
  const std::string longest(Expression::kLengthMax - 1, ' ');
  EXPECT_EQ(Value(longest + "1"), 1);
  EXPECT_EQ(Refusal(longest + "12").code, ErrorCode::kTooLarge);

  const auto nested = [](int count) {
    return std::string(static_cast<std::size_t>(count), '(') + "x" +
           std::string(static_cast<std::size_t>(count), ')');
  };
  EXPECT_EQ(Value(nested(Expression::kNestingMax), {5, 0}), 5);
  const Error error = Refusal(nested(Expression::kNestingMax + 1));
  EXPECT_EQ(error.code, ErrorCode::kTooLarge);
  EXPECT_EQ(error.index, Expression::kNestingMax);

  const auto tower = [](int count) {
    std::string text = "x";
    for (int i = 1; i < count; ++i) text += "^x";
    return text;
  };
  EXPECT_EQ(Value(tower(ExpressionProgram::kDepthMax), {1, 0}), 1);
  EXPECT_EQ(Refusal(tower(ExpressionProgram::kDepthMax + 1)).code, ErrorCode::kExpressionSyntax);

  std::string sum = "0";
  while (sum.size() + 2 <= Expression::kLengthMax) sum += "+x";
  EXPECT_EQ(Value(sum, {1, 0}), 2047);
}

// Goal: whatever text comes, it is either refused with a position inside it or evaluates.
// Method: random soup of tokens that look like expressions. Run it under sanitizers too; the seed
// is in the failure message, and the fuzzer in tests/fuzz goes deeper.
TEST(Expression, SurvivesTokenSoup) {
  const char* const tokens[] = {"x", "y",   "t",    "1",     "2.5", "1e3", "pi",  "e",     "+",
                                "-", "*",   "/",    "^",     "(",   ")",   ",",   "?",     ":",
                                "<", ">",   "<=",   ">=",    "==",  "!=",  "&&",  "||",    "!",
                                " ", "sin", "max(", "atan2", "(",   ")",   "(x",  "clamp", "=",
                                ".", "foo", "#",    "exp(",  "x*",  "+1",  "?x:y"};
  for (std::uint64_t seed = 0; seed < 20000; ++seed) {
    Rng rng(seed);
    std::string text;
    const std::uint64_t count = 1 + rng.Below(12);
    for (std::uint64_t i = 0; i < count; ++i) text += tokens[rng.Below(std::size(tokens))];
    SCOPED_TRACE(::testing::Message() << "seed " << seed << ": " << text);
    const Result<Expression> expression = Expression::Parse(text);
    if (expression.ok()) {
      const double value = expression->Evaluate({0.5, -0.25}, 2);
      ASSERT_TRUE(std::isnan(value) || value == expression->Evaluate({0.5, -0.25}, 2));
    } else {
      ASSERT_GE(expression.error().index, 0);
      ASSERT_LE(expression.error().index, static_cast<std::int64_t>(text.size()));
      ASSERT_FALSE(expression.error().message.empty());
    }
  }
}

}  // namespace
}  // namespace pliant
