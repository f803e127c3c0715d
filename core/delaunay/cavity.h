#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/base/ids.h"
#include "core/mesh/mesh_edit.h"

namespace pliant {

/// What a cavity became.
struct Retriangulated {
  std::vector<VertexId> removed;  ///< Free vertices that lay inside, and those that leave walls.
  std::vector<VertexId> corners;  ///< Vertices of the new triangles, ascending.
};

/// Forgets the triangles of a cavity, whatever their orientation, and fills the polygon that its
/// rim makes, at the positions that vertices have now, with a constrained Delaunay triangulation.
/// Constrained edges inside stay. Vertices inside stay if a constrained edge ends there, if they
/// are fixed, or if `keeps` says so; others go.
/// @param leaving  vertices inside a segment that shall go, too, none twice: the edges on either
///                 side become one. The cavity has all triangles at them.
///
/// @return nothing, and the mesh untouched, if the rim and the constrained edges cross at these
///         positions: a larger cavity may do.
/// @par Cost O(n log n) for n triangles
std::optional<Retriangulated> RetriangulateCavity(MeshEdit& edit,
                                                  const std::vector<TriangleId>& cavity,
                                                  const std::function<bool(VertexId)>& keeps,
                                                  std::span<const VertexId> leaving = {});

}  // namespace pliant
