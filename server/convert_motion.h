#pragma once

#include "core/base/result.h"
#include "pliant/v1/motion.pb.h"
#include "server/session_messages.h"

/// Motions from the wire to the core, as in convert.h. Revisions, ids and values are checked by the
/// engine.
namespace pliant::server {

/// Errors: those of arrays, kArrayLength, kTooLarge, kEmpty, kOutOfRange.
[[nodiscard]] Result<MotionUpdate> ConvertBoundaryUpdate(const v1::BoundaryUpdate& update);

/// Errors: those of arrays, kArrayLength, kEmpty, kOutOfRange.
[[nodiscard]] Result<MotionUpdate> ConvertNodeUpdate(const v1::NodeUpdate& update);

}  // namespace pliant::server
