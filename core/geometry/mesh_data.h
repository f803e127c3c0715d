#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/geometry/vec2.h"

namespace pliant {

/// A mesh as plain arrays with dense indices: what files hold, what a client imports and what the
/// compact view of a replica is. No connectivity, no ids, no promise of validity.
struct MeshData {
  std::vector<Vec2> points;
  /// Corners of each triangle as indices into `points`, counter-clockwise.
  std::vector<std::array<std::int32_t, 3>> triangles;
  /// Region tag of each triangle; empty means 0 everywhere.
  std::vector<std::int32_t> triangle_tags;
  /// Ends of each constrained edge as indices into `points`.
  std::vector<std::array<std::int32_t, 2>> edges;
  /// Tag of each constrained edge; empty means 0 everywhere.
  std::vector<std::int32_t> edge_tags;

  friend bool operator==(const MeshData&, const MeshData&) = default;
};

}  // namespace pliant
