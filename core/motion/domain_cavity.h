#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/ids.h"
#include "core/geometry/vec2.h"
#include "core/mesh/mesh.h"
#include "core/transfer/slot_map.h"

namespace pliant {

/// A straight piece of a new domain that is to become an edge, or a point of it (a == b).
struct DomainPiece {
  Vec2 a;
  Vec2 b;
  std::int32_t group = 0;  ///< Pieces of one group hang together.
};

/// What is to be triangulated anew.
struct CavityRequest {
  std::vector<DomainPiece> pieces;
  /// Vertices all of whose triangles are.
  std::vector<VertexId> stars;
  /// Groups with a vertex among `stars`.
  std::vector<bool> anchored;
};

/// Triangles of a mesh, in the order in which they were found.
struct TriangleSet {
  std::vector<TriangleId> triangles;
  SlotMap places;
  bool met_frozen = false;  ///< A triangle was left out because a constraint keeps it.

  [[nodiscard]] bool Has(TriangleId id) const { return places.Find(id.value()) >= 0; }
  /// @return false if it was there already
  bool Add(TriangleId id) {
    const std::int32_t count = places.count();
    if (places.Add(id.value()) != count) return false;
    triangles.push_back(id);
    return true;
  }
};

/// The triangles around the stars, and all that have a point in common with a piece, borders
/// included. Exact. Frozen ones are left out.
/// @par Cost O(k log k) for k triangles found, one pass over the constrained edges, and, for each
///           group that touches no constrained edge and has no star, one more and the triangles on
///           the way to it from the nearest one.
[[nodiscard]] TriangleSet GatherCavity(const Mesh& mesh, const CavityRequest& request);

}  // namespace pliant
