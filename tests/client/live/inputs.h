#pragma once

#include <string>

#include "core/geometry/domain.h"
#include "core/metric/metric_spec.h"

namespace pliant::client {

/// The unit square, its sides tagged 1 to 4.
inline Domain Square() {
  return {.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}},
          .segments = {{0, 1, 1}, {1, 2, 2}, {2, 3, 3}, {3, 0, 4}},
          .holes = {},
          .regions = {}};
}

inline MetricSpec Size(const std::string& formula) {
  MetricSpec spec;
  spec.source = SizeMetric{formula};
  return spec;
}

}  // namespace pliant::client
