#include "server/submission.h"

#include <utility>

#include "server/convert_job.h"
#include "server/error_status.h"

namespace pliant::server {

Submission::Submission(const JobServiceContext& context, const grpc::CallbackServerContext& call,
                       v1::SubmitJobResponse* response)
    : context_(context), response_(response), tenant_(context.access->TenantOf(call)) {
  context_.calls->Begin();
  if (tenant_) {
    StartRead(&request_);
  } else {
    Finish(Access::Refusal());
  }
}

void Submission::OnDone() {
  context_.calls->End();
  delete this;
}

void Submission::OnReadDone(bool ok) {
  if (const Status status = ok ? Take(request_) : Begin(); !status.ok()) {
    Finish(ToGrpcStatus(status.error()));
    return;
  }
  if (ok) StartRead(&request_);
}

Status Submission::Take(v1::SubmitJobRequest& request) {
  if (submit_) {
    return Error{ErrorCode::kProtocolOrder, "nothing may follow `submit`", "submit"};
  }
  if (request.has_chunk()) return blobs_.Add(std::move(*request.mutable_chunk()));
  if (!request.has_submit()) {
    return Error{ErrorCode::kProtocolOrder, "the message is neither a chunk nor a submit",
                 "message"};
  }
  submit_ = std::move(*request.mutable_submit());
  return {};
}

Status Submission::Begin() {
  if (!submit_) {
    return Error{ErrorCode::kProtocolOrder, "the stream ended without `submit`", "submit"};
  }
  PLIANT_RETURN_IF_ERROR(blobs_.Resolve(*submit_));
  PLIANT_ASSIGN_OR_RETURN(JobSubmission submission,
                          ConvertSubmit(*submit_, context_.limits, context_.keep));
  submit_.reset();
  submission.draft.key.tenant = *tenant_;
  // This object lives until Finish, which only the answer calls from here on.
  context_.jobs->Submit(submission.draft, std::move(submission.input),
                        [this](const Result<JobInfo>& job) {
                          if (!job.ok()) {
                            Finish(ToGrpcStatus(job.error()));
                            return;
                          }
                          *response_->mutable_job() = ToJob(*job);
                          Finish(grpc::Status::OK);
                        });
  return {};
}

}  // namespace pliant::server
