#pragma once

#include <bit>
#include <cstdint>

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

}  // namespace internal

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
