#pragma once

#include <span>

#include "core/base/ids.h"
#include "core/mesh/mesh_edit.h"
#include "core/metric/metric.h"
#include "core/metric/metric_field.h"

namespace pliant {

/// What a field answers at vertices, asked for several of them at once. Each vertex keeps where the
/// search ended as its hint; one that has none begins where that for the vertex before it ended.
///
/// @param metrics  gets the answers. @pre as long as `vertices`
void AskAt(MeshEdit& edit, const MetricField& field, std::span<const VertexId> vertices,
           std::span<Metric> metrics);

}  // namespace pliant
