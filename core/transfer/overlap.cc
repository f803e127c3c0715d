#include "core/transfer/overlap.h"

#include <algorithm>

#include "core/geometry/predicates.h"

namespace pliant {
namespace {

/// Where less of a new triangle is covered, the old domain may end in it, and the search goes on
/// from its corners. Only a matter of time: a search from another place finds nothing twice.
constexpr double kCoveredShare = 1 - 0x1p-20;

/// How far from a corner towards the centre that search begins: well inside the triangle.
constexpr double kInwards = 0x1p-8;

/// Sides of the corners of `points` with respect to each side of `triangle`: 1 is within.
using Signs = std::array<std::array<int, 3>, 3>;

Signs SignsOf(const std::array<Vec2, 3>& triangle, const std::array<Vec2, 3>& points) {
  Signs signs{};
  for (std::size_t side = 0; side < 3; ++side) {
    for (std::size_t k = 0; k < 3; ++k) {
      signs[side][k] = Orient2d(triangle[(side + 1) % 3], triangle[(side + 2) % 3], points[k]);
    }
  }
  return signs;
}

/// True if one of the sides has all the points on it or beyond: the interiors are apart.
bool Separates(const Signs& signs) {
  return std::ranges::any_of(signs, [](const std::array<int, 3>& side) {
    return std::ranges::all_of(side, [](int sign) { return sign <= 0; });
  });
}

/// What of the polygon lies left of the line from a to b. [SutherlandHodgman1974]
ConvexPolygon Clip(const ConvexPolygon& polygon, Vec2 a, Vec2 b) {
  ConvexPolygon result;
  const auto add = [&](Vec2 p) {
    if (result.count < result.corners.size()) result.corners[result.count++] = p;
  };
  for (std::size_t i = 0; i < polygon.count; ++i) {
    const Vec2 p = polygon.corners[i];
    const Vec2 q = polygon.corners[i + 1 == polygon.count ? 0 : i + 1];
    const double at_p = Cross(b - a, p - a);
    const double at_q = Cross(b - a, q - a);
    if (at_p >= 0) add(p);
    if ((at_p > 0 && at_q < 0) || (at_p < 0 && at_q > 0)) {
      add(p + at_p / (at_p - at_q) * (q - p));
    }
  }
  return result;
}

}  // namespace

double ConvexPolygon::Area() const {
  double twice = 0;
  for (std::size_t i = 2; i < count; ++i) {
    twice += Cross(corners[i - 1] - corners[0], corners[i] - corners[0]);
  }
  return 0.5 * twice;
}

void OverlapFinder::Find(std::int32_t after) {
  overlaps_.clear();
  ++find_count_;
  const std::array<Vec2, 3> corners = CornersOf(region_.after, after);
  const auto& vertices = region_.after.triangles[static_cast<std::size_t>(after)];
  const Vec2 center = CenterOf(corners);
  nearest_ = locator_.Locate(center, vertices[0]).triangle;
  Flood(nearest_, corners);

  double covered = 0;
  for (const Overlap& overlap : overlaps_) covered += overlap.polygon.Area();
  if (covered >= kCoveredShare * AreaOf(corners)) return;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec2 near_corner = corners[i] + kInwards * (center - corners[i]);
    Flood(locator_.Locate(near_corner, vertices[i]).triangle, corners);
  }
}

/// Goes from triangle to triangle over sides that have a corner of the new one beyond them. What
/// a convex set has in common with a region without holes in it is reached so, from a triangle
/// that holds one of its interior points.
void OverlapFinder::Flood(std::int32_t seed, const std::array<Vec2, 3>& corners) {
  const Vec2 origin = corners[0];
  stack_.assign(1, seed);
  while (!stack_.empty()) {
    const std::int32_t before = stack_.back();
    stack_.pop_back();
    std::int64_t& seen = seen_[static_cast<std::size_t>(before)];
    if (seen == find_count_) continue;
    seen = find_count_;
    const std::array<Vec2, 3> old = CornersOf(region_.before, before);
    const Signs signs = SignsOf(old, corners);
    if (Separates(signs) || Separates(SignsOf(corners, old))) continue;

    Overlap overlap{.before = before, .polygon = {}};
    for (const Vec2 corner : corners) {
      overlap.polygon.corners[overlap.polygon.count++] = corner - origin;
    }
    for (std::size_t side = 0; side < 3; ++side) {
      if (std::ranges::none_of(signs[side], [](int sign) { return sign < 0; })) continue;
      overlap.polygon =
          Clip(overlap.polygon, old[(side + 1) % 3] - origin, old[(side + 2) % 3] - origin);
      const std::int32_t beyond = locator_.neighbors(before)[side];
      if (beyond >= 0) stack_.push_back(beyond);
    }
    overlaps_.push_back(overlap);
  }
}

}  // namespace pliant
