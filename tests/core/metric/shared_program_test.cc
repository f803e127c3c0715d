#include "core/metric/shared_program.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/metric/expression.h"
#include "tests/support/seed.h"

namespace pliant {
namespace {

std::vector<Expression> ParseAll(const std::vector<std::string>& texts) {
  std::vector<Expression> expressions;
  expressions.reserve(texts.size());
  for (const std::string& text : texts) {
    auto parsed = Expression::Parse(text);
    EXPECT_TRUE(parsed.ok()) << text << ": " << parsed.error().message;
    if (parsed.ok()) expressions.push_back(std::move(parsed).value());
  }
  return expressions;
}

std::optional<SharedProgram> Share(const std::vector<Expression>& expressions) {
  std::vector<const ExpressionProgram*> programs;
  programs.reserve(expressions.size());
  for (const Expression& expression : expressions) programs.push_back(&expression.program());
  return SharedProgram::Make(programs);
}

std::optional<SharedProgram> Share(const std::vector<std::string>& texts) {
  return Share(ParseAll(texts));
}

/// A random formula without a condition, of about `size` operations.
std::string RandomFormula(Rng& rng, int size) {
  if (size <= 0) {
    constexpr std::array kLeaves = {"x", "y", "t", "2", "0.5", "-1.25", "pi", "(x*x+y*y)"};
    return kLeaves[rng.Below(kLeaves.size())];
  }
  const auto part = [&] { return "(" + RandomFormula(rng, size - 1 - int(rng.Below(3))) + ")"; };
  constexpr std::array kBinary = {
      "+", "-", "*", "/", "^", "<", "<=", ">", ">=", "==", "!=", "&&", "||"};
  constexpr std::array kUnary = {"exp", "sqrt", "abs", "sin", "log", "cos", "tanh", "step", "-"};
  switch (rng.Below(8)) {
    case 0:
    case 1:
      return std::string(kUnary[rng.Below(kUnary.size())]) + part();
    case 2:
      return part() + "^" + std::to_string(rng.Below(5));
    case 3:
      return "min(" + part() + "," + part() + "," + part() + ")";
    case 4:
      return "max(" + part() + (rng.Below(2) == 0 ? ")" : "," + part() + ")");
    case 5:
      return rng.Below(2) == 0 ? "clamp(" + part() + "," + part() + "," + part() + ")"
                               : "atan2(" + part() + "," + part() + ")";
    default:
      return part() + kBinary[rng.Below(kBinary.size())] + part();
  }
}

bool Same(double a, double b) {
  return (a == b && std::signbit(a) == std::signbit(b)) || (std::isnan(a) && std::isnan(b));
}

// Goal: to share changes no bit. Method: random formulas, of which the second and the third have a
// part of the first, against their evaluation one by one, at random and at awkward points.
TEST(SharedProgram, GivesTheBitsOfEachProgramAlone) {
  const std::uint64_t seed = test::FirstSeed();
  SCOPED_TRACE(test::Replay(seed, "core_tests", "SharedProgram.GivesTheBitsOfEachProgramAlone"));
  Rng rng(seed);
  int shared_count = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const std::string common = RandomFormula(rng, 3);
    const std::vector<Expression> expressions =
        ParseAll({common + "+" + RandomFormula(rng, 2), "(" + common + ")*" + RandomFormula(rng, 3),
                  "exp(-(" + common + "))"});
    ASSERT_EQ(expressions.size(), 3U);
    const std::optional<SharedProgram> shared = Share(expressions);
    ASSERT_TRUE(shared.has_value());
    if (!shared->shares()) continue;
    ++shared_count;
    for (int point = 0; point < 20; ++point) {
      const double awkward[] = {0.0, -0.0, 1e300, -1, std::numeric_limits<double>::infinity()};
      const Vec2 p = {point < 5 ? awkward[point] : rng.Uniform(-3, 3), rng.Uniform(-3, 3)};
      const double t = rng.Uniform(-1, 1);
      const auto results = shared->Evaluate(p, t);
      for (std::size_t i = 0; i < 3; ++i) {
        const double alone = expressions[i].Evaluate(p, t);
        ASSERT_TRUE(Same(results[i], alone))
            << expressions[i].text() << " at (" << p.x << ", " << p.y << "), t = " << t << ": "
            << results[i] << " instead of " << alone;
      }
    }
  }
  EXPECT_GT(shared_count, 250);  // The others are constants, or begin with one.
}

// Goal: nor does it to ask for many points at once. Method: random formulas at blocks of every
// length, among the points some where every operation has its special cases.
TEST(SharedProgram, GivesTheSameBitsForManyPointsAtOnce) {
  const std::uint64_t seed = test::FirstSeed();
  SCOPED_TRACE(
      test::Replay(seed, "core_tests", "SharedProgram.GivesTheSameBitsForManyPointsAtOnce"));
  Rng rng(seed);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  constexpr std::array kAwkward = {0.0, -0.0, 1e300, -1.0, kInfinity, 5e-324, 0.5, -64.0};
  for (int trial = 0; trial < 400; ++trial) {
    const std::vector<Expression> expressions =
        ParseAll({RandomFormula(rng, 4), RandomFormula(rng, 3), RandomFormula(rng, 2)});
    ASSERT_EQ(expressions.size(), 3U);
    const std::optional<SharedProgram> shared = Share(expressions);
    ASSERT_TRUE(shared.has_value());
    const auto coordinate = [&] {
      return rng.Below(3) == 0 ? kAwkward[rng.Below(kAwkward.size())] : rng.Uniform(-3, 3);
    };
    std::vector<Vec2> points(1 + static_cast<std::size_t>(trial) % SharedProgram::kBlockLength);
    for (Vec2& p : points) p = {coordinate(), coordinate()};
    const double t = rng.Uniform(-1, 1);
    const auto results = shared->EvaluateBlock(points, t);
    for (std::size_t i = 0; i < points.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        const double alone = expressions[k].Evaluate(points[i], t);
        ASSERT_TRUE(Same(results[k][i], alone))
            << expressions[k].text() << " at (" << points[i].x << ", " << points[i].y
            << "), t = " << t << ": " << results[k][i] << " instead of " << alone;
      }
    }
  }
}

