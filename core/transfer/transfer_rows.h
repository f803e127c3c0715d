#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/ids.h"
#include "core/mesh/diff_values.h"
#include "core/transfer/region_locator.h"
#include "core/transfer/touched_region.h"

namespace pliant {

/// Barycentric weights, rounded to multiples of 2^-53 that add up to exactly 1: the largest one is
/// what the others leave. Corners of weight 0 drop out.
/// @param weights  >= 0, sum 1 up to rounding.
[[nodiscard]] TransferRow MakeTransferRow(const std::array<VertexId, 3>& corners,
                                          const std::array<double, 3>& weights);

/// The row of each vertex in `region.moved`: where its new position lies in the old mesh.
///
/// Positions are looked for among the old triangles of the region, because around a touched vertex
/// the old mesh was touched too. A vertex inside a segment that stayed where it was follows the
/// old edges of that segment, by its parameter: boundary values come from the boundary alone.
/// Where a moved boundary takes a vertex out of the old domain, the nearest point of the region's
/// old triangles stands in for it: a point of the old boundary that moved.
/// @param locator  of `region`. @par Cost  a walk of a few triangles a vertex.
[[nodiscard]] TransferRows MakeTransferRows(const OldMesh& old, const TouchedRegion& region,
                                            const RegionLocator& locator);

}  // namespace pliant
