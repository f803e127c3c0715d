#pragma once

#include <gtest/gtest.h>

#include "core/mesh/mesh.h"
#include "core/metric/metric_field.h"
#include "core/pliant/quality.h"
#include "tests/support/ideal_count.h"

namespace pliant::testing {

/// Expects as many vertices as a metric asks for after one of many slow changes, and a good mesh
/// after the last of them.
inline void ExpectSteadyCount(const Mesh& mesh, const MetricField& field, bool is_last,
                              double q_mean_min) {
  const Quality quality = MeasureQuality(mesh, field);
  const double over_ideal =
      static_cast<double>(quality.vertex_count) / IdealVertexCount(mesh, field, quality.complexity);
  EXPECT_GT(over_ideal, 0.95);
  // It was somewhat above before the first step, and the first steps cannot know of the next.
  EXPECT_LT(over_ideal, 1.08);
  if (!is_last) return;
  EXPECT_GT(over_ideal, 0.97);
  EXPECT_LT(over_ideal, 1.05);
  EXPECT_GT(quality.integrated.share_125, 0.97);
  EXPECT_GT(quality.q_mean, q_mean_min);
  EXPECT_GT(quality.q_min, 0.7);
}

}  // namespace pliant::testing
