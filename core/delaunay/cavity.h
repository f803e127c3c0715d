#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/base/stop_signal.h"
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
/// @param stop  not owned; null: nobody; else asked until the mesh is changed
///
/// @return or an error of TriangulateDomain, and the mesh untouched, if the walls and the vertices
///         that stay do not fit together at these positions; a larger cavity may do. index is the
///         id of the vertex that is outside (kPointOutsideDomain), on a wall (kPointOnSegment), or
///         where vertex other_index is (kDuplicatePoint); -1 for other errors. kCancelled.
/// @par Cost O(n log n) for n triangles
[[nodiscard]] Result<Retriangulated> RetriangulateCavity(MeshEdit& edit,
                                                         const std::vector<TriangleId>& cavity,
                                                         const std::function<bool(VertexId)>& keeps,
                                                         std::span<const VertexId> leaving = {},
                                                         const StopSignal* stop = nullptr);

}  // namespace pliant
