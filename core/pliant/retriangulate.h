#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/base/ids.h"
#include "core/mesh/mesh.h"
#include "core/mesh/mesh_edit.h"
#include "core/metric/metric.h"

namespace pliant {

/// Triangulates a simple counter-clockwise polygon of mesh vertices by cutting ears, the best
/// shaped in `metric` first; all triangles positive by exact predicates.
///
/// @return polygon.size() - 2 triangles with region `region`, or nothing if the polygon has more
/// than 250 corners, is not simple, or is not strictly positive anywhere on the way
/// @pre polygon.size() >= 3  @par Cost O(n^3) in the worst case; n is about 6, at most 250
[[nodiscard]] std::optional<std::vector<NewTriangle>> CutEars(const Mesh& mesh,
                                                              std::span<const VertexId> polygon,
                                                              const Metric& metric,
                                                              std::int32_t region);

}  // namespace pliant
