#pragma once

#include <functional>
#include <vector>

#include "core/base/ids.h"
#include "core/base/stop_signal.h"
#include "core/geometry/vec2.h"
#include "core/mesh/mesh.h"

namespace pliant {

/// Vertices that were put elsewhere in one go, past others: the mesh has their new positions.
struct SuddenMove {
  /// Where a vertex was; where it is, if it did not move.
  std::function<Vec2(VertexId)> before;
  /// Whether a vertex may be removed.
  std::function<bool(VertexId)> is_free;
};

/// Who goes where a free vertex that moved and a side with a free vertex that did not pass each
/// other.
enum class Overtaking {
  kStillGo,  ///< The one that stood still: who moves brings its surroundings along.
  kAllGo,
};

/// The triangles to forget so that others fit in at the new positions, for RetriangulateCavity:
/// those that were spoiled, and those at every free vertex that went through a side of them, or
/// that such a side went over, as the straight ways of both show.
///
/// A good guess, no promise: the rim may still cross itself, and a larger cavity be needed.
/// @param spoiled  triangles that are inverted, or too flat to stay
/// @param stop  not owned; null: nobody; else asked: what it returns then is too little
/// @return each once, ascending. @par Cost O(k log k) for k triangles
[[nodiscard]] std::vector<TriangleId> OvertakenCavity(const Mesh& mesh,
                                                      std::vector<TriangleId> spoiled,
                                                      const SuddenMove& move, Overtaking rule,
                                                      const StopSignal* stop = nullptr);

/// The triangles of a cavity and all that share a corner with them; each once, ascending.
[[nodiscard]] std::vector<TriangleId> WithRing(const Mesh& mesh, std::vector<TriangleId> cavity);

}  // namespace pliant
