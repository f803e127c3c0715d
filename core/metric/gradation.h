#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/metric/metric.h"

namespace pliant {

/// The edges of a mesh as a graph: the neighbours of vertex v are
/// neighbors[offsets[v]] ... neighbors[offsets[v + 1] - 1], each edge from both its ends.
struct VertexGraph {
  std::vector<std::int32_t> offsets;  ///< One more than vertices.
  std::vector<std::int32_t> neighbors;
};

/// The edges of triangles with corners in [0, vertex_count). @par Cost O(n log degree)
[[nodiscard]] VertexGraph GraphOfTriangles(std::span<const std::array<std::int32_t, 3>> triangles,
                                           std::int32_t vertex_count);

/// How much a metric may change from place to place. Larger is looser, 0 is off.
struct GradationOptions {
  /// A size may grow by at most this factor over a distance of one wanted length: h_q is at most
  /// h_p + ln(gradation) |pq|. 1.5 suits the pliant loop, 1.3 is mmg's hgrad, 2 the loosest that
  /// keeps quality at jumps; >= 1, and at 1 nothing grows.
  double gradation = 0;
  /// How far the axes may turn over one long element, as a share of its thin size: the long size
  /// at a front of radius r is at most sqrt(rotation * thin * r). 0.7 makes strongly curved fronts
  /// meshable; 0.3 to 1.4 are sensible.
  double rotation = 0;
  /// Greatest size at a given point of the domain, relative to the shortest input segment there.
  /// At 1 a short segment is one edge, and growth leads from there to what the metric wants. Needs
  /// `gradation` to reach beyond the point. LimitMetrics knows no segments and ignores it.
  double geometry = 0;

  /// How many elements shall fit across a gap between two boundaries, where that makes them
  /// smaller; 0.5 to 100, 1 or 2 are usual. A gap is what lies between a vertex of the boundary and
  /// what faces it; no gap makes them smaller than a hundredth. Needs `gradation` to reach beyond
  /// the boundary. LimitMetrics knows no segments and ignores it.
  double gap_element_count = 0;
  /// How many times each tensor is averaged with those of its neighbours before anything limits it,
  /// 0 to 8: for tensors with noise, such as those of a computed solution. Once or twice leave a
  /// clean front as it is. May make a metric coarser too, and what it does depends on the mesh.
  std::int32_t smoothing_count = 0;

  /// Where an update comes to rest and the metric is not met because it jumps, crosses or turns too
  /// much (LimitsHelp of core/pliant/trouble.h), the usual `gradation` and `rotation` hold from
  /// then on, as if they had been asked for. Means nothing where one of the two is set.
  bool automatic = true;

  static constexpr double kUsualGradation = 1.5;
  static constexpr double kUsualRotation = 0.7;

  /// True while nobody knows whether the usual limits are needed.
  [[nodiscard]] constexpr bool awaits_need() const {
    return automatic && gradation == 0 && rotation == 0;
  }
  /// These, with the usual limits in force.
  [[nodiscard]] constexpr GradationOptions WithUsual() const {
    GradationOptions usual = *this;
    usual.gradation = kUsualGradation;
    usual.rotation = kUsualRotation;
    return usual;
  }

  /// True if anything limits.
  [[nodiscard]] constexpr bool any() const {
    return gradation != 0 || rotation != 0 || geometry != 0 || gap_element_count != 0 ||
           smoothing_count != 0;
  }
  friend constexpr bool operator==(const GradationOptions&, const GradationOptions&) = default;
};

/// What limiting did.
struct LimitedMetrics {
  std::vector<Metric> tensors;       ///< Per vertex; to the bit the raw one where nothing bit.
  std::int64_t smoothing_count = 0;  ///< Vertices whose tensor is an average with others.
  std::int64_t rotation_count = 0;   ///< Vertices whose long size the rotation limit shortened.
  std::int64_t gradation_count = 0;  ///< Vertices that a neighbour's size made finer.
  double size_ratio_max = 1;         ///< Largest raw size / limited size, in any direction.
};

/// Makes a raw metric one that a mesh can follow: each tensor as coarse as it may be, nowhere
/// coarser than the raw one (or than its average, with smoothing).
///
/// Two shortest-path problems over the edges, first of the thin sizes (each carries its axes along
/// where the neighbour's own wish is weaker), then of the long ones; before and between them the
/// rotation limit, which does not propagate. Unlike the intersection of tensors, this has one
/// solution: it depends neither on the order of work nor on the numbering of vertices, to the bit.
///
/// @param points, tensors  one per vertex of `graph`; tensors positive definite.
/// @par Accuracy  in every direction limited length >= (1 - 1e-9) raw length, while one raw radius
///                is at most 1e4 times the other.
/// @par Cost      O(n log n); below a microsecond per vertex.
[[nodiscard]] LimitedMetrics LimitMetrics(const VertexGraph& graph, std::span<const Vec2> points,
                                          std::span<const Metric> tensors,
                                          const GradationOptions& options);

}  // namespace pliant
