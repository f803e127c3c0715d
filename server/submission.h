#pragma once

#include <grpcpp/grpcpp.h>

#include "pliant/v1/job.pb.h"
#include "server/job_service.h"
#include "server/upload.h"

namespace pliant::server {

/// One SubmitJob: takes the upload, checks it and hands it to the jobs.
class Submission final : public Upload<v1::SubmitJobRequest, v1::SubmitJob> {
 public:
  /// @param context, response  outlive the call.
  Submission(const JobServiceContext& context, const grpc::CallbackServerContext& call,
             v1::SubmitJobResponse* response);

 private:
  v1::SubmitJob* LastIn(v1::SubmitJobRequest& request) override;
  Status Begin(v1::SubmitJob submit) override;

  const JobServiceContext& context_;
  v1::SubmitJobResponse* const response_;
};

}  // namespace pliant::server
