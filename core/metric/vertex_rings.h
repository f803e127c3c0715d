#pragma once

#include <cstdint>
#include <span>

#include "core/geometry/vec2.h"

namespace pliant {

/// What the limits of a metric have to know of a mesh: its vertices by number, and the edges
/// between them.
class VertexRings {
 public:
  virtual ~VertexRings() = default;
  [[nodiscard]] virtual Vec2 position(std::int32_t vertex) const = 0;
  /// The vertices that share an edge with `vertex`, in any order. Valid until the next
  /// call.
  [[nodiscard]] virtual std::span<const std::int32_t> Neighbors(std::int32_t vertex) = 0;
  /// A third of the area of the triangles at `vertex`: its share of the mesh.
  [[nodiscard]] virtual double Area(std::int32_t vertex) = 0;
};

}  // namespace pliant
