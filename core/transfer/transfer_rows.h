#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/ids.h"
#include "core/transfer/region_locator.h"
#include "core/transfer/touched_region.h"

namespace pliant {

/// How the value at one vertex follows from values at old ones.
struct TransferRow {
  std::array<VertexId, 3> sources;  ///< Old slots, ascending; none for an unused entry, at the end.
  /// Whole multiples of 2^-53, >= 0; 0 for an unused entry. So they add up to 1 exactly: as real
  /// numbers, and in floating point in whatever order.
  std::array<double, 3> weights{};

  friend bool operator==(const TransferRow&, const TransferRow&) = default;
};

/// A sparse matrix from nodal values of one revision to those of the next.
struct TransferRows {
  std::vector<VertexId> vertex_ids;  ///< New and moved vertices, ascending.
  std::vector<TransferRow> rows;     ///< One for each.
};

/// The value that a row gives: v0 + (w1 (v1 - v0) + w2 (v2 - v0)), which for weights that add up
/// to 1 is the weighted sum, and for three equal values that value to the bit.
/// @param value  called with an old slot, returns the value there.
template <class Value>
[[nodiscard]] double ApplyRow(const TransferRow& row, Value value) {
  const double first = value(row.sources[0]);
  if (!row.sources[1].valid()) return first;
  double change = row.weights[1] * (value(row.sources[1]) - first);
  if (row.sources[2].valid()) change += row.weights[2] * (value(row.sources[2]) - first);
  return first + change;
}

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
