#include "client/io/geometry.h"

#include <cstddef>
#include <utility>

namespace pliant::io {
namespace {

template <std::size_t kCorners>
Status CheckElements(const std::vector<std::array<std::int32_t, kCorners>>& elements,
                     std::size_t point_count, const char* field) {
  for (std::size_t i = 0; i < elements.size(); ++i) {
    for (const std::int32_t p : elements[i]) {
      if (p >= 0 && static_cast<std::size_t>(p) < point_count) continue;
      return Error{.code = ErrorCode::kIndexOutOfRange,
                   .message = std::string("element ") + std::to_string(i) + " of the " + field +
                              " (counted from 0) names point " + std::to_string(p) +
                              " (counted from 0), but there are " + std::to_string(point_count) +
                              " points; check whether the file counts from 0 or from 1",
                   .field = field,
                   .index = static_cast<std::int64_t>(i)};
    }
  }
  return {};
}

}  // namespace

Result<std::vector<Metric>> MetricsFromField(const PointField& field) {
  std::vector<Metric> metrics;
  if (field.component_count == 3) {
    metrics.reserve(field.values.size() / 3);
    for (std::size_t i = 0; i + 2 < field.values.size(); i += 3) {
      metrics.push_back({field.values[i], field.values[i + 1], field.values[i + 2]});
    }
    return metrics;
  }
  metrics.reserve(field.values.size());
  for (std::size_t i = 0; i < field.values.size(); ++i) {
    const double size = field.values[i];
    if (!(size > 0)) {
      return Error{.code = ErrorCode::kOutOfRange,
                   .message = "size " + std::to_string(size) + " at point " + std::to_string(i) +
                              " (counted from 0) is not positive; a size is a wanted edge length",
                   .field = field.name,
                   .index = static_cast<std::int64_t>(i)};
    }
    metrics.push_back(Metric::Isotropic(size));
  }
  return metrics;
}

PointField FieldFromMetrics(const std::vector<Metric>& metrics) {
  PointField field;
  field.component_count = 3;
  field.values.reserve(3 * metrics.size());
  for (const Metric& m : metrics) {
    field.values.insert(field.values.end(), {m.m11, m.m12, m.m22});
  }
  return field;
}

Status CheckIndices(const MeshData& mesh) {
  PLIANT_RETURN_IF_ERROR(CheckElements(mesh.triangles, mesh.points.size(), "triangles"));
  return CheckElements(mesh.edges, mesh.points.size(), "edges");
}

Geometry GeometryFromMesh(MeshData mesh) {
  if (!mesh.triangles.empty()) return mesh;
  Domain domain;
  domain.points = std::move(mesh.points);
  domain.segments.reserve(mesh.edges.size());
  for (std::size_t i = 0; i < mesh.edges.size(); ++i) {
    const std::int32_t tag = mesh.edge_tags.empty() ? 0 : mesh.edge_tags[i];
    domain.segments.push_back({.a = mesh.edges[i][0], .b = mesh.edges[i][1], .tag = tag});
  }
  return domain;
}

}  // namespace pliant::io
