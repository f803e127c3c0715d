#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/domain.h"
#include "core/geometry/mesh_data.h"
#include "core/metric/metric.h"

namespace pliant::io {

/// What a file describes: a mesh if it has triangles, a domain otherwise.
using Geometry = std::variant<Domain, MeshData>;

/// A named field over the points of a mesh.
struct PointField {
  std::string name = "metric";
  /// 1: a scalar; 3: a symmetric tensor as m11, m12, m22.
  std::int32_t component_count = 1;
  std::vector<double> values = {};  ///< component_count values per point, point by point.

  friend bool operator==(const PointField&, const PointField&) = default;
};

/// Reads a field of sizes (1 component, domain units) or tensors (3 components) as metrics.
/// Fails with kOutOfRange for a size that is not positive; tensors are taken as they are.
[[nodiscard]] Result<std::vector<Metric>> MetricsFromField(const PointField& field);

/// The metrics as a field of 3 components.
[[nodiscard]] PointField FieldFromMetrics(const std::vector<Metric>& metrics);

/// Checks that edges and triangles name points of the mesh. Fails with kIndexOutOfRange, field
/// "triangles" or "edges" and the 0-based number of the first bad element.
[[nodiscard]] Status CheckIndices(const MeshData& mesh);

/// The mesh itself if it has triangles, else the domain of its edges.
[[nodiscard]] Geometry GeometryFromMesh(MeshData mesh);

}  // namespace pliant::io
