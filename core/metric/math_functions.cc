#include "core/metric/math_functions.h"

#include <sleef.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/math.h"

namespace pliant {
namespace {

constexpr double kIntegerExponentMax = 64;

// SLEEF declares its functions to return `const double`, which is another type of function.
template <auto function>
double Call(double x) {
  return function(x);
}
template <auto function>
double Call(double x, double y) {
  return function(x, y);
}

// A NaN among the arguments is the result: a size that is not a number must not be swallowed.
double Least(double a, double b) { return a != a || a < b ? a : b; }
double Greatest(double a, double b) { return a != a || a > b ? a : b; }

double Clamp(double x, double low, double high) { return Least(Greatest(x, low), high); }
double Sign(double x) { return x > 0 ? 1 : x < 0 ? -1 : x; }
double Step(double x) { return x != x ? x : x < 0 ? 0 : 1; }
double SmoothStep(double low, double high, double x) {
  const double s = Clamp((x - low) / (high - low), 0, 1);
  return s * s * (3 - 2 * s);
}
double Modulo(double x, double y) { return x - y * std::floor(x / y); }

// Sorted by name, for the binary search. Names are what a user types: README.md lists them.
constexpr std::array kFunctions = {
    MathFunction{.name = "abs", .unary = [](double x) { return std::abs(x); }},
    MathFunction{.name = "acos", .unary = Call<Sleef_cinz_acosd1_u10purec>},
    MathFunction{.name = "acosh", .unary = Call<Sleef_cinz_acoshd1_u10purec>},
    MathFunction{.name = "asin", .unary = Call<Sleef_cinz_asind1_u10purec>},
    MathFunction{.name = "asinh", .unary = Call<Sleef_cinz_asinhd1_u10purec>},
    MathFunction{.name = "atan", .unary = Call<Sleef_cinz_atand1_u10purec>},
    MathFunction{.name = "atan2", .binary = Call<Sleef_cinz_atan2d1_u10purec>},
    MathFunction{.name = "atanh", .unary = Call<Sleef_cinz_atanhd1_u10purec>},
    MathFunction{.name = "cbrt", .unary = Call<Sleef_cinz_cbrtd1_u10purec>},
    MathFunction{.name = "ceil", .unary = [](double x) { return std::ceil(x); }},
    MathFunction{.name = "clamp", .ternary = Clamp},
    MathFunction{.name = "cos", .unary = Call<Sleef_cinz_cosd1_u10purec>},
    MathFunction{.name = "cosh", .unary = Call<Sleef_cinz_coshd1_u10purec>},
    MathFunction{.name = "erf", .unary = Call<Sleef_cinz_erfd1_u10purec>},
    MathFunction{.name = "erfc", .unary = Call<Sleef_cinz_erfcd1_u15purec>},
    MathFunction{.name = "exp", .unary = [](double x) { return Exp(x); }},
    MathFunction{.name = "floor", .unary = [](double x) { return std::floor(x); }},
    MathFunction{.name = "hypot", .binary = Call<Sleef_cinz_hypotd1_u05purec>},
    MathFunction{.name = "ln", .unary = [](double x) { return Log(x); }},
    MathFunction{.name = "log", .unary = [](double x) { return Log(x); }},
    MathFunction{.name = "log10", .unary = Call<Sleef_cinz_log10d1_u10purec>},
    MathFunction{.name = "log2", .unary = Call<Sleef_cinz_log2d1_u10purec>},
    MathFunction{.name = "max", .fold = Greatest},
    MathFunction{.name = "min", .fold = Least},
    MathFunction{.name = "mod", .binary = Modulo},
    MathFunction{.name = "pow", .binary = Power},
    MathFunction{.name = "round", .unary = [](double x) { return std::round(x); }},
    MathFunction{.name = "sign", .unary = Sign},
    MathFunction{.name = "sin", .unary = Call<Sleef_cinz_sind1_u10purec>},
    MathFunction{.name = "sinh", .unary = Call<Sleef_cinz_sinhd1_u10purec>},
    MathFunction{.name = "smoothstep", .ternary = SmoothStep},
    MathFunction{.name = "sqrt", .unary = [](double x) { return std::sqrt(x); }},
    MathFunction{.name = "step", .unary = Step},
    MathFunction{.name = "tan", .unary = Call<Sleef_cinz_tand1_u10purec>},
    MathFunction{.name = "tanh", .unary = Call<Sleef_cinz_tanhd1_u10purec>},
};

}  // namespace

std::span<const MathFunction> MathFunctions() { return kFunctions; }

const MathFunction* FindMathFunction(std::string_view name) {
  const auto found = std::ranges::lower_bound(kFunctions, name, {}, &MathFunction::name);
  return found != kFunctions.end() && found->name == name ? &*found : nullptr;
}

double IntegerPower(double x, int exponent) {
  unsigned rest = exponent < 0 ? 0U - static_cast<unsigned>(exponent) : unsigned(exponent);
  double result = 1;
  for (double square = x; rest != 0; rest >>= 1) {
    if ((rest & 1) != 0) result *= square;
    if (rest > 1) square *= square;
  }
  return exponent < 0 ? 1 / result : result;
}

double Power(double x, double y) {
  if (std::abs(y) <= kIntegerExponentMax && y == std::floor(y)) {
    return IntegerPower(x, static_cast<int>(y));
  }
  if (y == 0.5) return std::sqrt(x);
  if (y == -0.5) return 1 / std::sqrt(x);
  return Sleef_cinz_powd1_u10purec(x, y);
}

}  // namespace pliant
