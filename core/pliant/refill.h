#pragma once

#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/base/ids.h"
#include "core/geometry/vec2.h"
#include "core/mesh/mesh_edit.h"

namespace pliant {

/// The gap that vertices left behind when they were put elsewhere.
struct Gap {
  std::span<const TriangleId> triangles;  ///< Between who moved and who did not, each once.
  /// Where a vertex was; nothing if it did not move. Asked of vertices of before only.
  std::function<std::optional<Vec2>(VertexId)> before;
  std::size_t count_max = 0;  ///< New vertices, at most.
};

/// A new vertex, and whose tensors its own is made of: the logarithm is the sum of theirs, each
/// times its share; the shares sum up to 1. The corners may be new themselves.
struct GapVertex {
  VertexId vertex;
  std::array<VertexId, 3> corners;
  std::array<double, 3> shares;
};

/// Puts new vertices into a gap where vertices were before they moved: those fit those that have
/// stayed. The loop alone would split one long edge after the other, which takes a dozen visits for
/// each new vertex. New ones have tensors between those of the corners around them.
/// @return the new vertices in the order in which they were made, none where the gap is narrow
/// @par Cost O(k log k) for k triangles and who was between them
[[nodiscard]] std::vector<GapVertex> RefillGap(MeshEdit& edit, const Gap& gap);

}  // namespace pliant
