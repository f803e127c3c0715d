#pragma once

#include "core/base/result.h"
#include "core/mesh/diff_values.h"
#include "pliant/v1/mesh.pb.h"
#include "pliant/v1/metric.pb.h"
#include "pliant/v1/motion.pb.h"
#include "server/session_messages.h"

/// Fields and transfer rows between the wire and the core; rules as in convert.h.
namespace pliant::server {

/// Names, ids against the mesh and counts are the core's to check. Errors: those of arrays,
/// kOutOfRange for unknown enums, kTooLarge.
[[nodiscard]] Result<FieldsUpdate> ConvertFields(const v1::FieldUpdate& wire);

/// Errors: as ConvertFields; kEmpty without a field or a target.
[[nodiscard]] Result<SolutionRequest> ConvertSolution(const v1::SolutionMetric& wire);

void WriteTransferRows(const TransferRows& rows, v1::TransferRows& wire);
void WriteFields(const std::vector<FieldChange>& fields,
                 google::protobuf::RepeatedPtrField<v1::FieldValues>& wire);

}  // namespace pliant::server
