// The calls on jobs; see client.h.
#include <algorithm>
#include <chrono>
#include <functional>
#include <thread>
#include <utility>

#include "client/cpp/backoff.h"
#include "client/cpp/client.h"
#include "client/cpp/connection.h"
#include "client/cpp/convert_job.h"
#include "client/cpp/download.h"

namespace pliant::client {

namespace {

Result<JobInfo> GetJobOnce(const Connection& connection, const std::string& job_id) {
  const auto context = connection.NewContext(connection.options().call_timeout);
  v1::GetJobRequest request;
  request.set_job_id(job_id);
  v1::GetJobResponse response;
  const auto status = connection.jobs().GetJob(context.get(), request, &response);
  if (!status.ok()) return CallError(connection, status);
  return FromWire(response.job());
}

}  // namespace

Result<JobInfo> Client::SubmitJob(const Start& start, const MetricSpec& metric,
                                  const JobSettings& settings) {
  const auto context = connection_->NewContext(connection_->options().transfer_timeout);
  v1::SubmitJobResponse response;
  const auto writer = connection_->jobs().SubmitJob(context.get(), &response);
  // A failed write means that the server has answered already: Finish has the reason.
  wire::ColumnWriter columns([&](v1::BlobChunk chunk) {
    v1::SubmitJobRequest request;
    *request.mutable_chunk() = std::move(chunk);
    writer->Write(request);
  });
  v1::SubmitJobRequest request;
  *request.mutable_submit() = ToWire(settings);
  *request.mutable_submit()->mutable_input() =
      InputToWire(start, metric, settings.options, columns);
  writer->Write(request);
  writer->WritesDone();
  if (const auto status = writer->Finish(); !status.ok()) return CallError(*connection_, status);
  return FromWire(response.job());
}

Result<JobInfo> Client::GetJob(const std::string& job_id) {
  return connection_->Persist([&] { return GetJobOnce(*connection_, job_id); });
}

Result<std::vector<JobInfo>> Client::ListJobs() {
  std::vector<JobInfo> jobs;
  v1::ListJobsRequest request;
  do {
    v1::ListJobsResponse response;
    PLIANT_RETURN_IF_ERROR(connection_->Persist([&]() -> Status {
      const auto context = connection_->NewContext(connection_->options().call_timeout);
      const auto status = connection_->jobs().ListJobs(context.get(), request, &response);
      return status.ok() ? Status() : Status(CallError(*connection_, status));
    }));
    for (const v1::Job& job : response.jobs()) {
      PLIANT_ASSIGN_OR_RETURN(JobInfo info, FromWire(job));
      jobs.push_back(std::move(info));
    }
    request.set_page_token(response.next_page_token());
  } while (!request.page_token().empty());
  return jobs;
}

Result<JobInfo> Client::CancelJob(const std::string& job_id) {
  return connection_->Persist([&]() -> Result<JobInfo> {
    const auto context = connection_->NewContext(connection_->options().call_timeout);
    v1::CancelJobRequest request;
    request.set_job_id(job_id);
    v1::CancelJobResponse response;
    const auto status = connection_->jobs().CancelJob(context.get(), request, &response);
    if (!status.ok()) return CallError(*connection_, status);
    return FromWire(response.job());
  });
}

Result<MeshReplica> Client::FetchResult(const std::string& job_id, Parts parts) {
  return connection_->Persist([&] {
    const auto context = connection_->NewContext(connection_->options().transfer_timeout);
    v1::FetchResultRequest request;
    request.set_job_id(job_id);
    if (parts != Parts::kMesh) request.add_parts(v1::MESH_PART_METRIC);
    return ReceiveMesh(*connection_, *context,
                       *connection_->jobs().FetchResult(context.get(), request));
  });
}

Result<JobInfo> Client::WaitForJob(const std::string& job_id, const JobWait& wait) {
  using std::chrono::steady_clock;
  const steady_clock::time_point begin = steady_clock::now();
  steady_clock::time_point last_answer = begin;
  Backoff backoff(/*seed=*/std::hash<std::string>()(job_id));
  for (;;) {
    Result<JobInfo> job = GetJobOnce(*connection_, job_id);
    const steady_clock::time_point now = steady_clock::now();
    if (job.ok()) {
      last_answer = now;
      if (HasEnded(job->state)) return job;
      if (wait.on_look && !wait.on_look(*job)) {
        return Error{.code = ErrorCode::kCancelled,
                     .message = "no longer waits for job " + job_id + ", which goes on"};
      }
    } else if (job.error().code != ErrorCode::kUnavailable ||
               now - last_answer >= wait.reconnect_max) {
      return job;
    }
    if (wait.time_max && now - begin >= *wait.time_max) {
      return Error{.code = ErrorCode::kDeadlineExceeded,
                   .message = "job " + job_id + " has not ended in " +
                              std::to_string(wait.time_max->count()) + " ms; it goes on"};
    }
    steady_clock::duration pause = backoff.Next();
    if (wait.time_max) pause = std::min(pause, begin + *wait.time_max - now);
    std::this_thread::sleep_for(pause);
  }
}

}  // namespace pliant::client
