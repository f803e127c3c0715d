// What tests of whole sessions of the core share.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <utility>

#include "core/pliant/quality.h"
#include "core/pliant/remesher.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant::testing {

inline constexpr MetricLimits kNoLimits{.gradation = {.automatic = false}};

/// A session of the unit square at rest on a uniform metric that nothing limits by itself.
inline std::unique_ptr<Remesher> UniformSession(const MetricLimits& limits = kNoLimits) {
  const MetricSpec spec{
      .source = SizeMetric{"0.1"}, .bounds = limits.bounds, .gradation = limits.gradation};
  auto made = Remesher::Create(Rectangle({0, 0}, {1, 1}), spec, {});
  EXPECT_TRUE(made.ok());
  EXPECT_TRUE((*made)->Step({}).ok());
  (void)(*made)->Commit();
  return std::move(*made);
}

/// Runs the loop to its end and commits. @return the state hash
inline std::uint64_t HashAtRest(Remesher& remesher) {
  EXPECT_TRUE(remesher.Step({}).ok());
  const MeshDiff diff = remesher.Commit();
  EXPECT_EQ(Faults(remesher.mesh()), "");
  return diff.summary.state_hash;
}

/// By the metric that the session follows.
inline double LeastQuality(const Remesher& remesher) {
  return MeasureQuality(remesher.mesh(), remesher.field()).q_min;
}

}  // namespace pliant::testing
