#pragma once

#include <variant>

#include "core/base/result.h"
#include "core/geometry/domain.h"
#include "core/geometry/mesh_data.h"
#include "core/metric/metric_spec.h"
#include "pliant/v1/edit.pb.h"
#include "pliant/v1/metric.pb.h"
#include "pliant/v1/session.pb.h"
#include "server/session_messages.h"

namespace pliant::server {

/// The metric that a session begins with. Tensors at vertices are a background mesh then: the mesh
/// that the session starts from. Errors: those of arrays, kEmpty, kTooLarge, kUnimplemented;
/// kProtocolOrder for values at vertices that there are none of yet.
[[nodiscard]] Result<MetricSpec> ConvertFirstMetric(const v1::CreateSession& create,
                                                    const std::variant<Domain, MeshData>& start);

/// The metric's part of an update. Tensors and expressions are checked by the engine, revisions by
/// the session. Errors: those of arrays, kEmpty, kTooLarge, kUnimplemented.
[[nodiscard]] Result<MetricUpdate> ConvertMetricUpdate(const v1::MetricUpdate& update);

}  // namespace pliant::server
