#pragma once

#include <functional>
#include <vector>

#include "core/base/ids.h"
#include "core/base/stop_signal.h"
#include "core/mesh/mesh.h"

namespace pliant {

/// Adds to a cavity whatever it overlaps at the positions that vertices have now: the triangles
/// outside that one of its walls runs into, those that hold a vertex of it, and what these overlap
/// in turn. RetriangulateCavity then fails for vertices only that no mesh can have where they are.
///
/// @param cavity  has all inverted triangles
/// @param keeps  as for RetriangulateCavity
/// @param stop  not owned; null: nobody; else asked: what it returns then is too little
/// @return each once, ascending. @par Cost O(n log k) a round, and mostly two or three rounds, for
/// n
///         triangles of the mesh and k of the cavity
[[nodiscard]] std::vector<TriangleId> WithClashes(const Mesh& mesh, std::vector<TriangleId> cavity,
                                                  const std::function<bool(VertexId)>& keeps,
                                                  const StopSignal* stop = nullptr);

}  // namespace pliant
