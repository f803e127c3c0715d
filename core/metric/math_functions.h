#pragma once

#include <span>
#include <string_view>

namespace pliant {

/// A function that expressions may call. Exactly one of the pointers is set.
///
/// Every one gives the same bits on every CPU: they come from core/base/math.h, from SLEEF's
/// `cinz` family (written without FMA and without run-time dispatch), or are exact operations.
struct MathFunction {
  std::string_view name;
  double (*unary)(double) = nullptr;
  double (*binary)(double, double) = nullptr;
  double (*ternary)(double, double, double) = nullptr;
  /// Folds any number of arguments, at least one, from left to right.
  double (*fold)(double, double) = nullptr;
};

/// All of them, sorted by name.
[[nodiscard]] std::span<const MathFunction> MathFunctions();

/// Null if there is none of that name.
[[nodiscard]] const MathFunction* FindMathFunction(std::string_view name);

/// x to the power of a whole number by repeated squaring: x^2 is x * x to the bit; a negative
/// exponent takes the reciprocal of the positive power.
[[nodiscard]] double IntegerPower(double x, int exponent);

/// x^y: by IntegerPower if y is a whole number of at most 64 in size, by a square root if y is
/// +-1/2, by SLEEF's pow (1 ulp) otherwise; NaN for a negative x and a y that is not whole.
[[nodiscard]] double Power(double x, double y);

}  // namespace pliant
