#pragma once

#include <span>
#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/geometry/mesh_data.h"
#include "core/geometry/vec2.h"
#include "core/mesh/mesh_edit.h"

namespace pliant {

/// A constrained edge of a mesh that comes in: directed with a triangle on its left.
struct TaggedEdge {
  std::array<VertexId, 2> vertices;
  std::int32_t tag = 0;
  bool boundary = false;  ///< No triangle on its right.
};

/// The constrained edges: those given, in their order, then the remaining ones on the boundary and
/// between triangles of different regions.
/// Errors: kNonManifoldEdge (index = second triangle that claims a side), kEdgeNotInMesh and
/// kDuplicateSegment (index = edge).
[[nodiscard]] Result<std::vector<TaggedEdge>> CollectEdges(const MeshData& mesh,
                                                           std::span<const NewTriangle> triangles);

/// Checks that positive triangles that match side by side also do not overlap: the boundary must
/// wind exactly once around what lies inside it and not at all around the rest. That is enough,
/// because the number of triangles over a point is the boundary's winding number there.
/// Error: kNotConforming.
[[nodiscard]] Status CheckBoundary(std::span<const Vec2> points, std::span<const TaggedEdge> edges);

}  // namespace pliant
