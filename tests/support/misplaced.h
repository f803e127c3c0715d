#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/base/result.h"
#include "core/geometry/predicates.h"
#include "core/mesh/mesh.h"
#include "core/motion/motion.h"

namespace pliant::testing {

inline bool IsBoundary(const Mesh& mesh, const EdgeRecord& edge) {
  const TriangleRecord& triangle = mesh.triangle(edge.triangle);
  for (std::size_t side = 0; side < 3; ++side) {
    const VertexId opposite = triangle.vertices[side];
    if (opposite != edge.vertices[0] && opposite != edge.vertices[1]) {
      return !triangle.neighbors[side].valid();
    }
  }
  return false;
}

/// True if the domain of a mesh has p neither inside nor on its boundary: by the number of boundary
/// edges below p.
inline bool IsOutside(const Mesh& mesh, Vec2 p) {
  bool outside = true;
  for (std::int32_t e = 0; e < mesh.edge_slots(); ++e) {
    const EdgeRecord& edge = mesh.edge(EdgeId(e));
    if (!edge.live) continue;
    if (!IsBoundary(mesh, edge)) continue;
    Vec2 a = mesh.position(edge.vertices[0]);
    Vec2 b = mesh.position(edge.vertices[1]);
    if (b.x < a.x) std::swap(a, b);
    const int side = Orient2d(a, b, p);
    if (side == 0 && std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) &&
        std::min(a.y, b.y) <= p.y && p.y <= std::max(a.y, b.y)) {
      return false;
    }
    if (a.x <= p.x && p.x < b.x && side > 0) outside = !outside;
  }
  return outside;
}

/// True for a refusal that names a vertex in the interior because of where it is to go, and is
/// right, as far as that can be told without moving the boundary.
/// @param mesh  as before the motion
inline bool IsMisplaced(const Mesh& mesh, const MotionRequest& request, const Error& error) {
  const auto index = static_cast<std::size_t>(error.index);
  if (error.field != "motion.positions" || index >= request.vertices.size()) return false;
  const auto on_boundary = [&](VertexId vertex) { return mesh.vertex(vertex).edge.valid(); };
  if (on_boundary(request.vertices[index])) return false;
  if (error.code == ErrorCode::kDuplicatePoint || error.code == ErrorCode::kPointOnSegment) {
    return true;
  }
  const bool boundary_moves =
      !request.tags.empty() || std::ranges::any_of(request.vertices, on_boundary);
  return error.code == ErrorCode::kPointOutsideDomain &&
         (boundary_moves || IsOutside(mesh, request.positions[index]));
}

}  // namespace pliant::testing