TEST(SharedProgram, ComputesWhatIsTheSameOnce) {
  EXPECT_EQ(Share({"x*x + y*y", "x*x + y*y", "x*x + y*y"})->size(), 3U);
  EXPECT_EQ(Share({"exp(-(x*x + y*y))", "2*exp(-(x*x + y*y))", "x*x + y*y"})->size(), 6U);
  EXPECT_EQ(Share({"max(x, y, t)", "max(x, y)", "1"})->size(), 2U);
  // Neither the order nor the exponent may be taken for the same.
  EXPECT_EQ(Share({"x - y", "y - x", "(x - y)/2"})->size(), 3U);
  EXPECT_EQ(Share({"x^2", "x^3", "x^2 + 1"})->size(), 3U);
  EXPECT_EQ(Share({"y*y - 1", "t", "y*y"})->Evaluate({7, 8}, 9),
            (std::array<double, 3>{63, 9, 64}));
}

TEST(SharedProgram, LeavesAloneWhatItCannotShare) {
  EXPECT_FALSE(Share({"x - y", "y - x", "x/y"})->shares()) << "nothing in common";
  EXPECT_TRUE(Share({"x - y", "y - x", "(x - y)/2"})->shares());
  EXPECT_TRUE(Share({"(x < 0) * 1", "x < 0", "1"}).has_value());
  EXPECT_FALSE(Share({"x < 0 ? 1 : 2", "x < 0", "1"}).has_value());
  std::string sum = "x + x*2";
  for (int i = 0; i < 200; ++i) sum += "+x*" + std::to_string(i + 2);
  EXPECT_FALSE(Share({sum}).has_value()) << "as many constants as products and sums";
}

}  // namespace
}  // namespace pliant
