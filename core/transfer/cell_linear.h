#pragma once

#include "core/transfer/field.h"
#include "core/transfer/region_locator.h"
#include "core/transfer/touched_region.h"

namespace pliant {

/// New values of a per-triangle field, kLinear or kBounded, at the triangles of region.after.
///
/// A value belongs to its triangle's centroid. Through the old one around the new centroid and its
/// neighbours goes a linear function, by least squares weighted with 1 / distance^2, through the
/// old value itself; its value at the new centroid is the new value, exact for linear functions.
/// Old triangles with fewer than three neighbours ask their neighbours' neighbours as well.
/// kBounded cuts the result to the least and greatest old value among the triangles that share a
/// vertex with the old one [ParkYoonKim2010]: these surround it, so that away from extrema and the
/// boundary a linear function is not cut. Outside of the old domain (a boundary moved) the nearest
/// old triangle answers.
/// @par Cost  O(triangles of the region)
[[nodiscard]] FieldRows TransferCells(const OldMesh& old, const TouchedRegion& region,
                                      const RegionLocator& locator, const Field& field);

}  // namespace pliant
