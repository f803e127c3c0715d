#pragma once

#include "core/base/bytes.h"
#include "core/base/result.h"
#include "pliant/v1/job.pb.h"
#include "server/convert.h"
#include "server/jobs/job.h"
#include "server/jobs/job_codec.h"

/// Jobs between the wire and the core; rules as in convert.h. Inputs and outcomes are kept as
/// messages of the wire, which know how to be read by a later server.
namespace pliant::server {

/// A submission, checked.
struct JobSubmission {
  JobDraft draft;  ///< Without tenant.
  Bytes input;
};

/// How long an ended job is kept: if nobody says, and at most.
struct JobKeep {
  std::chrono::milliseconds usual{0};
  std::chrono::milliseconds max{0};
};

/// Errors: those of ConvertCreate and ConvertAdvance, with the same fields; kOutOfRange. How the
/// arrays fit together shows when the job runs.
[[nodiscard]] Result<JobSubmission> ConvertSubmit(const v1::SubmitJob& submit,
                                                  const RequestLimits& limits, const JobKeep& keep);

/// The codec that reads what ConvertSubmit has written.
[[nodiscard]] JobCodec WireJobCodec(const RequestLimits& limits);

/// @pre its outcome, if any, is the codec's.
[[nodiscard]] v1::Job ToJob(const JobInfo& info);

}  // namespace pliant::server
