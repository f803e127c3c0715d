#pragma once

#include "core/base/result.h"
#include "pliant/v1/metric.pb.h"
#include "pliant/v1/motion.pb.h"
#include "server/session_messages.h"

/// Motions from the wire to the core, as in convert.h. Revisions, ids and values are checked by the
/// engine.
namespace pliant::server {

/// Errors: those of arrays, kArrayLength, kTooLarge, kEmpty, kOutOfRange.
[[nodiscard]] Result<MotionUpdate> ConvertBoundaryUpdate(const v1::BoundaryUpdate& update);

/// Errors: those of arrays, kArrayLength, kEmpty, kOutOfRange.
[[nodiscard]] Result<MotionUpdate> ConvertNodeUpdate(const v1::NodeUpdate& update);

/// Errors: those of ConvertDomain.
[[nodiscard]] Result<DomainUpdate> ConvertDomainUpdate(const v1::DomainUpdate& update);

/// Errors: those of arrays, kArrayLength.
[[nodiscard]] Result<DisplacementUpdate> ConvertDisplacement(
    const v1::MetricDisplacement& displacement);

}  // namespace pliant::server
