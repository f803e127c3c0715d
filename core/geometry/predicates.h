#pragma once

#include <cmath>

#include "core/geometry/vec2.h"

namespace pliant {

namespace internal {

// (3 + 16e)e times the sum of magnitudes bounds the rounding of Orient2d [Shewchuk1997]; the
// smallest normal number is far above what underflow can add. Overflow makes comparisons false.
inline constexpr double kOrientRelative = (3 + 16 * 0x1p-53) * 0x1p-53;
inline constexpr double kOrientAbsolute = 0x1p-1022;

/// Positive exactly where FilterOrient2d is +1; without a branch, for loops over many triangles.
[[nodiscard]] inline double MarginOfOrient2d(Vec2 a, Vec2 b, Vec2 c) {
  const double left = (a.x - c.x) * (b.y - c.y);
  const double right = (a.y - c.y) * (b.x - c.x);
  return (left - right) -
         (kOrientRelative * (std::fabs(left) + std::fabs(right)) + kOrientAbsolute);
}

/// -1 or +1 where floating point is sure of the sign of Orient2d, 0 where it is not.
[[nodiscard]] inline int FilterOrient2d(Vec2 a, Vec2 b, Vec2 c) {
  const double left = (a.x - c.x) * (b.y - c.y);
  const double right = (a.y - c.y) * (b.x - c.x);
  const double determinant = left - right;
  const double bound = kOrientRelative * (std::fabs(left) + std::fabs(right)) + kOrientAbsolute;
  if (determinant > bound) return 1;
  if (determinant < -bound) return -1;
  return 0;
}

/// -1 or +1 where floating point is sure of the sign of InCircle, 0 where it is not.
[[nodiscard]] inline int FilterInCircle(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
  // (10 + 96e)e times the permanent bounds the rounding [Shewchuk1997]. An underflowing product is
  // off by at most 2^-1075 and is multiplied by at most the sum of lifts; kLiftMax keeps that below
  // kAbsolute. Overflow makes the comparisons false.
  constexpr double kRelative = (10 + 96 * 0x1p-53) * 0x1p-53;
  constexpr double kAbsolute = 0x1p-860;
  constexpr double kLiftMax = 0x1p202;
  const Vec2 p = a - d;
  const Vec2 q = b - d;
  const Vec2 r = c - d;
  const double qr = q.x * r.y;
  const double rq = r.x * q.y;
  const double rp = r.x * p.y;
  const double pr = p.x * r.y;
  const double pq = p.x * q.y;
  const double qp = q.x * p.y;
  const double lift_p = p.x * p.x + p.y * p.y;
  const double lift_q = q.x * q.x + q.y * q.y;
  const double lift_r = r.x * r.x + r.y * r.y;
  const double determinant = lift_p * (qr - rq) + lift_q * (rp - pr) + lift_r * (pq - qp);
  const double permanent = lift_p * (std::fabs(qr) + std::fabs(rq)) +
                           lift_q * (std::fabs(rp) + std::fabs(pr)) +
                           lift_r * (std::fabs(pq) + std::fabs(qp));
  const double bound = kRelative * permanent + kAbsolute;
  if (!(lift_p + lift_q + lift_r < kLiftMax)) return 0;
  if (determinant > bound) return 1;
  if (determinant < -bound) return -1;
  return 0;
}

[[nodiscard]] int ExactOrient2d(Vec2 a, Vec2 b, Vec2 c);
[[nodiscard]] int ExactInCircle(Vec2 a, Vec2 b, Vec2 c, Vec2 d);

}  // namespace internal

/// The side of the line from a to b on which c lies: +1 left (a, b, c run counter-clockwise),
/// -1 right, 0 exactly on the line.
///
/// A sign and not a number, so that nobody can compare it with a tolerance.
///
/// @pre  finite coordinates; any magnitude, subnormal numbers included. Rounding to nearest and
///       no flush-to-zero, as a program has them from the start.
/// @par Cost  about 2 ns where rounding cannot matter, 0.1 us where it does, several us only if
///       coordinates leave [1e-64, 1e73] in magnitude (0 is fine).
/// @see [Shewchuk1997]
[[nodiscard]] inline int Orient2d(Vec2 a, Vec2 b, Vec2 c) {
  const int sign = internal::FilterOrient2d(a, b, c);
  if (sign != 0) [[likely]] {
    return sign;
  }
  return internal::ExactOrient2d(a, b, c);
}

/// Where d lies with respect to the circle through a, b, c, which run counter-clockwise: +1 inside,
/// -1 outside, 0 exactly on it. For clockwise a, b, c the sign is the opposite; for collinear ones
/// it is that of the limit, which no caller should use.
///
/// @pre  as Orient2d.
/// @par Cost  about 5 ns where rounding cannot matter, 0.5 us where it does; else as Orient2d.
/// @see [Shewchuk1997]
[[nodiscard]] inline int InCircle(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
  const int sign = internal::FilterInCircle(a, b, c, d);
  if (sign != 0) [[likely]] {
    return sign;
  }
  return internal::ExactInCircle(a, b, c, d);
}

}  // namespace pliant
