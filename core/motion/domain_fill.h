#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "core/base/ids.h"
#include "core/mesh/mesh.h"
#include "core/mesh/mesh_edit.h"
#include "core/motion/domain_match.h"

namespace pliant {

/// What is known of one side of a wall.
struct WallSide {
  enum class Kind : std::uint8_t {
    kOutside,  ///< The new domain is not there.
    kCovered,  ///< A triangle lies there that stays.
    kCavity,   ///< A triangle goes there; what the new domain has instead is not known.
    kRegion,   ///< The new domain is there, and triangles are to be made.
  };
  Kind kind = Kind::kOutside;
  std::int32_t region = 0;  ///< With kRegion.
};

/// An edge that the filling must have.
struct Wall {
  VertexId from;
  VertexId to;
  WallSide left;
  WallSide right;
};

/// What the new domain has around a vertex.
struct StateAround {
  bool known = false;  ///< Not where the vertex lies on an edge of the domain.
  SideState state;
};

/// A part of the plane to be filled, by the walls around it and in it.
struct FillRequest {
  std::vector<VertexId> points;  ///< Ascending: ends of the walls, and what lies between them.
  std::vector<Wall> walls;       ///< No two between the same vertices.
  std::function<StateAround(VertexId)> state_at;
};

/// Triangles that fill it.
struct Filling {
  std::vector<NewTriangle> triangles;
  /// For each wall what the new domain has on its kCavity sides.
  std::vector<EdgeSides> cavities;
};

/// Fills the parts of the plane that walls enclose with a constrained Delaunay triangulation, each
/// with the region that its walls name. Parts that no wall closes off, or that a kOutside or
/// kCovered side bounds, get none.
/// @return nothing if walls cross or run over points, if points coincide, or if the walls around a
///         part do not agree. @par Cost O(n log n) for n points
[[nodiscard]] std::optional<Filling> FillWalls(const Mesh& mesh, const FillRequest& request);

}  // namespace pliant
