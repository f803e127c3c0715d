#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "core/mesh/mesh_diff.h"
#include "pliant/v1/session.grpc.pb.h"
#include "proto/columns.h"
#include "tests/client/loopback_server.h"

namespace pliant::client {

using SubscribeWriter = grpc::ServerWriter<v1::SubscribeResponse>;
using EditStream = grpc::ServerReaderWriter<v1::EditResponse, v1::EditRequest>;

/// The columns of a diff or snapshot, under the names that both messages share.
template <class Message>
void WriteElements(const MeshDiff& diff, wire::ColumnWriter& columns, Message& message) {
  const auto write = [&]<class Scalar, std::size_t kColumns, class Row>(
                         Scalar, std::integral_constant<std::size_t, kColumns>,
                         const std::vector<Row>& rows) {
    return columns.Write<Scalar, kColumns, Row>(rows);
  };
  constexpr std::integral_constant<std::size_t, 1> kOne;
  constexpr std::integral_constant<std::size_t, 2> kTwo;
  constexpr std::integral_constant<std::size_t, 3> kThree;
  *message.mutable_vertex_ids() = write(std::int32_t{}, kOne, diff.vertex_ids);
  *message.mutable_vertex_positions() = write(double{}, kTwo, diff.vertex_positions);
  *message.mutable_triangle_ids() = write(std::int32_t{}, kOne, diff.triangle_ids);
  *message.mutable_triangle_vertices() = write(std::int32_t{}, kThree, diff.triangle_vertices);
  *message.mutable_triangle_tags() = write(std::int32_t{}, kOne, diff.triangle_regions);
  *message.mutable_edge_ids() = write(std::int32_t{}, kOne, diff.edge_ids);
  *message.mutable_edge_vertices() = write(std::int32_t{}, kTwo, diff.edge_vertices);
  *message.mutable_edge_tags() = write(std::int32_t{}, kOne, diff.edge_tags);
  *message.mutable_metric()->mutable_vertex_ids() =
      write(std::int32_t{}, kOne, diff.metric_vertex_ids);
  *message.mutable_metric()->mutable_tensors() = write(double{}, kThree, diff.metrics);
  if constexpr (std::is_same_v<Message, v1::MeshDiff>) {
    message.set_base_revision(static_cast<std::int64_t>(diff.base_revision));
    *message.mutable_removed_vertices() = write(std::int32_t{}, kOne, diff.removed_vertices);
    *message.mutable_removed_triangles() = write(std::int32_t{}, kOne, diff.removed_triangles);
    *message.mutable_removed_edges() = write(std::int32_t{}, kOne, diff.removed_edges);
  } else {
    message.set_numbering(v1::NUMBERING_STABLE);
  }
  message.set_revision(static_cast<std::int64_t>(diff.revision));
  message.mutable_counts()->set_vertex_count(diff.summary.vertex_count);
  message.mutable_counts()->set_triangle_count(diff.summary.triangle_count);
  message.mutable_counts()->set_edge_count(diff.summary.edge_count);
  message.set_state_hash(diff.summary.state_hash);
}

/// The server's end of one edit stream, as far as a test wants to play it.
class EditScript {
 public:
  explicit EditScript(EditStream* stream) : stream_(stream) {}

