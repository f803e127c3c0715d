#pragma once

#include <grpcpp/client_context.h>
#include <grpcpp/support/sync_stream.h>

#include "client/cpp/connection.h"
#include "client/cpp/convert.h"
#include "client/cpp/mesh_replica.h"
#include "core/base/result.h"
#include "proto/columns.h"

namespace pliant::client {

/// Receives the chunks and the snapshot of a GetMesh or FetchResult.
template <class Response>
Result<MeshReplica> ReceiveMesh(const Connection& connection, grpc::ClientContext& context,
                                grpc::ClientReader<Response>& reader) {
  wire::ColumnReader columns(kBlobBytesMax);
  MeshReplica replica;
  Response response;
  bool complete = false;
  Status received;
  while (received.ok() && reader.Read(&response)) {
    if (response.has_chunk()) {
      received = columns.Add(response.chunk());
    } else if (response.has_snapshot()) {
      const Result<MeshDiff> snapshot = FromWire(response.snapshot(), columns);
      received = snapshot.ok() ? replica.Reset(*snapshot) : Status(snapshot.error());
      complete = true;
    }
  }
  if (!received.ok()) {
    context.TryCancel();
    static_cast<void>(reader.Finish());  // What was received is the reason, not the cancel.
    return received.error();
  }
  if (const auto status = reader.Finish(); !status.ok()) return CallError(connection, status);
  if (!complete) {
    return Error{.code = ErrorCode::kInternal,
                 .message = "the server ended the download without a mesh"};
  }
  return replica;
}

}  // namespace pliant::client
