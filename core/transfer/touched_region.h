#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/ids.h"
#include "core/geometry/vec2.h"
#include "core/transfer/old_mesh.h"

namespace pliant {

/// Some triangles of a mesh as a small mesh of its own, numbered from 0.
struct RegionMesh {
  std::vector<TriangleId> triangle_ids;  ///< Ascending.
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<VertexId> vertex_ids;  ///< In the order in which the triangles name them.
  std::vector<Vec2> points;
};

/// Corners of a triangle of a region.
[[nodiscard]] inline std::array<Vec2, 3> CornersOf(const RegionMesh& region,
                                                   std::int32_t triangle) {
  const auto& corners = region.triangles[static_cast<std::size_t>(triangle)];
  const auto point = [&](std::size_t i) {
    return region.points[static_cast<std::size_t>(corners[i])];
  };
  return {point(0), point(1), point(2)};
}

[[nodiscard]] inline double AreaOf(const std::array<Vec2, 3>& corners) {
  return 0.5 * Cross(corners[1] - corners[0], corners[2] - corners[0]);
}

/// The centroid.
[[nodiscard]] inline Vec2 CenterOf(const std::array<Vec2, 3>& corners) {
  return corners[0] + 1.0 / 3 * ((corners[1] - corners[0]) + (corners[2] - corners[0]));
}

/// What changed since the last commit: the triangles whose corners or whose corners' positions are
/// others now, as they were and as they are. Everything outside is the same in both meshes. While
/// the boundary stays, both cover the same points, up to the rounding of vertices on segments.
struct TouchedRegion {
  RegionMesh before;
  RegionMesh after;
  /// New vertices and those with another position, ascending: those that a diff lists.
  std::vector<VertexId> moved;
};

/// @par Cost O(k log k) for k touched elements.
[[nodiscard]] TouchedRegion GatherTouchedRegion(const OldMesh& old);

/// True if both have the same bits: -0.0 and 0.0 differ, because replicas copy bits.
[[nodiscard]] bool SamePosition(Vec2 a, Vec2 b);

}  // namespace pliant
