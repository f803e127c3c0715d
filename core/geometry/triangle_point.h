#pragma once

#include <array>
#include <cstddef>

#include "core/geometry/vec2.h"

namespace pliant {

// How a point lies to a triangle given by its corners, counter-clockwise: what every search in a
// triangulation ends with.

/// A point on the boundary of a triangle, seen from another point.
struct BoundaryPoint {
  std::array<double, 3> weights;  ///< Barycentric; exactly 0 for corners off its side.
  double squared_distance;
};

/// The point of the side opposite `corner` that is nearest to p.
[[nodiscard]] BoundaryPoint NearestOnSide(const std::array<Vec2, 3>& corners, std::size_t corner,
                                          Vec2 p);

/// The point of the triangle's boundary that is nearest to p; of equally near ones, the first.
[[nodiscard]] BoundaryPoint NearestOnBoundary(const std::array<Vec2, 3>& corners, Vec2 p);

/// Sides of p: sign i is +1 if p lies strictly within the side opposite corner i, 0 on its line.
[[nodiscard]] std::array<int, 3> SideSigns(const std::array<Vec2, 3>& corners, Vec2 p);

/// True if p lies in the triangle, its boundary included.
[[nodiscard]] bool Contains(const std::array<Vec2, 3>& corners, Vec2 p);

/// Barycentric weights of a point of the triangle from the doubled areas that it spans with the
/// sides, none negative.
[[nodiscard]] std::array<double, 3> WeightsFromAreas(const std::array<Vec2, 3>& corners, Vec2 p,
                                                     const std::array<double, 3>& areas);

/// Barycentric weights of a point of the triangle. A weight is exactly 0 where p lies on the
/// opposite side. @param signs  SideSigns(corners, p), none negative.
[[nodiscard]] std::array<double, 3> InteriorWeights(const std::array<Vec2, 3>& corners, Vec2 p,
                                                    const std::array<int, 3>& signs);

}  // namespace pliant
