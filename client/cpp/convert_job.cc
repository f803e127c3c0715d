#include "client/cpp/convert_job.h"

#include <variant>

#include "client/cpp/convert.h"
#include "client/cpp/grpc_error.h"

namespace pliant::client {
namespace {

Result<JobState> StateFrom(v1::JobState state) {
  switch (state) {
    case v1::JOB_STATE_QUEUED:
      return JobState::kQueued;
    case v1::JOB_STATE_RUNNING:
      return JobState::kRunning;
    case v1::JOB_STATE_DONE:
      return JobState::kDone;
    case v1::JOB_STATE_FAILED:
      return JobState::kFailed;
    case v1::JOB_STATE_CANCELLED:
      return JobState::kCancelled;
    default:
      return Error{.code = ErrorCode::kInternal,
                   .message = "the server sent a job in a state that this client does not know",
                   .field = "job.state"};
  }
}

}  // namespace

v1::CreateSession InputToWire(const Start& start, const MetricSpec& metric, const Options& options,
                              wire::ColumnWriter& columns) {
  v1::CreateSession input;
  if (const auto* domain = std::get_if<Domain>(&start)) {
    *input.mutable_domain() = ToWire(*domain, columns);
  } else {
    *input.mutable_mesh() = ToWire(std::get<MeshData>(start), columns);
  }
  *input.mutable_metric() = ToWire(metric, columns);
  *input.mutable_options() = ToWire(options);
  return input;
}

v1::SubmitJob ToWire(const JobSettings& settings) {
  v1::SubmitJob submit;
  submit.set_job_id(settings.job_id);
  *submit.mutable_advance() = ToWire(settings.advance);
  submit.set_priority(settings.priority);
  submit.set_keep_ms(settings.keep.count());
  return submit;
}

Result<JobInfo> FromWire(const v1::Job& job) {
  JobInfo info;
  info.job_id = job.job_id();
  PLIANT_ASSIGN_OR_RETURN(info.state, StateFrom(job.state()));
  info.priority = job.priority();
  if (job.has_progress()) info.progress = FromWire(job.progress());
  if (job.has_result()) info.report = FromWire(job.result());
  if (job.has_quality()) {
    PLIANT_ASSIGN_OR_RETURN(info.quality, FromWire(job.quality()));
  }
  if (job.has_error()) info.error = ErrorFromDetail(job.error());
  info.create_time = FromWire(job.create_time());
  if (job.has_end_time()) info.end_time = FromWire(job.end_time());
  if (job.has_expire_time()) info.expire_time = FromWire(job.expire_time());
  return info;
}

}  // namespace pliant::client
