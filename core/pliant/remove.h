#pragma once

#include <cstdint>
#include <optional>

#include "core/delaunay/metric_flip.h"
#include "core/mesh/mesh_edit.h"
#include "core/mesh/star.h"

namespace pliant {

/// Whether the new edges in the hole are swapped by the metric, or left as the ears were cut.
enum class AfterRemoval { kSwapEdges, kLeaveEdges };

/// Deletes the center of a star: cuts the polygon around it into ears and swaps edges inside it by
/// the deleted node's own metric. [BossenHeckbert1996, sec. 3.2 and 4.1]
///
/// A node inside a segment takes its two edges with it and leaves one; the polygons on both sides
/// are triangulated apart, so that regions stay what they are.
/// @return swaps made, or nothing (and the mesh untouched) if some polygon has no triangulation.
/// @pre the center is not fixed and the star is its whole fan
std::optional<std::int32_t> RemoveNode(MeshEdit& edit, MetricFlipper& flipper, const Star& star,
                                       AfterRemoval after = AfterRemoval::kSwapEdges);

}  // namespace pliant
