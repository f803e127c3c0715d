#pragma once

#include <cstddef>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/vec2.h"
#include "core/metric/metric.h"
#include "core/metric/metric_spec.h"

namespace pliant {

/// Tensors at the nodes of a regular grid.
struct GridMetric {
  Vec2 origin;                   ///< The first node.
  Vec2 step;                     ///< Distance of columns and of rows, > 0, domain units.
  std::size_t column_count = 0;  ///< Nodes in a row, >= 2.
  std::vector<Metric> tensors;   ///< Row after row, x fastest; at least two rows.
};

/// The grid as a background mesh: each cell is cut by its rising diagonal, so that tensors are
/// log-Euclidean in between, and outside the value at the nearest point of the grid holds.
///
/// @return the mesh and its tensors, or the first error: kNotFinite and kOutOfRange for origin,
///         step and column_count, kArrayLength for tensors that do not fill two or more rows,
///         kTooLarge beyond 2^30 nodes; `field` starts with "metric.grid.". Tensors are checked by
///         MakeMetricField.
/// @par Cost O(nodes)
[[nodiscard]] Result<BackgroundMetric> ToBackground(GridMetric grid);

}  // namespace pliant
