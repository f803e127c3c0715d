#include "server/convert_job.h"

#include <google/protobuf/util/time_util.h>

#include <chrono>
#include <cstring>
#include <string>
#include <utility>

#include "core/base/check.h"
#include "server/convert_reply.h"
#include "server/convert_request.h"
#include "server/error_status.h"
#include "server/limits.h"

namespace pliant::server {
namespace {

using google::protobuf::util::TimeUtil;

Bytes ToBytes(const google::protobuf::Message& message) {
  Bytes bytes(message.ByteSizeLong());
  PLIANT_CHECK(message.SerializeToArray(bytes.data(), static_cast<int>(bytes.size())), "bytes",
               bytes.size());
  return bytes;
}

Result<std::chrono::milliseconds> ConvertKeep(std::int64_t keep_ms, const JobKeep& keep) {
  if (keep_ms == 0) return keep.usual;
  if (keep_ms > 0 && keep_ms <= keep.max.count()) return std::chrono::milliseconds(keep_ms);
  return RangeError("keep_ms is " + std::to_string(keep_ms) + "; allowed are 1 to " +
                        std::to_string(keep.max.count()) + ", or 0 for " +
                        std::to_string(keep.usual.count()),
                    "keep_ms");
}

// What is wrong with a job, beside its arrays.
Status CheckSubmit(const v1::SubmitJob& submit) {
  if (!submit.job_id().empty() && !CheckSessionId(submit.job_id()).ok()) {
    return RangeError("a job id has 1 to " + std::to_string(kSessionIdLengthMax) +
                          " characters of A-Z a-z 0-9 _ . -",
                      "job_id");
  }
  if (!submit.input().session_id().empty()) {
    return RangeError("a job makes no session: leave input.session_id out and set job_id",
                      "input.session_id");
  }
  if (submit.input().labels_size() > 0) {
    return RangeError("a job has no labels: leave input.labels out", "input.labels");
  }
  if (submit.advance().has_commit_interval_ms()) {
    return RangeError("a job commits once, at its end: leave advance.commit_interval_ms out",
                      "advance.commit_interval_ms");
  }
  return {};
}

Result<JobInput> ConvertInput(const v1::SubmitJob& submit, const RequestLimits& limits) {
  PLIANT_ASSIGN_OR_RETURN(SessionInput session, ConvertCreate(submit.input(), limits));
  PLIANT_ASSIGN_OR_RETURN(const AdvanceSpec advance, ConvertAdvance(submit.advance()));
  return JobInput{.engine = std::move(session.engine), .advance = advance};
}

google::protobuf::Timestamp ToTimestamp(Clock::WallTime time) {
  return TimeUtil::NanosecondsToTimestamp(
      std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count());
}

v1::JobState ToState(JobState state) {
  switch (state) {
    case JobState::kQueued:
      return v1::JOB_STATE_QUEUED;
    case JobState::kRunning:
      return v1::JOB_STATE_RUNNING;
    case JobState::kDone:
      return v1::JOB_STATE_DONE;
    case JobState::kFailed:
      return v1::JOB_STATE_FAILED;
    case JobState::kCancelled:
      return v1::JOB_STATE_CANCELLED;
  }
  PLIANT_CHECK(false, "state", static_cast<int>(state));
}

}  // namespace

Result<JobSubmission> ConvertSubmit(const v1::SubmitJob& submit, const RequestLimits& limits,
                                    const JobKeep& keep) {
  PLIANT_RETURN_IF_ERROR(CheckSubmit(submit));
  JobSubmission submission;
  PLIANT_ASSIGN_OR_RETURN(submission.draft.keep, ConvertKeep(submit.keep_ms(), keep));
  // Converted for its checks alone: the run converts again, maybe on another day.
  if (const auto input = ConvertInput(submit, limits); !input.ok()) return input.error();
  submission.input = ToBytes(submit);
  submission.draft.key.job_id = submit.job_id();
  submission.draft.priority = submit.priority();
  submission.draft.input_size = submission.input.size();
  return submission;
}

JobCodec WireJobCodec(const RequestLimits& limits) {
  return {.read_input = [limits](std::span<const std::byte> bytes) -> Result<JobInput> {
            v1::SubmitJob submit;
            if (!submit.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
              return CorruptData("job", "its input is not a SubmitJob");
            }
            return ConvertInput(submit, limits);
          },
          .write_result =
              [](const JobResult& result) {
                v1::Job job;
                SessionEvent event{.revision = result.revision, .body = result.advanced};
                *job.mutable_result() = ToEditResponse(event, {}).advanced();
                v1::QualityReport& quality = *job.mutable_quality();
                quality = ToQualityReport(result.quality);
                quality.set_revision(static_cast<std::int64_t>(result.revision));
                quality.set_active_count(result.advanced.progress.active_count);
                *quality.mutable_counts() = ToMeshCounts(result.advanced.summary);
                return ToBytes(job);
              },
          .write_error =
              [](const Error& error) {
                v1::Job job;
                *job.mutable_error() = ToErrorDetail(error);
                return ToBytes(job);
              }};
}

v1::Job ToJob(const JobInfo& info) {
  v1::Job wire;
  if (info.outcome != nullptr) {
    PLIANT_CHECK(wire.ParseFromArray(info.outcome->data(), static_cast<int>(info.outcome->size())),
                 "job", info.key.job_id);
  }
  wire.set_job_id(info.key.job_id);
  wire.set_state(ToState(info.state));
  wire.set_priority(info.priority);
  if (info.progress) {
    v1::Progress& progress = *wire.mutable_progress();
    progress.set_active_count(info.progress->progress.active_count);
    progress.set_visit_count(info.progress->progress.counts.visits);
    progress.set_vertex_count(info.progress->vertex_count);
    progress.set_elapsed_ms(info.progress->elapsed.count());
  }
  *wire.mutable_create_time() = ToTimestamp(info.create_time);
  if (info.end_time) {
    *wire.mutable_end_time() = ToTimestamp(*info.end_time);
    *wire.mutable_expire_time() = ToTimestamp(*info.expire_time());
  }
  return wire;
}

}  // namespace pliant::server
