#pragma once

#include <bit>
#include <cstdint>

#include "core/base/vector_kernel.h"

namespace pliant {

/// e^x and ln x from + - * / and bit operations only: the same bits on every CPU, compiler and
/// C library, which a libm's functions do not promise (glibc chooses FMA variants when it starts).
///
/// Needs round-to-nearest and no contraction of a*b+c (-ffp-contract=off).

/// e^x.
///
/// Relative error below 1 ulp where the result is a normal number, below 1 ulp of the smallest
/// subnormal below that. +infinity from 709.782712893384 on, 0 below -745.1332191019412, NaN for
/// NaN; Exp(0) = 1.
[[nodiscard]] double Exp(double x);

/// ln x, the natural logarithm.
///
/// Error below 1 ulp for every positive x, subnormal ones too. -infinity for +-0, NaN for negative
/// numbers and NaN, +infinity for itself; Log(1) = 0.
[[nodiscard]] double Log(double x);

namespace internal {

// ln 2 in two parts; the high one has 21 trailing zeros, so that its product with any exponent of
// a double is exact.
inline constexpr double kLn2High = 0x1.62e42feep-1;
inline constexpr double kLn2Low = 0x1.a39ef35793c76p-33;
inline constexpr double kLog2E = 0x1.71547652b82fep+0;
// Adding this number to |y| < 2^51 rounds y to an integer that then stands in the low bits.
inline constexpr double kRoundShift = 0x1.8p52;

/// (e^r - 1 - r) / r^2 for |r| <= 0.35: the Taylor series; what is left out is below 2^-58 of e^r.
[[nodiscard]] PLIANT_PART_OF_KERNEL inline double ExpTail(double r) {
  const double r2 = r * r;
  const double r4 = r2 * r2;
  const double q0 = (1.0 / 2 + r * (1.0 / 6)) + r2 * (1.0 / 24 + r * (1.0 / 120));
  const double q1 = (1.0 / 720 + r * (1.0 / 5040)) + r2 * (1.0 / 40320 + r * (1.0 / 362880));
  const double q2 =
      (1.0 / 3628800 + r * (1.0 / 39916800)) + r2 * (1.0 / 479001600 + r * (1.0 / 6227020800));
  return q0 + r4 * (q1 + r4 * q2);
}

/// e^x = 2^k y, with y around 1.
struct ReducedExp {
  double y;
  std::int64_t k;
};

/// @pre |x| < 2^50
[[nodiscard]] PLIANT_PART_OF_KERNEL inline ReducedExp ReduceExp(double x) {
  // x = k ln 2 + r; r is rounded, and `rest` is what the rounding took away.
  const double shifted = x * kLog2E + kRoundShift;
  const double k = shifted - kRoundShift;
  const double high = x - k * kLn2High;
  const double low = k * kLn2Low;
  const double r = high - low;
  const double rest = (high - r) - low;
  const double y = 1 + (r + (rest + r * r * ExpTail(r)));
  return {y, static_cast<std::int64_t>(std::bit_cast<std::uint64_t>(shifted) -
                                       std::bit_cast<std::uint64_t>(kRoundShift))};
}

/// 2^k for k in [-1022, 1023].
[[nodiscard]] PLIANT_PART_OF_KERNEL inline double PowerOfTwo(std::int64_t k) {
  constexpr std::int64_t kExponentBias = 1023;
  return std::bit_cast<double>(static_cast<std::uint64_t>(k + kExponentBias) << 52);
}

/// 2 atanh(s) / s - 2 for z = s^2 <= 0.0295: what is left out is below 2^-58 of the logarithm.
[[nodiscard]] PLIANT_PART_OF_KERNEL inline double AtanhTail(double z) {
  const double z2 = z * z;
  const double z4 = z2 * z2;
  const double p0 = (2.0 / 3 + z * (2.0 / 5)) + z2 * (2.0 / 7 + z * (2.0 / 9));
  const double p1 = (2.0 / 11 + z * (2.0 / 13)) + z2 * (2.0 / 15 + z * (2.0 / 17));
  const double p2 = 2.0 / 19 + z * (2.0 / 21);
  return z * (p0 + z4 * (p1 + z4 * p2));
}

}  // namespace internal

/// e^x where neither it nor its inverse overflows by far: what Exp has, without a branch, so that a
/// loop over it becomes vector code. @pre |x| <= 700; elsewhere the result is meaningless
[[nodiscard]] PLIANT_PART_OF_KERNEL inline double ExpOfModerate(double x) {
  const internal::ReducedExp reduced = internal::ReduceExp(x);
  return reduced.y * internal::PowerOfTwo(reduced.k);
}

/// ln(2^k x) for a normal number x > 0 and a small integer k: what Log has, without a branch, so
/// that a loop over it becomes vector code. @pre x is normal; elsewhere the result is meaningless
[[nodiscard]] PLIANT_PART_OF_KERNEL inline double LogOfNormal(double x, double k = 0) {
  // x = 2^e m with m in [sqrt(1/2), sqrt(2)), so that e = 0 around 1 and nothing cancels there.
  // The exponent is biased, to be shifted without a sign, and becomes a double by way of its bits.
  constexpr std::uint64_t kSqrtHalfBits = 0x3fe6a09e667f3bcd;
  constexpr std::uint64_t kBias = 1024;
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(x);
  const std::uint64_t biased = (bits - kSqrtHalfBits + (kBias << 52)) >> 52;
  const double e = std::bit_cast<double>(biased | std::bit_cast<std::uint64_t>(0x1p52)) -
                   (0x1p52 + static_cast<double>(kBias));
  k += e;
  const double m = std::bit_cast<double>(bits - ((biased - kBias) << 52));

  // With f = m - 1 (exact) and s = f / (2 + f): ln m = 2 atanh(s) = f - (f^2/2 - s (f^2/2 + tail)),
  // in which the rounding of s only touches the small second term.
  const double f = m - 1;
  const double s = f / (2 + f);
  const double half_square = 0.5 * f * f;
  const double correction = s * (half_square + internal::AtanhTail(s * s));
  return k * internal::kLn2High + (f - (half_square - (correction + k * internal::kLn2Low)));
}

/// e^x for x in [-256, 0], made for hot loops such as the weights exp(-d^4) of smoothing: without
/// a branch, so that a loop over it becomes vector code.
///
/// Relative error below 1e-13 (8e-14 measured), ExpNegative(0) = 1 exactly. Not monotone in the
/// last bits. @pre -256 <= x <= 0; elsewhere the result is meaningless.
[[nodiscard]] inline double ExpNegative(double x) {
  // x = k ln 2 + r with |r| <= ln 2 / 2; then 2^k is added to the exponent bits of e^r.
  const double shifted = x * internal::kLog2E + internal::kRoundShift;
  const double k = shifted - internal::kRoundShift;
  const double r = (x - k * internal::kLn2High) - k * internal::kLn2Low;
  // e^r = 1 + r + r^2 q(r), q interpolated at Chebyshev nodes: a polynomial of degree 9 in all.
  // Evaluated in pairs, which shortens the chain of dependent operations.
  const double r2 = r * r;
  const double q01 = 0x1.fffffffffe062p-2 + 0x1.5555555554f96p-3 * r;
  const double q23 = 0x1.55555565c7e0ep-5 + 0x1.111111170bc08p-7 * r;
  const double q45 = 0x1.6c166bde96885p-10 + 0x1.a019c36bc053cp-13 * r;
  const double q67 = 0x1.a136bf03ec612p-16 + 0x1.72ad458027fbcp-19 * r;
  const double r4 = r2 * r2;
  const double q = (q01 + r2 * q23) + r4 * (q45 + r2 * q67);
  const double y = 1 + (r + r2 * q);
  const std::uint64_t exponent = std::bit_cast<std::uint64_t>(shifted) << 52;
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(y) + exponent);
}

}  // namespace pliant
