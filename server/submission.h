#pragma once

#include <grpcpp/grpcpp.h>

#include <optional>
#include <string>

#include "pliant/v1/job.pb.h"
#include "server/blobs.h"
#include "server/job_service.h"

namespace pliant::server {

/// One SubmitJob: takes the upload, checks it and hands it to the jobs.
///
/// *Threads*: gRPC's callbacks follow each other; the answer of the jobs comes after the last of
/// them that touches anything.
class Submission final : public grpc::ServerReadReactor<v1::SubmitJobRequest> {
 public:
  /// @param context, response  outlive the call. gRPC owns the result.
  Submission(const JobServiceContext& context, const grpc::CallbackServerContext& call,
             v1::SubmitJobResponse* response);

  void OnReadDone(bool ok) override;
  void OnDone() override;

 private:
  Status Take(v1::SubmitJobRequest& request);
  Status Begin();

  const JobServiceContext& context_;
  v1::SubmitJobResponse* const response_;
  const std::optional<std::string> tenant_;  // Of the caller; nothing: refused.
  v1::SubmitJobRequest request_;
  BlobAssembler blobs_;
  std::optional<v1::SubmitJob> submit_;
};

}  // namespace pliant::server
