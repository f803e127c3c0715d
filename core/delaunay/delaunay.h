#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/stop_signal.h"
#include "core/delaunay/triangulate.h"
#include "core/geometry/vec2.h"

namespace pliant {

/// A triangulation of the convex hull of points, closed by ghosts.
///
/// *Invariants*: one ghost triangle outside each edge of the hull, with the corner kGhost instead
/// of a point, so that every triangle has three neighbours. Corners run counter-clockwise, if a
/// ghost is taken to lie far out. `segments` agree on both sides of an edge.
struct HullTriangulation {
  using Triangle = DomainTriangulation::Triangle;
  static constexpr std::int32_t kGhost = -1;

  std::vector<Triangle> triangles;
  /// Some triangle, not a ghost, at each point.
  std::vector<std::int32_t> triangle_of_point;

  /// The corner of `triangle` at `point`, or opposite `neighbor`; 3 if there is none.
  static std::size_t CornerAt(const Triangle& triangle, std::int32_t point);
  static std::size_t CornerOpposite(const Triangle& triangle, std::int32_t neighbor);
  static bool IsGhost(const Triangle& triangle) { return CornerAt(triangle, kGhost) < 3; }
};

/// The corners (or sides) that follow corner (or side) i.
[[nodiscard]] constexpr std::size_t NextCorner(std::size_t i) { return i == 2 ? 0 : i + 1; }
[[nodiscard]] constexpr std::size_t LastCorner(std::size_t i) { return i == 0 ? 2 : i - 1; }

/// The Delaunay triangulation of points, by insertion in InsertionOrder. [Bowyer1981], [Watson1981]
///
/// Exact: every point is a vertex, collinear and co-circular points included.
///
/// @param points  finite and pairwise distinct.
/// @param stop  not owned; null: nobody; else asked: what it returns then is of no use.
/// @return no triangles if the points all lie on one line (or are fewer than three).
/// @par Cost  O(n log n) expected, about 1 us per point.
[[nodiscard]] HullTriangulation DelaunayTriangulation(std::span<const Vec2> points,
                                                      const StopSignal* stop = nullptr);

}  // namespace pliant
