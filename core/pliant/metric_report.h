#pragma once

#include <cstdint>

#include "core/base/ids.h"

namespace pliant {

/// What the limits make of the metric, over the whole mesh of the last time they were laid.
struct MetricReport {
  bool limits = false;               ///< False: nothing limits, and all that follows is 0.
  std::int64_t smoothing_count = 0;  ///< Vertices whose tensor became an average with others.
  std::int64_t geometry_count = 0;   ///< Vertices that a short input segment made finer.
  std::int64_t rotation_count = 0;   ///< Vertices whose long size the rotation limit shortened.
  std::int64_t gradation_count = 0;  ///< Vertices that a neighbour's size made finer.
  std::int64_t changed_count = 0;    ///< Vertices that the last update of the limits looked into.
  double size_ratio_max = 1;         ///< Among those: largest raw size / limited size.
  VertexId worst;                    ///< Where that is; none if it is 1.
  double raw_complexity = 0;         ///< Integral of sqrt(det M), before and
  double limited_complexity = 0;     ///< after limits: 2/sqrt(3) times that many vertices.

  [[nodiscard]] bool limits_anything() const {
    return smoothing_count > 0 || geometry_count > 0 || rotation_count > 0 || gradation_count > 0;
  }
  friend bool operator==(const MetricReport&, const MetricReport&) = default;
};

}  // namespace pliant
