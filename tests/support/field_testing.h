#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <utility>

#include "core/mesh/mesh.h"
#include "core/transfer/field_set.h"
#include "tests/support/random_transfer.h"

namespace pliant::testing {

/// A field over all slots of a mesh: f at vertices or at centroids of triangles.
[[nodiscard]] inline Field FieldOf(const Mesh& mesh, FieldLocation location, TransferKind transfer,
                                   const std::function<double(Vec2)>& f) {
  Field field{.name = "f", .location = location, .transfer = transfer, .values = {}};
  if (location == FieldLocation::kVertex) {
    field.values.resize(static_cast<std::size_t>(mesh.vertex_slots()));
    for (const VertexId id : testing::LiveVertices(mesh))
      field.values[id.index()] = f(mesh.position(id));
  } else {
    field.values.resize(static_cast<std::size_t>(mesh.triangle_slots()));
    for (const TriangleId id : testing::LiveTriangles(mesh)) {
      field.values[id.index()] = f(CenterOf(CornersIn(mesh, id)));
    }
  }
  return field;
}

/// The same as a client's message: the live elements in ascending order.
[[nodiscard]] inline FieldValues ValuesOf(const Mesh& mesh, std::string name,
                                          FieldLocation location,
                                          const std::function<double(Vec2)>& f) {
  const Field field = FieldOf(mesh, location, TransferKind::kLinear, f);
  FieldValues values{.name = std::move(name), .location = location, .ids = {}, .values = {}};
  if (location == FieldLocation::kVertex) {
    for (const VertexId id : testing::LiveVertices(mesh))
      values.values.push_back(field.values[id.index()]);
  } else {
    for (const TriangleId id : testing::LiveTriangles(mesh)) {
      values.values.push_back(field.values[id.index()]);
    }
  }
  return values;
}

/// The integral of a scalar field, linear or constant on triangles, and of its absolute value.
struct Integral {
  double value = 0;
  double magnitude = 0;
};
[[nodiscard]] inline Integral IntegralOf(const Mesh& mesh, const Field& field) {
  Integral integral;
  for (const TriangleId id : testing::LiveTriangles(mesh)) {
    const double area = AreaOf(CornersIn(mesh, id));
    if (field.location == FieldLocation::kTriangle) {
      integral.value += area * field.values[id.index()];
      integral.magnitude += area * std::fabs(field.values[id.index()]);
      continue;
    }
    for (const VertexId v : mesh.triangle(id).vertices) {
      integral.value += area / 3 * field.values[v.index()];
      integral.magnitude += area / 3 * std::fabs(field.values[v.index()]);
    }
  }
  return integral;
}

}  // namespace pliant::testing
