#pragma once

#include "core/geometry/vec2.h"
#include "core/mesh/mesh_edit.h"
#include "core/mesh/star.h"

namespace pliant {

/// The paper's rule for a move that leaves the star: if the first edge on the way from the center
/// to `target` is a constrained one, the node is put on it, where the way crosses it, and becomes a
/// node of that segment. [BossenHeckbert1996, sec. 3.1]
///
/// @return false (and the mesh untouched) if the first edge is another one, or if a triangle would
///         not stay positive. @pre the center is an interior node with a closed star
bool SnapToCrossedEdge(MeshEdit& edit, const Star& star, Vec2 target);

}  // namespace pliant
