#pragma once

#include "client/cpp/job_types.h"
#include "client/cpp/types.h"
#include "core/base/result.h"
#include "core/metric/metric_spec.h"
#include "pliant/v1/job.pb.h"
#include "pliant/v1/session.pb.h"
#include "proto/columns.h"

/// What sessions and jobs start from, and jobs as the wire shows them; rules as in convert.h.
namespace pliant::client {

/// The part of CreateSession that a job has too.
[[nodiscard]] v1::CreateSession InputToWire(const Start& start, const MetricSpec& metric,
                                            const Options& options, wire::ColumnWriter& columns);

/// Without its input.
[[nodiscard]] v1::SubmitJob ToWire(const JobSettings& settings);

[[nodiscard]] Result<JobInfo> FromWire(const v1::Job& job);

}  // namespace pliant::client
