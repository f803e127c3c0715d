#pragma once

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

/// Puts new vertices into a gap where vertices were before they moved: those fit those that have
/// stayed. The loop alone would split one long edge after the other, which takes a dozen visits for
/// each new vertex. New ones have tensors between those of the corners around them.
/// @return the new vertices, ascending, none where the gap is narrow
/// @par Cost O(k log k) for k triangles and who was between them
[[nodiscard]] std::vector<VertexId> RefillGap(MeshEdit& edit, const Gap& gap);

}  // namespace pliant
