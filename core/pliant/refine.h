#pragma once

#include <vector>

#include "core/base/executor.h"
#include "core/mesh/mesh.h"
#include "core/mesh/mesh_edit.h"

namespace pliant {

/// The edges to halve so that a mesh converged for twice the wanted size nearly is one for the
/// size itself: those longer than 1.3 in the mesh's metric, each at its geodesic midpoint.
///
/// The midpoint of the metric's shortest way between the ends is
///
///     (a + b)/2 + G^-1 ((M_b - M_a) e - grad(e' M e)/2) / 8,   e = b - a, G = (M_a + M_b)/2
///
/// to second order; the gradient comes from the corners of the triangles at the edge. A straight
/// midpoint is taken where a child would not be positive, and an edge stays whole where even that
/// does not help (rounding). On a segment the point stays on it.
///
/// @param growth  what the mesh's metric is going to be multiplied by, > 0; midpoints do not depend
///                on it.
/// @param executor  works on parts of the mesh; changes nothing in the result.
/// @return in ascending order of triangle, as MeshEdit::Refine wants it.
[[nodiscard]] std::vector<EdgeSplit> PlanRefinement(const Mesh& mesh, double growth,
                                                    Executor& executor);
[[nodiscard]] std::vector<EdgeSplit> PlanRefinement(const Mesh& mesh, double growth);

/// The live triangles along a Hilbert curve through their centers, so that neighbours are near each
/// other: the order for MeshEdit::Refine of a mesh that grew one node at a time.
/// @par Cost O(n log n)
[[nodiscard]] std::vector<TriangleId> TrianglesAlongCurve(const Mesh& mesh);

/// The live triangles in order of slot: the order for a mesh that was refined before.
[[nodiscard]] std::vector<TriangleId> TrianglesBySlot(const Mesh& mesh);

}  // namespace pliant
