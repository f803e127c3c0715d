#pragma once

#include <algorithm>
#include <span>

#include "core/geometry/vec2.h"

namespace pliant {

/// Axis-parallel box of points.
struct BoundingBox {
  Vec2 low;
  Vec2 high;

  friend bool operator==(const BoundingBox&, const BoundingBox&) = default;
};

/// Makes the box the smallest that holds `other` too.
inline void Extend(BoundingBox& box, const BoundingBox& other) {
  box.low = {std::min(box.low.x, other.low.x), std::min(box.low.y, other.low.y)};
  box.high = {std::max(box.high.x, other.high.x), std::max(box.high.y, other.high.y)};
}

/// The smallest box that holds all points. @pre !points.empty()
[[nodiscard]] inline BoundingBox BoxOf(std::span<const Vec2> points) {
  BoundingBox box{points.front(), points.front()};
  for (const Vec2 p : points) Extend(box, {p, p});
  return box;
}

/// Squared distance from the nearest point of the box; 0 within it.
[[nodiscard]] inline double SquaredDistance(const BoundingBox& box, Vec2 p) {
  const double x = p.x < box.low.x ? box.low.x - p.x : p.x > box.high.x ? p.x - box.high.x : 0;
  const double y = p.y < box.low.y ? box.low.y - p.y : p.y > box.high.y ? p.y - box.high.y : 0;
  return x * x + y * y;
}

/// True if they have a point in common, borders included.
[[nodiscard]] inline bool Meet(const BoundingBox& a, const BoundingBox& b) {
  return a.low.x <= b.high.x && b.low.x <= a.high.x && a.low.y <= b.high.y && b.low.y <= a.high.y;
}

}  // namespace pliant
