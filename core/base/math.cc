#include "core/base/math.h"

#include <cmath>
#include <limits>

namespace pliant {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

double Exp(double x) {
  if (!(x < 709.782712893384)) return x == x ? kInfinity : x;
  if (x < -745.1332191019412) return 0;

  // Two factors, because 2^k alone may overflow or be subnormal; only the second product rounds.
  const auto [y, k] = internal::ReduceExp(x);
  const std::int64_t half = k / 2;
  return y * internal::PowerOfTwo(half) * internal::PowerOfTwo(k - half);
}

double Log(double x) {
  if (!(x > 0)) return x == 0 ? -kInfinity : std::numeric_limits<double>::quiet_NaN();
  if (x == kInfinity) return x;
  if (x < std::numeric_limits<double>::min()) return LogOfNormal(x * 0x1p54, -54);
  return LogOfNormal(x);
}

}  // namespace pliant
