#pragma once

#include <grpcpp/grpcpp.h>

#include <atomic>

#include "pliant/v1/job.grpc.pb.h"
#include "server/access.h"
#include "server/call_counter.h"
#include "server/convert.h"
#include "server/convert_job.h"
#include "server/jobs/jobs.h"
#include "server/log.h"

namespace pliant::server {

/// What the calls on jobs use; everything outlives them.
struct JobServiceContext {
  Jobs* jobs = nullptr;
  const Access* access = nullptr;
  CallCounter* calls = nullptr;
  RequestLimits limits;
  JobKeep keep;
};

/// The calls on jobs. None of them computes.
///
/// *Threads*: any; gRPC calls it from several at once.
class JobServiceImpl final : public v1::JobService::CallbackService {
 public:
  explicit JobServiceImpl(JobServiceContext context) : context_(context) {}

  grpc::ServerReadReactor<v1::SubmitJobRequest>* SubmitJob(
      grpc::CallbackServerContext* call, v1::SubmitJobResponse* response) override;
  grpc::ServerUnaryReactor* GetJob(grpc::CallbackServerContext* call,
                                   const v1::GetJobRequest* request,
                                   v1::GetJobResponse* response) override;
  grpc::ServerUnaryReactor* ListJobs(grpc::CallbackServerContext* call,
                                     const v1::ListJobsRequest* request,
                                     v1::ListJobsResponse* response) override;
  grpc::ServerUnaryReactor* CancelJob(grpc::CallbackServerContext* call,
                                      const v1::CancelJobRequest* request,
                                      v1::CancelJobResponse* response) override;
  grpc::ServerWriteReactor<v1::FetchResultResponse>* FetchResult(
      grpc::CallbackServerContext* call, const v1::FetchResultRequest* request) override;

 private:
  const JobServiceContext context_;
  std::atomic<int> downloads_ = 0;
};

}  // namespace pliant::server
