#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "pliant/v1/edit.pb.h"
#include "tests/support/mirror.h"
#include "tests/support/wire_arrays.h"

/// Updates of every kind, made for the mesh of a mirror; their numbers are the caller's business.
namespace pliant::test {

inline v1::EditRequest Advance(std::int64_t visits_max = 0) {
  v1::EditRequest request;
  request.mutable_advance();
  if (visits_max > 0) request.mutable_advance()->set_budget_visits(visits_max);
  return request;
}

inline v1::EditRequest Size(const std::string& size) {
  v1::EditRequest request;
  request.mutable_metric()->add_sources()->mutable_size()->set_size(size);
  return request;
}

/// Tensors at the vertices of the lower left quarter.
inline v1::EditRequest Tensors(const Mirror& mirror, double m) {
  std::vector<std::int32_t> ids;
  std::vector<double> tensors;
  for (const auto& [slot, position] : mirror.vertices) {
    if (position[0] > 0.5 || position[1] > 0.5) continue;
    ids.push_back(slot);
    tensors.insert(tensors.end(), {m, 0, 2 * m});
  }
  v1::EditRequest request;
  v1::VertexMetric& vertices = *request.mutable_metric()->add_sources()->mutable_vertices();
  vertices.set_revision(mirror.revision);
  *vertices.mutable_vertex_ids() = Ints(ids);
  *vertices.mutable_tensors() = Doubles(tensors, 3);
  return request;
}

inline v1::EditRequest Field(const Mirror& mirror, double factor) {
  v1::EditRequest request;
  request.mutable_fields()->set_revision(mirror.revision);
  v1::FieldValues& field = *request.mutable_fields()->add_values();
  field.set_name("u");
  field.set_location(v1::FIELD_LOCATION_VERTEX);
  std::vector<double> values;
  for (const auto& [slot, position] : mirror.vertices) {
    values.push_back(factor * position[0] + position[1]);
  }
  *field.mutable_values() = Doubles(values, 1);
  return request;
}

inline v1::EditRequest Freeze(const Mirror& mirror) {
  v1::EditRequest request;
  std::vector<std::int32_t> ids;
  for (const auto& [slot, position] : mirror.vertices) {
    if (position[0] < 0.3) ids.push_back(slot);
  }
  request.mutable_constraints()->set_revision(mirror.revision);
  *request.mutable_constraints()->mutable_frozen_vertices() = Ints(ids);
  return request;
}

inline v1::EditRequest Hops(int hops_max) {
  v1::EditRequest request;
  request.mutable_options()->set_hops_max(hops_max);
  return request;
}

inline v1::EditRequest SquareWithHole() {
  v1::EditRequest request;
  v1::Domain& domain = *request.mutable_domain()->mutable_domain();
  *domain.mutable_points() = Doubles({0, 0, 1, 0, 1, 1, 0, 1, 0.45, 0.4, 0.65, 0.5, 0.5, 0.62}, 2);
  *domain.mutable_segments() = Ints({0, 1, 1, 2, 2, 3, 3, 0, 4, 5, 5, 6, 6, 4}, 2);
  *domain.mutable_holes() = Doubles({0.52, 0.5}, 2);
  return request;
}

inline v1::EditRequest SquareWithoutCorner() {
  v1::EditRequest request;
  v1::Domain& domain = *request.mutable_domain()->mutable_domain();
  *domain.mutable_points() = Doubles({0, 0, 1, 0, 1, 0.7, 0.8, 1, 0, 1}, 2);
  *domain.mutable_segments() = Ints({0, 1, 1, 2, 2, 3, 3, 4, 4, 0}, 2);
  return request;
}

/// Moves a strip of vertices along x.
inline v1::EditRequest Displace(const Mirror& mirror, double by) {
  v1::EditRequest request;
  std::vector<std::int32_t> ids;
  std::vector<double> vectors;
  for (const auto& [slot, position] : mirror.vertices) {
    if (std::fabs(position[0] - 0.3) > 0.15) continue;
    ids.push_back(slot);
    vectors.insert(vectors.end(), {by, 0});
  }
  v1::MetricDisplacement& moved = *request.mutable_metric()->mutable_displacement();
  moved.set_revision(mirror.revision);
  *moved.mutable_vertex_ids() = Ints(ids);
  *moved.mutable_displacements() = Doubles(vectors, 2);
  return request;
}

/// The same, with tensors of where the strip goes, for the whole mesh.
inline v1::EditRequest DisplaceWithTensors(const Mirror& mirror, double by) {
  v1::EditRequest request = Displace(mirror, by);
  std::vector<double> tensors;
  for (const auto& [slot, position] : mirror.vertices) {
    const double x = position[0] + (std::fabs(position[0] - 0.3) > 0.15 ? 0 : by);
    tensors.insert(tensors.end(), {500 + 300 * x, 0, 900});
  }
  v1::VertexMetric& vertices = *request.mutable_metric()->add_sources()->mutable_vertices();
  vertices.set_revision(mirror.revision);
  *vertices.mutable_tensors() = Doubles(tensors, 3);
  return request;
}

inline v1::EditRequest Rollback(std::int64_t revision) {
  v1::EditRequest request;
  request.mutable_rollback()->set_to_revision(revision);
  return request;
}

inline v1::EditRequest Discard() {
  v1::EditRequest request;
  request.mutable_discard();
  return request;
}

}  // namespace pliant::test
