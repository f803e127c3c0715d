#pragma once

#include <cmath>

#include "core/base/same_bits.h"

namespace pliant {

/// A point or a displacement in the plane, in domain units.
struct Vec2 {
  double x = 0;
  double y = 0;

  friend constexpr bool operator==(const Vec2&, const Vec2&) = default;
  friend constexpr Vec2 operator+(Vec2 a, Vec2 b) { return {a.x + b.x, a.y + b.y}; }
  friend constexpr Vec2 operator-(Vec2 a, Vec2 b) { return {a.x - b.x, a.y - b.y}; }
  friend constexpr Vec2 operator-(Vec2 a) { return {-a.x, -a.y}; }
  friend constexpr Vec2 operator*(double s, Vec2 a) { return {s * a.x, s * a.y}; }
  friend constexpr Vec2 operator*(Vec2 a, double s) { return {a.x * s, a.y * s}; }
  constexpr Vec2& operator+=(Vec2 b) {
    x += b.x;
    y += b.y;
    return *this;
  }
};

[[nodiscard]] constexpr double Dot(Vec2 a, Vec2 b) { return a.x * b.x + a.y * b.y; }

/// The scalar cross product a.x b.y - a.y b.x: twice the signed area of the triangle 0, a, b.
/// Rounded: a decision on its sign belongs to geometry/predicates.h.
[[nodiscard]] constexpr double Cross(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }

[[nodiscard]] inline double Length(Vec2 a) { return std::sqrt(Dot(a, a)); }

[[nodiscard]] constexpr bool SameBits(Vec2 a, Vec2 b) {
  return SameBits(a.x, b.x) && SameBits(a.y, b.y);
}

[[nodiscard]] inline bool IsFinite(Vec2 a) { return std::isfinite(a.x) && std::isfinite(a.y); }

}  // namespace pliant
