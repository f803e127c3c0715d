#include "core/geometry/triangle_point.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/predicates.h"

namespace pliant {

BoundaryPoint NearestOnSide(const std::array<Vec2, 3>& corners, std::size_t corner, Vec2 p) {
  const std::size_t i = (corner + 1) % 3;
  const std::size_t j = (corner + 2) % 3;
  const Vec2 side = corners[j] - corners[i];
  const double share = Dot(p - corners[i], side) / Dot(side, side);
  // Written so that a share that is not a number, of a side too short or too long to square,
  // becomes an end.
  const double t = share > 0 ? (share < 1 ? share : 1) : 0;
  const Vec2 foot = t == 1 ? corners[j] : corners[i] + t * side;
  BoundaryPoint nearest{.weights = {}, .squared_distance = Dot(p - foot, p - foot)};
  nearest.weights[i] = 1 - t;
  nearest.weights[j] = t;
  return nearest;
}

BoundaryPoint NearestOnBoundary(const std::array<Vec2, 3>& corners, Vec2 p) {
  BoundaryPoint nearest = NearestOnSide(corners, 0, p);
  for (std::size_t corner = 1; corner < 3; ++corner) {
    const BoundaryPoint candidate = NearestOnSide(corners, corner, p);
    if (candidate.squared_distance < nearest.squared_distance) nearest = candidate;
  }
  return nearest;
}

std::array<int, 3> SideSigns(const std::array<Vec2, 3>& corners, Vec2 p) {
  return {Orient2d(corners[1], corners[2], p), Orient2d(corners[2], corners[0], p),
          Orient2d(corners[0], corners[1], p)};
}

bool Contains(const std::array<Vec2, 3>& corners, Vec2 p) {
  const std::array<int, 3> signs = SideSigns(corners, p);
  return signs[0] >= 0 && signs[1] >= 0 && signs[2] >= 0;
}

std::array<double, 3> WeightsFromAreas(const std::array<Vec2, 3>& corners, Vec2 p,
                                       const std::array<double, 3>& areas) {
  // Below this share of the squared longest side, the areas are mostly rounding, and the nearest
  // boundary point, which is then within rounding of p, has the better weights.
  constexpr double kSliver = 0x1p-40;
  double squared_side = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec2 side = (corners[(i + 2) % 3] - p) - (corners[(i + 1) % 3] - p);
    squared_side = std::max(squared_side, Dot(side, side));
  }
  const double sum = areas[0] + areas[1] + areas[2];
  if (!(sum > kSliver * squared_side) || !std::isfinite(sum)) {
    return NearestOnBoundary(corners, p).weights;
  }
  return {areas[0] / sum, areas[1] / sum, areas[2] / sum};
}

std::array<double, 3> InteriorWeights(const std::array<Vec2, 3>& corners, Vec2 p,
                                      const std::array<int, 3>& signs) {
  if (std::ranges::count(signs, 0) == 1) {
    const auto on_side = static_cast<std::size_t>(std::ranges::find(signs, 0) - signs.begin());
    return NearestOnSide(corners, on_side, p).weights;
  }
  std::array<double, 3> areas;
  for (std::size_t i = 0; i < 3; ++i) {
    areas[i] =
        signs[i] > 0 ? std::max(0.0, Cross(corners[(i + 1) % 3] - p, corners[(i + 2) % 3] - p)) : 0;
  }
  return WeightsFromAreas(corners, p, areas);
}

}  // namespace pliant