  /// The next request; an empty one when the client is gone.
  v1::EditRequest Next() {
    v1::EditRequest request;
    if (!stream_->Read(&request)) request.Clear();
    return request;
  }
  void Send(v1::EditResponse response, const v1::EditRequest& answered = {}) {
    response.set_update_id(answered.update_id());
    stream_->Write(response);
  }
  /// Reads `open` and answers it; returns the request.
  v1::EditRequest Open(Revision revision, std::int64_t last_update_id = 0,
                       std::int32_t staged_count = 0) {
    const v1::EditRequest request = Next();
    v1::EditResponse response;
    response.set_revision(static_cast<std::int64_t>(revision));
    response.mutable_opened()->set_last_update_id(last_update_id);
    response.mutable_opened()->set_staged_count(staged_count);
    Send(std::move(response));
    return request;
  }
  void Accept(const v1::EditRequest& request) {
    v1::EditResponse response;
    response.mutable_accepted()->set_staged_count(1);
    Send(std::move(response), request);
  }
  void Reject(const v1::EditRequest& request, const v1::ErrorDetail& error) {
    v1::EditResponse response;
    *response.mutable_rejected()->mutable_error() = error;
    Send(std::move(response), request);
  }
  void SendDiff(const MeshDiff& diff) {
    v1::EditResponse response;
    WriteElements(diff, columns_, *response.mutable_diff());
    Send(std::move(response));
  }
  void SendSnapshot(const MeshDiff& snapshot) {
    v1::EditResponse response;
    WriteElements(snapshot, columns_, *response.mutable_snapshot());
    Send(std::move(response));
  }
  void Advanced(const v1::EditRequest& request, const MeshDiff& diff,
                v1::StopReason reason = v1::STOP_REASON_CONVERGED) {
    v1::EditResponse response;
    response.mutable_advanced()->set_base_revision(static_cast<std::int64_t>(diff.base_revision));
    response.mutable_advanced()->set_revision(static_cast<std::int64_t>(diff.revision));
    response.mutable_advanced()->set_stop_reason(reason);
    response.mutable_advanced()->set_visit_count(10);
    Send(std::move(response), request);
  }

 private:
  EditStream* stream_;
  wire::ColumnWriter columns_{[this](v1::BlobChunk chunk) {
    v1::EditResponse response;
    *response.mutable_chunk() = std::move(chunk);
    stream_->Write(response);
  }};
};

/// A server in this process that does what a test says, mistakes included.
class FakeServer : public v1::SessionService::Service, public v1::ServerService::Service {
 public:
  void Stop() { server_.Stop(); }
  [[nodiscard]] const std::string& address() const { return server_.address(); }

  /// Plays each edit stream; the number of the stream counts from 1.
  std::function<grpc::Status(EditScript&, int)> on_edit;
  std::function<grpc::Status(const v1::GetMeshRequest&, grpc::ServerWriter<v1::GetMeshResponse>*)>
      on_get_mesh;
  std::function<grpc::Status(const v1::ListSessionsRequest&, v1::ListSessionsResponse*)> on_list;
  std::function<grpc::Status(const v1::SubscribeRequest&, SubscribeWriter*)> on_subscribe;
  grpc::Status create_status;
  v1::CreateSession created;  ///< What the last CreateSession said.
  std::int64_t created_chunk_count = 0;

 private:
  grpc::Status GetServerInfo(grpc::ServerContext*, const v1::GetServerInfoRequest*,
                             v1::GetServerInfoResponse* response) override {
    response->set_version("9.8.7");
    (*response->mutable_limits())["sessions"] = 5;
    return grpc::Status::OK;
  }
  grpc::Status CreateSession(grpc::ServerContext*,
                             grpc::ServerReader<v1::CreateSessionRequest>* reader,
                             v1::CreateSessionResponse* response) override {
    v1::CreateSessionRequest request;
    while (reader->Read(&request)) {
      if (request.has_chunk()) ++created_chunk_count;
      if (request.has_create()) created = request.create();
    }
    response->mutable_session()->set_session_id("s1");
    return create_status;
  }
  grpc::Status Edit(grpc::ServerContext*, EditStream* stream) override {
    EditScript script(stream);
    return on_edit(script, ++edit_count_);
  }
  grpc::Status GetMesh(grpc::ServerContext*, const v1::GetMeshRequest* request,
                       grpc::ServerWriter<v1::GetMeshResponse>* writer) override {
    return on_get_mesh(*request, writer);
  }
  grpc::Status Subscribe(grpc::ServerContext*, const v1::SubscribeRequest* request,
                         SubscribeWriter* writer) override {
    return on_subscribe(*request, writer);
  }
  grpc::Status ListSessions(grpc::ServerContext*, const v1::ListSessionsRequest* request,
                            v1::ListSessionsResponse* response) override {
    return on_list(*request, response);
  }

  int edit_count_ = 0;
  LoopbackServer server_{static_cast<v1::SessionService::Service*>(this),
                         static_cast<v1::ServerService::Service*>(this)};
};

}  // namespace pliant::client
