#include "server/submission.h"

#include <utility>

#include "server/convert_job.h"
#include "server/error_status.h"

namespace pliant::server {

Submission::Submission(const JobServiceContext& context, const grpc::CallbackServerContext& call,
                       v1::SubmitJobResponse* response)
    : Upload(context.access->TenantOf(call), *context.calls, "submit"),
      context_(context),
      response_(response) {
  Start();
}

v1::SubmitJob* Submission::LastIn(v1::SubmitJobRequest& request) {
  return request.has_submit() ? request.mutable_submit() : nullptr;
}

Status Submission::Begin(v1::SubmitJob submit) {
  PLIANT_ASSIGN_OR_RETURN(JobSubmission submission,
                          ConvertSubmit(submit, context_.limits, context_.keep));
  submission.draft.key.tenant = tenant();
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
