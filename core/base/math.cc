#include "core/base/math.h"

#include <cmath>
#include <limits>

namespace pliant {
namespace {

using internal::kLn2High;
using internal::kLn2Low;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::int64_t kExponentBias = 1023;

/// 2^k for k in [-1022, 1023].
double PowerOfTwo(std::int64_t k) {
  return std::bit_cast<double>(static_cast<std::uint64_t>(k + kExponentBias) << 52);
}

/// (e^r - 1 - r) / r^2 for |r| <= 0.35: the Taylor series; what is left out is below 2^-58 of e^r.
double ExpTail(double r) {
  const double r2 = r * r;
  const double r4 = r2 * r2;
  const double q0 = (1.0 / 2 + r * (1.0 / 6)) + r2 * (1.0 / 24 + r * (1.0 / 120));
  const double q1 = (1.0 / 720 + r * (1.0 / 5040)) + r2 * (1.0 / 40320 + r * (1.0 / 362880));
  const double q2 =
      (1.0 / 3628800 + r * (1.0 / 39916800)) + r2 * (1.0 / 479001600 + r * (1.0 / 6227020800));
  return q0 + r4 * (q1 + r4 * q2);
}

/// 2 atanh(s) / s - 2 for z = s^2 <= 0.0295: what is left out is below 2^-58 of the logarithm.
double AtanhTail(double z) {
  const double z2 = z * z;
  const double z4 = z2 * z2;
  const double p0 = (2.0 / 3 + z * (2.0 / 5)) + z2 * (2.0 / 7 + z * (2.0 / 9));
  const double p1 = (2.0 / 11 + z * (2.0 / 13)) + z2 * (2.0 / 15 + z * (2.0 / 17));
  const double p2 = 2.0 / 19 + z * (2.0 / 21);
  return z * (p0 + z4 * (p1 + z4 * p2));
}

}  // namespace

double Exp(double x) {
  if (!(x < 709.782712893384)) return x == x ? kInfinity : x;
  if (x < -745.1332191019412) return 0;

  // x = k ln 2 + r; r is rounded, and `rest` is what the rounding took away.
  const double shifted = x * internal::kLog2E + internal::kRoundShift;
  const double k = shifted - internal::kRoundShift;
  const double high = x - k * kLn2High;
  const double low = k * kLn2Low;
  const double r = high - low;
  const double rest = (high - r) - low;
  const double y = 1 + (r + (rest + r * r * ExpTail(r)));

  // Two factors, because 2^k alone may overflow or be subnormal; only the second product rounds.
  const auto exponent = static_cast<std::int64_t>(k);
  const std::int64_t half = exponent / 2;
  return y * PowerOfTwo(half) * PowerOfTwo(exponent - half);
}

double Log(double x) {
  if (!(x > 0)) return x == 0 ? -kInfinity : std::numeric_limits<double>::quiet_NaN();
  if (x == kInfinity) return x;
  double k = 0;
  if (x < std::numeric_limits<double>::min()) {
    x *= 0x1p54;
    k = -54;
  }

  // x = 2^k m with m in [sqrt(1/2), sqrt(2)), so that k = 0 around 1 and nothing cancels there.
  constexpr std::uint64_t kSqrtHalfBits = 0x3fe6a09e667f3bcd;
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
  const auto offset = static_cast<std::int64_t>(bits - kSqrtHalfBits);
  const std::int64_t exponent = offset >> 52;
  k += static_cast<double>(exponent);
  const double m = std::bit_cast<double>(bits - (static_cast<std::uint64_t>(exponent) << 52));

  // With f = m - 1 (exact) and s = f / (2 + f): ln m = 2 atanh(s) = f - (f^2/2 - s (f^2/2 + tail)),
  // in which the rounding of s only touches the small second term.
  const double f = m - 1;
  const double s = f / (2 + f);
  const double half_square = 0.5 * f * f;
  const double correction = s * (half_square + AtanhTail(s * s));
  return k * kLn2High + (f - (half_square - (correction + k * kLn2Low)));
}

}  // namespace pliant
