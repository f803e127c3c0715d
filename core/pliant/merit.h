#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "core/geometry/vec2.h"
#include "core/mesh/mesh.h"
#include "core/metric/metric.h"

namespace pliant {

/// What is good enough: Q of a triangle, and the squared lengths of its edges.
inline constexpr double kQualityWanted = 0.8;
inline constexpr double kSquaredLongest = 1.42 * 1.42;
inline constexpr double kSquaredShortest = 0.65 * 0.65;

/// What the merit of a triangle (mend.h) needs of a corner.
struct MeritCorner {
  Vec2 position;
  Metric metric;
  /// Edges are short relative to the root of this: 1, less where given vertices are crowded, whom
  /// nobody can move.
  double squared_room = 1;
  /// Q that is good enough for a triangle with this corner; 0: kQualityWanted.
  double quality_wanted = 0;
};

/// As it is in the mesh.
///
/// A given vertex at a given edge shorter than kSquaredShortest is crowded. Its room lets that edge
/// be, and a little shorter ones. A mended node beside such vertices stands between a fine and a
/// coarse row, where edges are shorter than 1.
/// @par Cost O(1), but for given vertices and mended nodes a look around
[[nodiscard]] MeritCorner CrowdedMeritCorner(const Mesh& mesh, VertexId vertex);
[[nodiscard]] inline MeritCorner MeritCornerAt(const Mesh& mesh, VertexId vertex) {
  const VertexRecord& record = mesh.vertex(vertex);
  if (record.fixed || record.visit.mended) return CrowdedMeritCorner(mesh, vertex);
  return {record.position, record.metric};
}

/// True of a mended node that has less room for the sake of its neighbours.
[[nodiscard]] bool IsMendedBesideCrowd(const Mesh& mesh, VertexId node);

/// A node that mending makes beside crowded given vertices.
[[nodiscard]] MeritCorner BornBesideCrowd(Vec2 place, const Metric& metric);

/// True of crowded given vertices.
[[nodiscard]] bool IsCrowded(const MeritCorner& corner);

/// What the merit of a triangle is made of: its Q is 2 sqrt(3 determinant) doubled_area / squares.
struct MeritShape {
  double determinant;   ///< Of the sum of the metrics, which stands for their mean:
  double doubled_area;  ///< Q of eq. 5 does not change when the metric is scaled.
  double squares;       ///< Of the sides, by that sum.
  double longest;       ///< Squared lengths of edges.
  double shortest;      ///< The same, over the least squared_room of the corners.
  double quality_wanted;
};

[[nodiscard]] inline MeritShape MeritShapeOf(const MeritCorner& a, const MeritCorner& b,
                                             const MeritCorner& c) {
  const auto squared_between = [](const MeritCorner& from, const MeritCorner& to) {
    return 0.5 * SquaredLength(from.metric + to.metric, to.position - from.position);
  };
  const Vec2 ab = b.position - a.position;
  const Vec2 bc = c.position - b.position;
  const Vec2 ca = a.position - c.position;
  const Metric sum = a.metric + b.metric + c.metric;
  const double l_ab = squared_between(a, b);
  const double l_bc = squared_between(b, c);
  const double l_ca = squared_between(c, a);
  const double quality = std::max({a.quality_wanted, b.quality_wanted, c.quality_wanted});
  return {.determinant = Determinant(sum),
          .doubled_area = Cross(ab, bc),
          .squares = SquaredLength(sum, ab) + SquaredLength(sum, bc) + SquaredLength(sum, ca),
          .longest = std::max({l_ab, l_bc, l_ca}),
          .shortest = std::min({l_ab, l_bc, l_ca}) /
                      std::min({a.squared_room, b.squared_room, c.squared_room}),
          .quality_wanted = quality > 0 ? quality : kQualityWanted};
}

[[nodiscard]] inline double MeritOf(const MeritShape& shape) {
  const double q = 2 * std::sqrt(3 * shape.determinant) * shape.doubled_area / shape.squares;
  return std::min({q / shape.quality_wanted, kSquaredLongest / shape.longest,
                   shape.shortest / kSquaredShortest});
}

/// True if MeritOf is above `merit`, seen without roots and divisions, as for most triangles; false
/// also where rounding could tell.
[[nodiscard]] inline bool IsMeritSurelyAbove(const MeritShape& shape, double merit) {
  constexpr double kSurely = 1 + 1e-9;
  const double wanted = kSurely * merit;
  const double low = wanted * shape.quality_wanted * shape.squares;
  return shape.doubled_area > 0 && wanted * shape.longest < kSquaredLongest &&
         shape.shortest > wanted * kSquaredShortest &&
         12 * (shape.determinant * shape.doubled_area) * shape.doubled_area > low * low;
}

/// Triangles of this merit and above have no shortfall: a margin beyond good enough, so that what
/// is mended is not undone by its neighbours' mending.
inline constexpr double kMeritGoal = 1.1;

/// (kMeritGoal - merit)^4, or 0.
[[nodiscard]] inline double ShortfallOf(const MeritCorner& a, const MeritCorner& b,
                                        const MeritCorner& c) {
  const MeritShape shape = MeritShapeOf(a, b, c);
  if (IsMeritSurelyAbove(shape, kMeritGoal)) return 0;
  const double lack = std::max(0.0, kMeritGoal - MeritOf(shape));
  return (lack * lack) * (lack * lack);
}

/// The shortfall of the triangles that a center makes with each two vertices of a ring that follow
/// each other; where that is no less than `enough`, something that is not either.
[[nodiscard]] inline double ShortfallAround(
    std::span<const MeritCorner> ring, const MeritCorner& center,
    double enough = std::numeric_limits<double>::infinity()) {
  double sum = 0;
  for (std::size_t k = 0; k + 1 < ring.size() && sum < enough; ++k) {
    sum += ShortfallOf(center, ring[k], ring[k + 1]);
  }
  return sum;
}

/// A change must lessen the shortfall around it by this share, and by this much.
inline constexpr double kGainShare = 0.05;
inline constexpr double kGainMin = 1e-6;

[[nodiscard]] inline bool IsGain(double before, double after) {
  return before - after >= std::max(kGainShare * before, kGainMin);
}

}  // namespace pliant
