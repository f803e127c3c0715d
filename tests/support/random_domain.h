#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "core/geometry/domain.h"
#include "core/mesh/mesh.h"
#include "core/metric/metric_field.h"

namespace pliant::testing {

/// A random valid domain, what any mesh of it must keep, and a random metric for it.
struct RandomCase {
  Domain domain;
  double area = 0;
  double extent = 0;                            ///< Diagonal of the bounding box.
  std::map<std::int32_t, double> region_areas;  ///< By region tag.
  std::map<std::int32_t, double> tag_lengths;   ///< By segment tag; each segment has its own.
  std::string description;                      ///< Of the metric.
};

/// How a triangulation of random points is thinned out to a domain: some triangles become holes or
/// outside, so that loops touch in points; some of the remaining edges become constraints. Points
/// lie in lattices, clusters with gaps down to 1e-6, or anywhere. The same seed gives the same
/// domain everywhere.
[[nodiscard]] RandomCase MakeRandomCase(std::uint64_t seed);

/// What a mesh does not keep of the case's domain: validity, area, regions, segments with their
/// tags, given points bit for bit. Empty if it keeps all. The points must have their own numbers as
/// slots.
[[nodiscard]] std::string FaultsAgainst(const RandomCase& expected, const Mesh& mesh);

/// A metric that asks for about `node_count` nodes or fewer of the case's domain: constant, smooth,
/// with a jump, a checkerboard, or around a point; aspect ratios to 1e4.
[[nodiscard]] std::unique_ptr<MetricField> RandomMetric(const RandomCase& of, double node_count,
                                                        std::uint64_t seed,
                                                        std::string* description = nullptr);

}  // namespace pliant::testing
