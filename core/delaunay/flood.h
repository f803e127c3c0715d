#pragma once

#include "core/base/result.h"
#include "core/base/stop_signal.h"
#include "core/delaunay/delaunay.h"
#include "core/delaunay/triangulate.h"
#include "core/geometry/domain.h"

namespace pliant {

/// Separates the domain from outside and holes, tags its regions, and keeps its triangles only.
///
/// @param hull  constrained Delaunay triangulation of the domain's points with all its segments.
/// @param stop  not owned; null: nobody; else asked, between steps; then kCancelled.
/// @return the triangles of the domain in the order of the hull's, or the first of kOpenLoop,
///         kSegmentOutsideDomain, kPointOutsideDomain, kSeedOutsideDomain, kConflictingRegions and
///         kNothingInside. Where nothing is inside, kOpenLoop if there is a loose end, else
///         kNothingInside.
/// @par Cost  O(n), and O(n log n) with seeds.
[[nodiscard]] Result<DomainTriangulation> KeepInside(const Domain& domain, HullTriangulation hull,
                                                     const StopSignal* stop = nullptr);

/// The error for a domain whose points all lie on one line.
/// @pre no segments cross or overlap, and no point lies inside one.
[[nodiscard]] Error NothingInsideError(const Domain& domain);

}  // namespace pliant
