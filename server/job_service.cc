#include "server/job_service.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "server/convert_reply.h"
#include "server/convert_request.h"
#include "server/download.h"
#include "server/limits.h"
#include "server/submission.h"
#include "server/unary.h"

namespace pliant::server {

grpc::ServerReadReactor<v1::SubmitJobRequest>* JobServiceImpl::SubmitJob(
    grpc::CallbackServerContext* call, v1::SubmitJobResponse* response) {
  return new Submission(context_, *call, response);
}

grpc::ServerUnaryReactor* JobServiceImpl::GetJob(grpc::CallbackServerContext* call,
                                                 const v1::GetJobRequest* request,
                                                 v1::GetJobResponse* response) {
  const std::optional<std::string> tenant = context_.access->TenantOf(*call);
  if (!tenant) return Refuse(call);
  const Result<JobInfo> job = context_.jobs->Get({*tenant, request->job_id()});
  if (!job.ok()) return End(call, job.error());
  *response->mutable_job() = ToJob(*job);
  return End(call, {});
}

grpc::ServerUnaryReactor* JobServiceImpl::ListJobs(grpc::CallbackServerContext* call,
                                                   const v1::ListJobsRequest* request,
                                                   v1::ListJobsResponse* response) {
  const std::optional<std::string> tenant = context_.access->TenantOf(*call);
  if (!tenant) return Refuse(call);
  const Result<std::int64_t> before = ConvertPageToken(request->page_token());
  if (!before.ok()) return End(call, before.error());
  const Result<std::size_t> count_max = ConvertPageSize(request->page_size());
  if (!count_max.ok()) return End(call, count_max.error());
  const JobBoard::Page page = context_.jobs->List(*tenant, *before, *count_max);
  std::size_t size = 0;
  for (const JobInfo& info : page.jobs) {
    v1::Job job = ToJob(info);
    size += job.ByteSizeLong();
    // A page is a message, and thousands of reports do not fit into one.
    if (size > kJobPageBytesMax && response->jobs_size() > 0) {
      response->set_next_page_token(std::to_string(info.number + 1));
      return End(call, {});
    }
    *response->add_jobs() = std::move(job);
  }
  if (page.next != 0) response->set_next_page_token(std::to_string(page.next));
  return End(call, {});
}

grpc::ServerUnaryReactor* JobServiceImpl::CancelJob(grpc::CallbackServerContext* call,
                                                    const v1::CancelJobRequest* request,
                                                    v1::CancelJobResponse* response) {
  const std::optional<std::string> tenant = context_.access->TenantOf(*call);
  if (!tenant) return Refuse(call);
  grpc::ServerUnaryReactor* reactor = call->DefaultReactor();
  context_.jobs->Cancel({*tenant, request->job_id()},
                        [reactor, response](const Result<JobInfo>& job) {
                          if (!job.ok()) {
                            reactor->Finish(ToGrpcStatus(job.error()));
                            return;
                          }
                          *response->mutable_job() = ToJob(*job);
                          reactor->Finish(grpc::Status::OK);
                        });
  return reactor;
}

grpc::ServerWriteReactor<v1::FetchResultResponse>* JobServiceImpl::FetchResult(
    grpc::CallbackServerContext* call, const v1::FetchResultRequest* request) {
  using MeshDownload = Download<v1::FetchResultResponse>;
  const auto begin = [&](MeshDownload* download, const std::string& tenant) -> Status {
    ReplyContext wanted;
    PLIANT_ASSIGN_OR_RETURN(wanted.parts, ConvertParts(request->parts()));
    PLIANT_ASSIGN_OR_RETURN(wanted.numbering, NumberingOf(*request));
    context_.jobs->Fetch(
        {tenant, request->job_id()}, [download, wanted](const Result<MeshDiff>& mesh) {
          if (mesh.ok()) {
            download->Run(InMessages<v1::FetchResultResponse>(ToMeshSnapshot(*mesh, wanted)));
          } else {
            download->Fail(mesh.error());
          }
        });
    return {};
  };
  return OpenDownload<v1::FetchResultResponse>(downloads_, *context_.calls,
                                               context_.access->TenantOf(*call), begin);
}

}  // namespace pliant::server
