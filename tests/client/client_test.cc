#include "client/cpp/client.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/client/fake_server.h"
#include "tests/client/model_mesh.h"

namespace pliant::client {
namespace {

using testing::HasSubstr;

Domain Square() {
  return {.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}},
          .segments = {{0, 1, 5}, {1, 2, 6}, {2, 3, 7}, {3, 0, 8}},
          .holes = {},
          .regions = {}};
}

Client Connected(const FakeServer& server) {
  Result<Client> client = Client::Connect(server.address());
  EXPECT_TRUE(client.ok()) << client.error().message;
  return std::move(client).value();
}

TEST(Client, ConnectLearnsWhoTheServerIs) {
  FakeServer server;
  const Client client = Connected(server);
  EXPECT_EQ(client.server_info().version, "9.8.7");
  EXPECT_EQ(client.server_info().limits.at("sessions"), 5);
  EXPECT_EQ(client.address(), server.address());
}

// Goal: calls that do no harm twice wait for a server that is away for a while; others do not.
TEST(Client, CallsThatDoNoHarmTwiceAreMadeAgain) {
  FakeServer server;
  int tries = 0;
  server.on_list = [&](const v1::ListSessionsRequest&, v1::ListSessionsResponse* response) {
    if (++tries < 3) return grpc::Status(grpc::StatusCode::UNAVAILABLE, "starting");
    response->add_sessions()->set_session_id("a");
    return grpc::Status::OK;
  };
  server.create_status = {grpc::StatusCode::UNAVAILABLE, "starting"};
  Client client = Connected(server);
  const auto sessions = client.ListSessions();
  ASSERT_TRUE(sessions.ok()) << sessions.error().message;
  EXPECT_EQ(sessions->size(), 1u);
  EXPECT_EQ(tries, 3);
  EXPECT_EQ(client.CreateSession(Square(), {.source = SizeMetric{"1"}}).error().code,
            ErrorCode::kUnavailable);
  const auto impatient = Client::Connect(server.address(), {.reconnect_max = {}});
  tries = 0;
  EXPECT_EQ(Client(*impatient).ListSessions().error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(tries, 1);
}

TEST(Client, CreateSendsDomainMetricAndOptions) {
  FakeServer server;
  server.on_edit = [](EditScript& script, int) {
    script.Open(Revision{0});
    script.Next();
    return grpc::Status::OK;
  };
  Client client = Connected(server);
  SessionSettings settings;
  settings.session_id = "wing";
  settings.labels["solver"] = "toy";
  settings.options.seed = ~std::uint64_t{0};
  settings.durability = Durability::kRelaxed;
  settings.history_bytes_max = 0;
  MetricSpec metric;
  metric.source = ExpressionMetric{"1", "0", "4"};
  metric.bounds.size_min = 0.25;
  metric.gradation = {.gradation = 1.5, .rotation = 0.7};
  const auto session = client.CreateSession(Square(), metric, settings);
  ASSERT_TRUE(session.ok()) << session.error().message;
  EXPECT_EQ((*session)->id(), "s1");

  const v1::CreateSession& created = server.created;
  EXPECT_EQ(created.session_id(), "wing");
  EXPECT_EQ(created.labels().at("solver"), "toy");
  EXPECT_EQ(created.domain().points().shape(0), 4);
  EXPECT_EQ(created.options().seed(), -1);
  EXPECT_EQ(created.options().durability(), v1::DURABILITY_RELAXED);
  EXPECT_TRUE(created.options().has_history_bytes_max());
  EXPECT_EQ(created.options().history_bytes_max(), 0);
  EXPECT_FALSE(created.options().has_vertices_max()) << "defaults are the server's business";
  EXPECT_EQ(created.metric().sources(0).expression().m22(), "4");
  EXPECT_EQ(created.metric().limits().size_min(), 0.25);
  EXPECT_EQ(created.metric().limits().gradation(), 1.5);
  EXPECT_EQ(created.metric().limits().rotation(), 0.7);
}

TEST(Client, CreateSendsALargeMeshAheadInChunks) {
  FakeServer server;
  server.on_edit = [](EditScript& script, int) {
    script.Open(Revision{0});
    script.Next();
    return grpc::Status::OK;
  };
  Client client = Connected(server);
  MeshData mesh;
  mesh.points.resize(100'000);    // 1.6 MB: 4 chunks.
  mesh.triangles.resize(50'000);  // 0.6 MB: 2 chunks.
  mesh.edges.resize(10);
  ASSERT_TRUE(client.CreateSession(mesh, MetricSpec()).ok());
  EXPECT_EQ(server.created_chunk_count, 6);
  EXPECT_EQ(server.created.mesh().points().storage_case(), v1::Array::kBlobId);
  EXPECT_EQ(server.created.mesh().edges().storage_case(), v1::Array::kData);
}

TEST(Client, ARefusedCreateHasTheServersReason) {
  FakeServer server;
  v1::ErrorDetail detail;
  detail.set_reason("CROSSING_SEGMENTS");
  detail.set_field("domain.segments");
  detail.set_index(1);
  detail.set_other_index(3);
  v1::ErrorStatus details;
  details.add_details()->PackFrom(detail);
  server.create_status =
      grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "", details.SerializeAsString());
  const auto session = Connected(server).CreateSession(Square(), MetricSpec());
  ASSERT_FALSE(session.ok());
  EXPECT_EQ(session.error().code, ErrorCode::kCrossingSegments);
  EXPECT_EQ(session.error().index, 1);
  EXPECT_EQ(session.error().other_index, 3);
}

TEST(Client, ListReadsAllPages) {
  FakeServer server;
  server.on_list = [](const v1::ListSessionsRequest& request, v1::ListSessionsResponse* response) {
    const int page = request.page_token().empty() ? 0 : std::stoi(request.page_token());
    v1::Session& session = *response->add_sessions();
    session.set_session_id("s" + std::to_string(page));
    session.set_revision(page);
    session.set_state(v1::SESSION_STATE_RUNNING);
    session.mutable_counts()->set_vertex_count(10 * page);
    session.mutable_create_time()->set_seconds(1'000'000'000);
    if (page < 2) response->set_next_page_token(std::to_string(page + 1));
    return grpc::Status::OK;
  };
  const auto sessions = Connected(server).ListSessions();
  ASSERT_TRUE(sessions.ok());
  ASSERT_EQ(sessions->size(), 3U);
  EXPECT_EQ((*sessions)[2].session_id, "s2");
  EXPECT_EQ((*sessions)[2].revision, Revision{2});
  EXPECT_EQ((*sessions)[2].state, SessionState::kRunning);
  EXPECT_EQ((*sessions)[2].summary.vertex_count, 20);
  EXPECT_EQ((*sessions)[2].create_time.time_since_epoch(), std::chrono::seconds(1'000'000'000));
}

TEST(Client, WhatTheServerDoesNotKnowSaysSo) {
  FakeServer server;
  const auto quality = Connected(server).GetQuality("s1");
  ASSERT_FALSE(quality.ok());
  EXPECT_EQ(quality.error().code, ErrorCode::kUnimplemented);
}

}  // namespace
}  // namespace pliant::client
