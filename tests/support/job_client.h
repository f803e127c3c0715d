#pragma once

#include <chrono>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "tests/support/in_process_server.h"

/// The calls on jobs, as a raw client of the wire makes them.
namespace pliant::test {

class JobClient {
 public:
  /// @param token  empty: none.
  explicit JobClient(InProcessServer& server, std::string token = "")
      : server_(server), token_(std::move(token)) {}

  /// Large arrays first, in chunks. The job in `job`, if it is not null.
  grpc::Status Submit(v1::SubmitJob submit, v1::Job* job = nullptr) {
    std::vector<v1::SubmitJobRequest> requests;
    std::int64_t last_blob_id = 0;
    for (v1::BlobChunk& chunk : server::TakeLargeArrays(submit, last_blob_id)) {
      *requests.emplace_back().mutable_chunk() = std::move(chunk);
    }
    *requests.emplace_back().mutable_submit() = std::move(submit);
    return Upload(requests, job);
  }
  grpc::Status Upload(const std::vector<v1::SubmitJobRequest>& requests, v1::Job* job = nullptr) {
    grpc::ClientContext context;
    Authorize(context);
    v1::SubmitJobResponse response;
    const auto writer = server_.jobs->SubmitJob(&context, &response);
    for (const v1::SubmitJobRequest& request : requests) writer->Write(request);
    writer->WritesDone();
    grpc::Status status = writer->Finish();
    if (job != nullptr) *job = response.job();
    return status;
  }
  grpc::Status Get(const std::string& id, v1::Job* job) {
    grpc::ClientContext context;
    Authorize(context);
    v1::GetJobRequest request;
    request.set_job_id(id);
    v1::GetJobResponse response;
    grpc::Status status = server_.jobs->GetJob(&context, request, &response);
    *job = response.job();
    return status;
  }
  grpc::Status Cancel(const std::string& id, v1::Job* job) {
    grpc::ClientContext context;
    Authorize(context);
    v1::CancelJobRequest request;
    request.set_job_id(id);
    v1::CancelJobResponse response;
    grpc::Status status = server_.jobs->CancelJob(&context, request, &response);
    *job = response.job();
    return status;
  }
  grpc::Status List(const v1::ListJobsRequest& request, v1::ListJobsResponse* response) {
    grpc::ClientContext context;
    Authorize(context);
    return server_.jobs->ListJobs(&context, request, response);
  }
  /// The mesh, its arrays put in place.
  grpc::Status Fetch(const v1::FetchResultRequest& request, v1::MeshSnapshot* snapshot) {
    grpc::ClientContext context;
    Authorize(context);
    const auto reader = server_.jobs->FetchResult(&context, request);
    server::BlobAssembler blobs;
    v1::FetchResultResponse response;
    while (reader->Read(&response)) {
      if (response.has_chunk()) {
        ++chunk_count;
        if (!blobs.Add(response.chunk()).ok()) break;
      } else {
        *snapshot = response.snapshot();
      }
    }
    if (!blobs.Resolve(*snapshot).ok()) {
      return grpc::Status(grpc::StatusCode::DATA_LOSS, "a blob is missing");
    }
    return reader->Finish();
  }
  grpc::Status Fetch(const std::string& id, v1::MeshSnapshot* snapshot) {
    v1::FetchResultRequest request;
    request.set_job_id(id);
    return Fetch(request, snapshot);
  }

  /// Asks until the job has ended.
  v1::Job Wait(const std::string& id) {
    v1::Job job;
    while (Get(id, &job).ok() && job.state() <= v1::JOB_STATE_RUNNING) {
      std::this_thread::yield();
    }
    return job;
  }
  /// Asks until the job runs and has worked.
  v1::Job WaitUntilItWorks(const std::string& id) {
    v1::Job job;
    while (Get(id, &job).ok() && job.state() <= v1::JOB_STATE_RUNNING &&
           job.progress().visit_count() == 0) {
      std::this_thread::yield();
    }
    return job;
  }

  int chunk_count = 0;

 private:
  void Authorize(grpc::ClientContext& context) const {
    if (!token_.empty()) context.AddMetadata("authorization", "Bearer " + token_);
  }

  InProcessServer& server_;
  const std::string token_;
};

/// A job that meshes the unit square.
inline v1::SubmitJob SquareJob(const std::string& id, const std::string& size = "0.2") {
  v1::SubmitJob submit;
  submit.set_job_id(id);
  *submit.mutable_input() = UnitSquare(size);
  return submit;
}

}  // namespace pliant::test
