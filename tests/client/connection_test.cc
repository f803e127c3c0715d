#include "client/cpp/connection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/client/fake_server.h"
#include "tests/client/model_mesh.h"

namespace pliant::client {
namespace {

using std::chrono::milliseconds;
using testing::HasSubstr;

TEST(Connection, NobodyThereIsUnavailableAtOnceWithTheAddress) {
  FakeServer server;
  server.Stop();
  Connection connection(server.address(), {.connect_timeout = std::chrono::minutes(10)});
  const Status status = connection.Handshake();
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(status.error().message, HasSubstr(server.address()));
}

TEST(Connection, AServerOfAnotherKindIsNamed) {
  grpc::ServerBuilder builder;
  int port = 0;
  builder.AddListeningPort("127.0.0.1:0", grpc::InsecureServerCredentials(), &port);
  struct Other : v1::SessionService::Service {
  } other;
  builder.RegisterService(&other);
  const auto server = builder.BuildAndStart();
  Connection connection("127.0.0.1:" + std::to_string(port), {});
  const Status status = connection.Handshake();
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kUnimplemented);
  EXPECT_THAT(status.error().message, HasSubstr("pliantd"));
}

/// A mesh of 40,000 vertices: its positions take two chunks.
ModelMesh Large() {
  ModelMesh model;
  model.revision = Revision{4};
  for (std::int32_t i = 0; i < 40'000; ++i) model.vertices[VertexId(i)] = {0.5 * i, 0};
  return model;
}

v1::GetMeshResponse ChunkResponse(v1::BlobChunk chunk) {
  v1::GetMeshResponse response;
  *response.mutable_chunk() = std::move(chunk);
  return response;
}

TEST(Connection, GetMeshPutsChunksTogether) {
  const ModelMesh model = Large();
  FakeServer server;
  bool wants_metric = false;
  server.on_get_mesh = [&](const v1::GetMeshRequest& request,
                           grpc::ServerWriter<v1::GetMeshResponse>* writer) {
    wants_metric = request.parts_size() == 1 && request.parts(0) == v1::MESH_PART_METRIC;
    wire::ColumnWriter columns(
        [&](v1::BlobChunk chunk) { writer->Write(ChunkResponse(std::move(chunk))); });
    v1::GetMeshResponse response;
    WriteElements(DiffOf({}, model), columns, *response.mutable_snapshot());
    writer->Write(response);
    return grpc::Status::OK;
  };
  Connection connection(server.address(), {});
  const auto replica = connection.GetMesh("s1", Parts::kMeshAndMetric);
  ASSERT_TRUE(replica.ok()) << replica.error().message;
  ExpectSame(*replica, model);
  EXPECT_TRUE(wants_metric);
}

TEST(Connection, ADownloadWithAGapIsRefused) {
  FakeServer server;
  server.on_get_mesh = [&](const v1::GetMeshRequest&,
                           grpc::ServerWriter<v1::GetMeshResponse>* writer) {
    int chunk_count = 0;
    wire::ColumnWriter columns([&](v1::BlobChunk chunk) {
      if (++chunk_count != 2) writer->Write(ChunkResponse(std::move(chunk)));
    });
    v1::GetMeshResponse response;
    WriteElements(DiffOf({}, Large()), columns, *response.mutable_snapshot());
    writer->Write(response);
    return grpc::Status::OK;
  };
  Connection connection(server.address(), {});
  const auto replica = connection.GetMesh("s1", Parts::kMesh);
  ASSERT_FALSE(replica.ok());
  EXPECT_EQ(replica.error().code, ErrorCode::kProtocolOrder);
}

TEST(Connection, ADownloadWithoutAMeshIsRefused) {
  FakeServer server;
  server.on_get_mesh = [](const v1::GetMeshRequest&, grpc::ServerWriter<v1::GetMeshResponse>*) {
    return grpc::Status::OK;
  };
  Connection connection(server.address(), {});
  const auto replica = connection.GetMesh("s1", Parts::kMesh);
  ASSERT_FALSE(replica.ok());
  EXPECT_EQ(replica.error().code, ErrorCode::kInternal);
}

TEST(Connection, AMissedDeadlineSaysWhatToDo) {
  FakeServer server;
  server.on_list = [](const v1::ListSessionsRequest&, v1::ListSessionsResponse*) {
    return grpc::Status(grpc::StatusCode::DEADLINE_EXCEEDED, "");
  };
  Connection connection(server.address(), {});
  const auto context = connection.NewContext(milliseconds(1000));
  v1::ListSessionsResponse response;
  const auto status = connection.sessions().ListSessions(context.get(), {}, &response);
  const Error error = CallError(connection, status);
  EXPECT_EQ(error.code, ErrorCode::kDeadlineExceeded);
  EXPECT_THAT(error.message, HasSubstr("in time"));
}

}  // namespace
}  // namespace pliant::client
