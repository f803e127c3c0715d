#include "server/download.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "server/limits.h"
#include "tests/support/fake_server_parts.h"
#include "tests/support/in_process_server.h"

namespace pliant::server {
namespace {

TEST(Download, SendsTheCurrentRevisionAndRefusesOthers) {
  test::InProcessServer server(FakeFactory(std::make_shared<FakeEngineScript>()));
  std::string id;
  ASSERT_TRUE(server.Create(test::UnitSquare(), &id).ok());
  v1::GetMeshRequest request;
  request.set_session_id(id);
  v1::MeshSnapshot mesh;
  EXPECT_EQ(test::ReasonOf(server.GetMesh(request, &mesh)), "REVISION_NOT_FOUND")
      << "before the first advance";
  test::EditClient edit(server, id);
  edit.Advance(1);
  edit.Until(1);
  ASSERT_TRUE(server.GetMesh(request, &mesh).ok());
  EXPECT_EQ(mesh.revision(), 1);
  EXPECT_EQ(mesh.applied_update_id(), 1);
  EXPECT_EQ(test::NumbersOf<std::int32_t>(mesh.vertex_ids()), (std::vector<std::int32_t>{0, 2}));
  request.set_revision(1);
  EXPECT_TRUE(server.GetMesh(request, &mesh).ok());
  request.set_revision(2);
  EXPECT_EQ(test::ReasonOf(server.GetMesh(request, &mesh)), "REVISION_NOT_FOUND");
  request.set_revision(0);
  request.set_numbering(v1::NUMBERING_UNSPECIFIED);
  EXPECT_EQ(test::ReasonOf(server.GetMesh(request, &mesh)), "OUT_OF_RANGE");
  request.set_numbering(v1::NUMBERING_DENSE);
  request.add_parts(v1::MESH_PART_RAW_METRIC);
  EXPECT_EQ(test::ReasonOf(server.GetMesh(request, &mesh)), "UNIMPLEMENTED");
}

// Goal: a snapshot of any size leaves in messages of at most kMessageBytesMax, arrays first.
TEST(Download, SplitsASnapshotIntoMessages) {
  v1::MeshSnapshot snapshot;
  snapshot.set_revision(3);
  *snapshot.mutable_vertex_ids() = test::Ints(std::vector<std::int32_t>(400'000, 1));
  *snapshot.mutable_edge_ids() = test::Ints({1, 2, 3});
  const auto messages = InMessages<v1::GetMeshResponse>(snapshot);
  ASSERT_EQ(messages.size(), 5U) << "1.6 MB in chunks of 512 KiB";
  BlobAssembler blobs;
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LE(messages[i].ByteSizeLong(), static_cast<std::size_t>(kMessageBytesMax));
    ASSERT_TRUE(blobs.Add(messages[i].chunk()).ok());
  }
  v1::MeshSnapshot back = messages.back().snapshot();
  ASSERT_TRUE(blobs.Resolve(back).ok());
  EXPECT_EQ(back.SerializeAsString(), snapshot.SerializeAsString());
}

// Goal: what is staged is no part of a revision: the mesh can be read, the metric must wait.
TEST(Download, DoesNotShowAStagedMetric) {
  test::InProcessServer server(FakeFactory(std::make_shared<FakeEngineScript>()));
  std::string id;
  ASSERT_TRUE(server.Create(test::UnitSquare(), &id).ok());
  test::EditClient edit(server, id);
  edit.Advance(1);
  edit.Size(2, "0.1");
  edit.Until(2);
  v1::GetMeshRequest request;
  request.set_session_id(id);
  v1::MeshSnapshot mesh;
  EXPECT_TRUE(server.GetMesh(request, &mesh).ok());
  request.add_parts(v1::MESH_PART_METRIC);
  EXPECT_EQ(test::ReasonOf(server.GetMesh(request, &mesh)), "PROTOCOL_ORDER");
  edit.Advance(3);
  edit.Until(3);
  EXPECT_TRUE(server.GetMesh(request, &mesh).ok());
}

// Goal: whoever has a mesh may ask for the next at once. Method: as many clients as may download at
// the same time, one mesh after the other each; none is ever refused.
TEST(Download, LeavesItsPlaceBeforeItsClientKnowsThatItHasEnded) {
  constexpr int kSessions = 8;  // Of kCallsMax calls each at most.
  static_assert(kDownloadsMax <= kSessions * static_cast<int>(kCallsMax));
  test::InProcessServer server(FakeFactory(std::make_shared<FakeEngineScript>()));
  std::vector<std::string> ids(kSessions);
  for (std::string& id : ids) {
    ASSERT_TRUE(server.Create(test::UnitSquare(), &id).ok());
    test::EditClient edit(server, id);
    edit.Advance(1);
    edit.Until(1);
  }
  std::vector<std::thread> clients;
  for (int client = 0; client < kDownloadsMax; ++client) {
    clients.emplace_back([&, client] {
      v1::GetMeshRequest request;
      request.set_session_id(ids[static_cast<std::size_t>(client % kSessions)]);
      for (int i = 0; i < 50; ++i) {
        v1::MeshSnapshot mesh;
        const grpc::Status status = server.GetMesh(request, &mesh);
        EXPECT_TRUE(status.ok()) << test::ReasonOf(status);
      }
    });
  }
  for (std::thread& client : clients) client.join();
}

}  // namespace
}  // namespace pliant::server
