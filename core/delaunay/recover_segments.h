#pragma once

#include <span>

#include "core/delaunay/check_boundary.h"
#include "core/delaunay/import_mesh.h"

namespace pliant {

/// Joins straight runs of constrained edges with one tag to segments and fills the plan's edges,
/// segments and fixed vertices. @pre plan.positions and plan.triangles are set
void RecoverSegments(std::span<const TaggedEdge> edges, MeshPlan& plan);

}  // namespace pliant
