#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "core/base/executor.h"
#include "core/geometry/mesh_data.h"
#include "core/mesh/mesh.h"
#include "core/mesh/mesh_diff.h"
#include "core/metric/metric_field.h"

namespace pliant {

/// A histogram with equal bins over [0, upper); the last bin also holds everything beyond.
template <std::size_t kBins>
struct Histogram {
  double upper = 1;
  std::array<std::int64_t, kBins> counts{};

  friend bool operator==(const Histogram&, const Histogram&) = default;
};

/// Lengths of edges under one way to measure them; dimensionless, 1 is what was asked for.
struct LengthStatistics {
  double mean = 0;
  double min = 0;
  double max = 0;
  double share_sqrt2 = 0;  ///< Share of edges in [1/sqrt 2, sqrt 2], in [0, 1].
  double share_125 = 0;    ///< Share of edges in [0.8, 1.25], in [0, 1].

  friend bool operator==(const LengthStatistics&, const LengthStatistics&) = default;
};

/// How well a mesh meets a metric.
struct Quality {
  std::int64_t vertex_count = 0;
  std::int64_t triangle_count = 0;
  std::int64_t edge_count = 0;  ///< All edges, not only constrained ones.

  /// Of triangles: Q = 4 sqrt(3) A_M / sum l_M^2 with M the mean of the metric at the corners
  /// (eq. 5): 1 for a triangle that is equilateral in the metric, 0 for a flat one.
  double q_mean = 0;
  double q_min = 0;
  double q_percentile_1 = 0;  ///< 1 % of the triangles are worse than this.

  LengthStatistics integrated;  ///< By 5-point Gauss integration of the metric along each edge.
  LengthStatistics averaged;    ///< By eq. 4, from the metric at the two ends.

  /// The paper's figures: normalized angles in degrees [0, 180) and eq. 4 lengths [0, 2).
  Histogram<60> angles{.upper = 180};
  Histogram<60> lengths{.upper = 2};

  /// Integral of sqrt(det M) over the mesh (one-point per triangle): an ideal unit mesh has about
  /// complexity * 2/sqrt(3) vertices.
  double complexity = 0;

  friend bool operator==(const Quality&, const Quality&) = default;
};

/// Measures a mesh against a field. Sums run in slot order: the same bits on every machine.
/// @par Cost O(mesh): five evaluations of the field per edge and one per vertex.
[[nodiscard]] Quality MeasureQuality(const Mesh& mesh, const MetricField& field);

/// The same for plain arrays. @pre indices are in range
[[nodiscard]] Quality MeasureQuality(const MeshData& mesh, const MetricField& field);

/// MeasureQuality of a mesh in parts, for those who have something else to do in between or may
/// lose interest. The same bits, whoever helps.
///
/// *Threads*: one caller at a time; mesh and field must not change until the last part is measured.
class QualityMeasurement {
 public:
  /// @param mesh, field  not owned.
  QualityMeasurement(const Mesh& mesh, const MetricField& field);
  ~QualityMeasurement();

  /// Measures the next part; false if there is none any more.
  /// @param helpers  share the work; alone, if the field is for one thread at a time (NodalField).
  /// @par Cost some 4,000 triangles with their edges: a few milliseconds of one thread.
  bool Continue(Executor& helpers);

  /// What was measured. Once. @pre Continue has returned false @par Cost O(triangles): 10 ns each
  [[nodiscard]] Quality Take();

 private:
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace pliant
