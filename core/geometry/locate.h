#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/base/large_pages.h"
#include "core/base/lazy.h"
#include "core/base/prefetch.h"
#include "core/base/stop_signal.h"
#include "core/geometry/bounding_box.h"
#include "core/geometry/box_tree.h"
#include "core/geometry/vec2.h"

namespace pliant {

/// Where a point lies in a triangulation.
struct Location {
  std::int32_t triangle = -1;  ///< The triangle that holds the point, or the nearest point of it.
  /// Barycentric weights of that point in `triangle`: each in [0, 1], sum 1 up to rounding.
  std::array<double, 3> weights = {};
  bool inside = false;  ///< True if the point lies in the triangulation, its boundary included.
};

/// What a walk reads of a triangle, in one place.
struct TriangleLinks {
  std::array<std::int32_t, 3> corners;    ///< Counter-clockwise.
  std::array<std::int32_t, 3> neighbors;  ///< Across the sides opposite them; -1: there is none.
};

/// A triangulation of which each triangle knows its neighbours.
struct LinkedTriangles {
  LargeVector<Vec2> points;
  LargeVector<TriangleLinks> triangles;
};

/// Finds points in a fixed triangulation, which need be neither convex nor connected nor Delaunay.
///
/// *Invariants*: the answer depends on the point and the triangulation only, never on the hint or
/// on earlier questions. A point on an edge or a vertex belongs to the lowest triangle there, and
/// the weights of the corners off that edge or vertex are exactly 0. A point outside gets the
/// nearest point of the triangulation, and among equally near triangles the lowest.
/// *Threads*: as many as you like.
class TriangleLocator {
 public:
  /// Copies the arrays, and derives the rest in O(n log n).
  ///
  /// @param triangles  corners as indices into `points`, counter-clockwise, at least one triangle.
  /// @pre A valid triangulation: no overlaps, no two triangles on the same side of an edge, no
  ///      vertex inside an edge. Where it is not valid, the answer is one of those possible.
  ///      Indices out of range are a bug of the caller.
  /// @param stop  if given and it asks to, the rest is left out: then only to be thrown away.
  TriangleLocator(const std::vector<Vec2>& points,
                  const std::vector<std::array<std::int32_t, 3>>& triangles,
                  const StopSignal* stop = nullptr);
  /// The same where the neighbours are known; takes the arrays. @par Cost reads the points once
  explicit TriangleLocator(LinkedTriangles linked);
  /// The same, copied. @par Cost O(n)
  TriangleLocator(std::span<const Vec2> points,
                  std::span<const std::array<std::int32_t, 3>> triangles,
                  std::span<const std::array<std::int32_t, 3>> neighbors);

  [[nodiscard]] std::span<const Vec2> points() const { return points_; }
  /// Of all points.
  [[nodiscard]] const BoundingBox& box() const { return box_; }
  [[nodiscard]] std::int32_t triangle_count() const {
    return static_cast<std::int32_t>(links_.size());
  }
  /// Indices of the corners of triangle t into points(), counter-clockwise.
  [[nodiscard]] const std::array<std::int32_t, 3>& corners(std::int32_t t) const {
    return links_[static_cast<std::size_t>(t)].corners;
  }
  /// Triangles across the side opposite each corner of triangle t; -1 where there is none.
  [[nodiscard]] const std::array<std::int32_t, 3>& neighbors(std::int32_t t) const {
    return links_[static_cast<std::size_t>(t)].neighbors;
  }

  /// Walks from triangle `hint` towards p; where that does not arrive soon (round a corner, out of
  /// the domain, far away again and again), asks a tree of boxes. Distances to points outside are
  /// rounded to nearest; all else is exact.
  ///
  /// @param p     finite.
  /// @param hint  where the search begins; any number, best the last answer for a point nearby.
  /// @par Cost    tens of ns from a good hint, else O(log n) for well-shaped triangles.
  [[nodiscard]] Location Locate(Vec2 p, std::int32_t hint) const;

  /// The same for several points, found side by side: their walks wait for the memory together.
  ///
  /// @param points  finite.
  /// @param found   one for each: on entry `triangle` is the hint, on return all is the answer.
  void LocateEach(std::span<const Vec2> points, std::span<Location> found) const;

  [[nodiscard]] bool IsTriangle(std::int32_t t) const { return t >= 0 && t < triangle_count(); }

  /// Has the memory fetch what Locate reads first from this hint, whatever number that is.
  void Prefetch(std::int32_t hint) const {
    if (!IsTriangle(hint)) return;
    const TriangleLinks& links = links_[static_cast<std::size_t>(hint)];
    PrefetchToRead(&links.corners.front());
    PrefetchToRead(&links.neighbors.back());  // Perhaps on the next line.
  }

 private:
  /// What is made at the first question that needs it.
  struct LazyParts {
    Lazy<BoxTree> tree;
    std::atomic<std::int64_t> far_walks = 0;
    Lazy<std::vector<std::int32_t>> lowest;  ///< Triangle of each point; -1 where there is none.
  };

  [[nodiscard]] std::array<Vec2, 3> Corners(std::int32_t t) const {
    const auto& [a, b, c] = corners(t);
    return {points_[static_cast<std::size_t>(a)], points_[static_cast<std::size_t>(b)],
            points_[static_cast<std::size_t>(c)]};
  }
  [[nodiscard]] bool MayWalkFar() const;
  [[nodiscard]] bool StepStraight(Vec2 p, Location& at) const;
  [[nodiscard]] Location WalkStraight(Vec2 p, std::int32_t start, std::int64_t steps_max) const;
  [[nodiscard]] std::int32_t Walk(Vec2 p, std::int32_t start) const;
  [[nodiscard]] Location Canonical(Vec2 p, std::int32_t triangle) const;
  [[nodiscard]] Location Search(Vec2 p) const;
  [[nodiscard]] const BoxTree& Tree() const;
  [[nodiscard]] std::int32_t LowestAt(std::int32_t point) const;

  LargeVector<Vec2> points_;
  BoundingBox box_;
  LargeVector<TriangleLinks> links_;
  std::int64_t row_ = 0;  ///< The root of the number of triangles: a way across.
  std::unique_ptr<LazyParts> lazy_;
};

/// How the triangles of a triangulation lie to each other.
struct Neighborhood {
  /// For each triangle, the triangles across the sides opposite its corners; -1 where there is
  /// none. Empty if the search was stopped.
  std::vector<std::array<std::int32_t, 3>> across;
  /// True if two triangles lie on the same side of an edge: then only some are paired.
  bool overlaps = false;
};

/// @param stop  if given and it asks to, nothing comes back.
/// @pre indices are in [0, point_count)
[[nodiscard]] Neighborhood FindNeighbors(std::span<const std::array<std::int32_t, 3>> triangles,
                                         std::int32_t point_count,
                                         const StopSignal* stop = nullptr);

}  // namespace pliant
