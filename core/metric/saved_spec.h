#pragma once

#include <optional>

#include "core/base/bytes.h"
#include "core/geometry/mesh_data.h"
#include "core/metric/metric_spec.h"

namespace pliant {

/// Writes a specification, or that there is none (null).
void PutSpec(const MetricSpec* spec, ByteWriter& writer);

/// What PutSpec wrote. The reader fails where the bytes cannot be one; MakeMetricField is who says
/// whether it makes sense.
[[nodiscard]] std::optional<MetricSpec> TakeSpec(ByteReader& reader);

void PutMeshData(const MeshData& mesh, ByteWriter& writer);
[[nodiscard]] MeshData TakeMeshData(ByteReader& reader);

}  // namespace pliant
