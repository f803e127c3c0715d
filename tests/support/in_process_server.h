#pragma once

#include <grpcpp/grpcpp.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "pliant/v1/job.grpc.pb.h"
#include "pliant/v1/session.grpc.pb.h"
#include "server/blobs.h"
#include "server/server.h"
#include "tests/support/wire_arrays.h"

/// A real server on a Unix socket of its own, and raw stubs to it: what tests of the protocol talk
/// to. Nothing here knows how the server works inside.
namespace pliant::test {

class InProcessServer {
 public:
  explicit InProcessServer(server::EngineFactory factory = server::RemesherFactory(),
                           server::Config config = {}) {
    std::string pattern = (std::filesystem::temp_directory_path() / "pliant-XXXXXX").string();
    folder_ = mkdtemp(pattern.data());
    config.listen = "unix:" + folder_ + "/socket";
    if (config.workers == 0) config.workers = 2;
    auto started = server::Server::Start(
        config, {.clock = &clock_, .log = &log_, .engine_factory = std::move(factory)});
    server_ = std::move(started).value();
    grpc::ChannelArguments arguments;
    // One connection for each server: addresses in the temporary folder are never used again.
    arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
    channel_ = grpc::CreateCustomChannel(server_->address(), grpc::InsecureChannelCredentials(),
                                         arguments);
    sessions = v1::SessionService::NewStub(channel_);
    info = v1::ServerService::NewStub(channel_);
    jobs = v1::JobService::NewStub(channel_);
  }
  ~InProcessServer() {
    server_ = nullptr;
    std::filesystem::remove_all(folder_);
  }

  /// Creates a session as a client does: large arrays first, in chunks.
  grpc::Status Create(v1::CreateSession create, std::string* session_id) {
    grpc::ClientContext context;
    v1::CreateSessionResponse response;
    const auto writer = sessions->CreateSession(&context, &response);
    std::int64_t last_blob_id = 0;
    for (v1::BlobChunk& chunk : server::TakeLargeArrays(create, last_blob_id)) {
      v1::CreateSessionRequest request;
      *request.mutable_chunk() = std::move(chunk);
      writer->Write(request);
    }
    v1::CreateSessionRequest request;
    *request.mutable_create() = std::move(create);
    writer->Write(request);
    writer->WritesDone();
    const grpc::Status status = writer->Finish();
    if (session_id != nullptr) *session_id = response.session().session_id();
    return status;
  }

  /// Downloads a mesh, its arrays put in place.
  grpc::Status GetMesh(const v1::GetMeshRequest& request, v1::MeshSnapshot* snapshot) {
    grpc::ClientContext context;
    const auto reader = sessions->GetMesh(&context, request);
    server::BlobAssembler blobs;
    v1::GetMeshResponse response;
    while (reader->Read(&response)) {
      if (response.has_chunk()) {
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

  [[nodiscard]] server::Server& server() { return *server_; }
  [[nodiscard]] const std::shared_ptr<grpc::Channel>& channel() const { return channel_; }

 private:
  const server::SystemClock clock_;
  const server::Log log_{server::LogLevel::kError, server::LogFormat::kText};
  std::string folder_;
  std::unique_ptr<server::Server> server_;
  std::shared_ptr<grpc::Channel> channel_;

 public:
  std::unique_ptr<v1::SessionService::Stub> sessions;
  std::unique_ptr<v1::ServerService::Stub> info;
  std::unique_ptr<v1::JobService::Stub> jobs;
};

/// One edit stream, message by message.
class EditClient {
 public:
  EditClient(InProcessServer& server, const std::string& session_id, std::int64_t mirror = 0,
             std::vector<v1::MeshPart> parts = {}) {
    stream_ = server.sessions->Edit(&context_);
    v1::EditRequest request;
    request.mutable_open()->set_session_id(session_id);
    request.mutable_open()->set_mirror_revision(mirror);
    for (const v1::MeshPart part : parts) request.mutable_open()->add_parts(part);
    Send(request);
  }
  /// Without an `open`.
  explicit EditClient(InProcessServer& server) { stream_ = server.sessions->Edit(&context_); }

  bool Send(v1::EditRequest request) {
    for (v1::BlobChunk& chunk : server::TakeLargeArrays(request, last_blob_id_)) {
      v1::EditRequest message;
      *message.mutable_chunk() = std::move(chunk);
      if (!stream_->Write(message)) return false;
    }
    return stream_->Write(request);
  }
  bool Advance(std::int64_t update_id, const v1::Advance& advance = {}) {
    v1::EditRequest request;
    request.set_update_id(update_id);
    *request.mutable_advance() = advance;
    return Send(request);
  }
  bool Size(std::int64_t update_id, const std::string& size) {
    v1::EditRequest request;
    request.set_update_id(update_id);
    request.mutable_metric()->add_sources()->mutable_size()->set_size(size);
    return Send(request);
  }

  /// The next message that is no chunk, its arrays put in place; one without an event at the end.
  v1::EditResponse Next() {
    v1::EditResponse response;
    while (stream_->Read(&response)) {
      if (!response.has_chunk()) {
        if (!blobs_.Resolve(response).ok()) break;
        return response;
      }
      ++chunk_count;
      if (!blobs_.Add(response.chunk()).ok()) break;
    }
    return {};
  }
  /// Everything up to and including the answer to an update.
  std::vector<v1::EditResponse> Until(std::int64_t update_id) {
    std::vector<v1::EditResponse> responses;
    for (;;) {
      responses.push_back(Next());
      const v1::EditResponse& last = responses.back();
      if (last.event_case() == v1::EditResponse::EVENT_NOT_SET) return responses;
      if (last.update_id() == update_id &&
          (last.has_accepted() || last.has_rejected() || last.has_advanced())) {
        return responses;
      }
    }
  }
  /// Half-closes, reads on to the end and returns the status.
  grpc::Status Finish() {
    stream_->WritesDone();
    while (Next().event_case() != v1::EditResponse::EVENT_NOT_SET) {
    }
    return stream_->Finish();
  }
  /// The status of a stream that the server ends.
  grpc::Status End() {
    while (Next().event_case() != v1::EditResponse::EVENT_NOT_SET) {
    }
    return stream_->Finish();
  }
  void Cancel() { context_.TryCancel(); }

  int chunk_count = 0;

 private:
  grpc::ClientContext context_;
  std::unique_ptr<grpc::ClientReaderWriter<v1::EditRequest, v1::EditResponse>> stream_;
  server::BlobAssembler blobs_;
  std::int64_t last_blob_id_ = 0;
};

/// The reason in a status' details; empty if it has none.
inline std::string ReasonOf(const grpc::Status& status) {
  v1::ErrorStatus details;
  v1::ErrorDetail detail;
  if (!details.ParseFromString(status.error_details()) || details.details_size() == 0 ||
      !detail.ParseFromString(details.details(0).value())) {
    return "";
  }
  return detail.reason();
}

}  // namespace pliant::test
