#include "core/metric/math_functions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <string>

#include "core/base/rng.h"

namespace pliant {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double Call(std::string_view name, double x) { return FindMathFunction(name)->unary(x); }

TEST(MathFunctions, AreSortedAndFound) {
  std::string_view previous;
  for (const MathFunction& function : MathFunctions()) {
    EXPECT_LT(previous, function.name);
    EXPECT_EQ(FindMathFunction(function.name), &function);
    EXPECT_EQ((function.unary != nullptr) + (function.binary != nullptr) +
                  (function.ternary != nullptr) + (function.fold != nullptr),
              1);
    previous = function.name;
  }
  EXPECT_EQ(FindMathFunction(""), nullptr);
  EXPECT_EQ(FindMathFunction("si"), nullptr);
  EXPECT_EQ(FindMathFunction("zeta"), nullptr);
}

// Goal: every name stands for the function it promises. Method: the C library's.
TEST(MathFunctions, AreWhatTheirNamesSay) {
  const std::map<std::string, double (*)(double)> unary = {
      {"abs", [](double x) { return std::fabs(x); }},
      {"acos", [](double x) { return std::acos(x); }},
      {"acosh", [](double x) { return std::acosh(x); }},
      {"asin", [](double x) { return std::asin(x); }},
      {"asinh", [](double x) { return std::asinh(x); }},
      {"atan", [](double x) { return std::atan(x); }},
      {"atanh", [](double x) { return std::atanh(x); }},
      {"cbrt", [](double x) { return std::cbrt(x); }},
      {"ceil", [](double x) { return std::ceil(x); }},
      {"cos", [](double x) { return std::cos(x); }},
      {"cosh", [](double x) { return std::cosh(x); }},
      {"erf", [](double x) { return std::erf(x); }},
      {"erfc", [](double x) { return std::erfc(x); }},
      {"exp", [](double x) { return std::exp(x); }},
      {"floor", [](double x) { return std::floor(x); }},
      {"ln", [](double x) { return std::log(x); }},
      {"log", [](double x) { return std::log(x); }},
      {"log10", [](double x) { return std::log10(x); }},
      {"log2", [](double x) { return std::log2(x); }},
      {"round", [](double x) { return std::round(x); }},
      {"sin", [](double x) { return std::sin(x); }},
      {"sinh", [](double x) { return std::sinh(x); }},
      {"sqrt", [](double x) { return std::sqrt(x); }},
      {"tan", [](double x) { return std::tan(x); }},
      {"tanh", [](double x) { return std::tanh(x); }},
  };
  Rng rng(1996);
  int compared = 0;
  for (const MathFunction& function : MathFunctions()) {
    const auto reference = unary.find(std::string(function.name));
    if (reference == unary.end()) continue;
    ++compared;
    for (int i = 0; i < 2000; ++i) {
      const double x = rng.Uniform(-1, 1) * (i % 4 == 0 ? 1 : 30);
      const double expected = reference->second(x);
      const double value = function.unary(x);
      if (std::isnan(expected)) {
        ASSERT_TRUE(std::isnan(value)) << function.name << "(" << x << ")";
      } else {
        ASSERT_LE(std::abs(value - expected), 1e-15 * std::abs(expected) + 1e-320)
            << function.name << "(" << x << ")";
      }
    }
  }
  EXPECT_EQ(compared, 25);
}

TEST(MathFunctions, OfSeveralArguments) {
  const auto binary = [](std::string_view name, double a, double b) {
    return FindMathFunction(name)->binary(a, b);
  };
  EXPECT_DOUBLE_EQ(binary("atan2", 1, -2), std::atan2(1, -2));
  EXPECT_DOUBLE_EQ(binary("hypot", 3e200, 4e200), 5e200);
  EXPECT_EQ(binary("mod", 7, 3), 1);
  EXPECT_EQ(binary("mod", -1, 3), 2);
  EXPECT_EQ(binary("pow", 2, 10), 1024);
  const auto ternary = [](std::string_view name, double a, double b, double c) {
    return FindMathFunction(name)->ternary(a, b, c);
  };
  EXPECT_EQ(ternary("clamp", 5, 0, 2), 2);
  EXPECT_EQ(ternary("clamp", -5, 0, 2), 0);
  EXPECT_EQ(ternary("clamp", 1, 0, 2), 1);
  EXPECT_EQ(ternary("smoothstep", 1, 3, 0), 0);
  EXPECT_EQ(ternary("smoothstep", 1, 3, 2), 0.5);
  EXPECT_EQ(ternary("smoothstep", 1, 3, 4), 1);
  EXPECT_EQ(Call("sign", -3), -1);
  EXPECT_EQ(Call("sign", 0), 0);
  EXPECT_EQ(Call("step", -1e-300), 0);
  EXPECT_EQ(Call("step", 0), 1);
}

TEST(MathFunctions, DoNotSwallowNaN) {
  for (const char* name : {"min", "max"}) {
    const auto fold = FindMathFunction(name)->fold;
    EXPECT_TRUE(std::isnan(fold(kNaN, 1))) << name;
    EXPECT_TRUE(std::isnan(fold(1, kNaN))) << name;
  }
  EXPECT_TRUE(std::isnan(FindMathFunction("clamp")->ternary(kNaN, 0, 1)));
  EXPECT_TRUE(std::isnan(Call("sign", kNaN)));
  EXPECT_TRUE(std::isnan(Call("step", kNaN)));
}

TEST(IntegerPower, IsRepeatedMultiplication) {
  const double x = 1.1;
  EXPECT_EQ(IntegerPower(x, 0), 1);
  EXPECT_EQ(IntegerPower(x, 1), x);
  EXPECT_EQ(IntegerPower(x, 2), x * x);
  EXPECT_EQ(IntegerPower(x, 3), x * (x * x));
  EXPECT_EQ(IntegerPower(x, 4), (x * x) * (x * x));
  EXPECT_EQ(IntegerPower(x, -2), 1 / (x * x));
  EXPECT_EQ(IntegerPower(-2, 63), -0x1p63);
  EXPECT_EQ(IntegerPower(2, -64), 0x1p-64);
}

TEST(Power, ChoosesTheExactMethodWhereThereIsOne) {
  EXPECT_EQ(Power(1.1, 2), 1.1 * 1.1);
  EXPECT_EQ(Power(-1.1, 3), IntegerPower(-1.1, 3));
  EXPECT_EQ(Power(3, 0.5), std::sqrt(3.0));
  EXPECT_EQ(Power(3, -0.5), 1 / std::sqrt(3.0));
  EXPECT_NEAR(Power(3, 1.7), std::pow(3, 1.7), 1e-14);
  EXPECT_NEAR(Power(1.01, 65), std::pow(1.01, 65), 1e-14);
  EXPECT_TRUE(std::isnan(Power(-2, 0.3)));
  EXPECT_TRUE(std::isnan(Power(2, kNaN)));
}

// Goal: a different SLEEF, compiler or CPU that changes one bit shows at once.
// Method: a hash over 20,000 results of every function; recorded with g++ 12 and SLEEF 3.5.1.
TEST(MathFunctions, HaveTheSameBitsEverywhere) {
  std::uint64_t hash = 0;
  for (const MathFunction& function : MathFunctions()) {
    Rng rng(1996);
    for (int i = 0; i < 20000; ++i) {
      const double a = rng.Uniform(-10, 10);
      const double b = rng.Uniform(-10, 10);
      double value = 0;
      if (function.unary != nullptr) value = function.unary(a);
      if (function.binary != nullptr) value = function.binary(a, b);
      if (function.ternary != nullptr) value = function.ternary(a, b, rng.Uniform(-10, 10));
      if (function.fold != nullptr) value = function.fold(a, b);
      if (std::isnan(value)) value = 0;  // The bits of a NaN are not part of the promise.
      hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 0x100000001b3U;
    }
  }
  EXPECT_EQ(hash, 556213830742076140U);
}

}  // namespace
}  // namespace pliant
