#pragma once

#include <cmath>
#include <cstdint>

#include "core/mesh/mesh.h"
#include "core/metric/metric_field.h"

namespace pliant::testing {

/// Vertices of an ideal mesh of unit edges with the boundary of `mesh`: 2/sqrt(3) times the
/// complexity, and half of those that fit on constrained edges.
inline double IdealVertexCount(const Mesh& mesh, const MetricField& field, double complexity) {
  double boundary = 0;
  std::int32_t hint = MetricField::kNoHint;
  for (std::int32_t e = 0; e < mesh.edge_slots(); ++e) {
    const EdgeRecord& edge = mesh.edge(EdgeId(e));
    if (!edge.live) continue;
    const Vec2 a = mesh.position(edge.vertices[0]);
    const Vec2 b = mesh.position(edge.vertices[1]);
    boundary += std::sqrt(SquaredLength(field.At(0.5 * (a + b), hint), b - a));
  }
  return 2 / std::sqrt(3.0) * complexity + 0.5 * boundary;
}

}  // namespace pliant::testing
