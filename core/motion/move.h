#pragma once

#include <functional>

#include "core/base/result.h"
#include "core/motion/motion.h"
#include "core/pliant/remesher.h"

namespace pliant {

/// Moves boundaries and nodes of a session's mesh and wakes what that affects; Step and Commit
/// follow as for a metric. A later metric update in the same revision sees the moved mesh.
///
/// Each position that the request names is reached bit for bit, or nothing at all has happened: a
/// refused motion leaves mesh, metric and loop as they were, with what the revision had changed
/// before. Errors: those of MotionPlan::Make; kCrossingSegments if boundaries would meet on the way
/// (the fraction reached in the message, index and other_index = the constrained edges that meet,
/// -1 where it is another one's triangles that are in the way) unless the request says kStop.
/// @par Cost grows with what moves and how far, in wanted lengths; not with the mesh, but for one
///           pass over the constrained edges.
Result<MotionReport> MoveVertices(Remesher& remesher, const MotionRequest& request);

/// The same for tests: `after_sub_step` sees the mesh after each sub-step.
Result<MotionReport> MoveVertices(Remesher& remesher, const MotionRequest& request,
                                  const std::function<void(const Mesh&)>& after_sub_step);

}  // namespace pliant
