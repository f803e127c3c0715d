#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/ids.h"
#include "core/base/stop_signal.h"
#include "core/geometry/vec2.h"
#include "core/mesh/mesh.h"
#include "core/metric/metric.h"
#include "core/metric/metric_field.h"

namespace pliant {

/// What a metric has where a vertex would come to lie.
struct Ahead {
  Vec2 place;
  std::optional<Metric> tensor;  ///< None where the vertex may not go, or nobody answers.
  std::int32_t hint = MetricField::kNoHint;  ///< For the field, at the place.
};

/// What a field has one shift ahead of many vertices of a mesh. A field of triangles is walked
/// through from the answers of neighbours, which is a matter of a few triangles each, and along
/// many ways side by side, so that they wait for the memory together.
///
/// @param vertices  best in ascending order
/// @param stop  null: nobody; else the rest is left out if it asks to
/// @return one for each vertex; answers are those of MetricField::Probe
[[nodiscard]] std::vector<Ahead> LookAhead(const Mesh& mesh, const MetricField& field,
                                           std::span<const VertexId> vertices, Vec2 shift,
                                           const StopSignal* stop = nullptr);

}  // namespace pliant
