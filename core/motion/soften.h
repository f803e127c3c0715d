#pragma once

#include <cstdint>

#include "core/base/result.h"
#include "core/pliant/remesher.h"

namespace pliant {

/// What SoftenBoundary did.
struct SoftenReport {
  std::int64_t softened_count = 0;  ///< Corners that are vertices like others of a segment now.
};

/// Takes corners of the boundary and of internal constraints back that the metric does not need:
/// they move onto the straight line between two others, which becomes one segment, along which the
/// loop then slides, deletes and inserts vertices as on any other. Without it every node of a side
/// that a solver has moved by itself stays for ever, and a body that was stretched once keeps the
/// nodes of that moment on its boundary.
///
/// To be called once after the updates of a revision and before its first Step, but not after
/// ReplaceDomain: points of another domain are to be found where they were sent. Does nothing
/// unless Options::boundary_tolerance is above 0, nothing before the first commit, and nothing
/// while a permission is missing. Looked at are the given vertices that have changed since the last
/// commit: they moved, or their metric did. A corner at which exactly two segments of one tag meet
/// may go if it is not frozen; it is moved by at most the tolerance. Where a stretch of segments
/// asks for fewer edges than it has segments (core/motion/chords.h), its corners go, unless a
/// boundary would be met on the way. One call moves no point of the boundary farther than the
/// tolerance, while every call may do so again.
///
/// Errors: kExpressionValue if the metric has no value at a place; the caller should then Rollback.
/// What cannot be done without a fault, or is stopped (Remesher::ListenTo), is left as it is.
/// @par Cost O(changed); if something goes also one pass over the constrained edges, as a motion.
Result<SoftenReport> SoftenBoundary(Remesher& remesher);

}  // namespace pliant
