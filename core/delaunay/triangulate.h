#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/result.h"
#include "core/base/stop_signal.h"
#include "core/geometry/domain.h"

namespace pliant {

/// The constrained Delaunay triangulation of a domain, as plain arrays.
struct DomainTriangulation {
  struct Triangle {
    std::array<std::int32_t, 3> points;  ///< Counter-clockwise, indices into Domain::points.
    /// Across the side opposite corner i; -1 where there is none.
    std::array<std::int32_t, 3> neighbors;
    /// The segment that is the side opposite corner i; -1 for a side that is no segment.
    std::array<std::int32_t, 3> segments;
    std::int32_t region = 0;  ///< Tag of its region seed, 0 without one.
  };
  std::vector<Triangle> triangles;  ///< Those of the domain only; holes and outside are gone.
};

/// Checks a domain and builds its constrained Delaunay triangulation (no points added).
///
/// Exact predicates throughout: any finite coordinates work. Deterministic: depends only on the
/// domain. Where four points are co-circular, the choice of diagonal depends on point order.
///
/// @return the triangulation, or the first error in the order of the ErrorCode list for domains,
///         with the lowest offending index in `index`, the element it clashes with in
///         `other_index`, and a `field` among "domain.points", "domain.segments", "domain.holes"
///         and "domain.regions". Where nothing is inside, every segment is useless, and the error
///         is kOpenLoop if one of them has a loose end, else kNothingInside.
/// @param stop  not owned; null: nobody; else asked; then kCancelled.
/// @par Cost O(n log n) expected for n points and segments, about 1 s per million. A segment that
///      crosses k edges of the Delaunay triangulation of the points costs k log k typically.
[[nodiscard]] Result<DomainTriangulation> TriangulateDomain(const Domain& domain,
                                                            const StopSignal* stop = nullptr);

}  // namespace pliant
