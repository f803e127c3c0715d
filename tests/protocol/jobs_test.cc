// Goal: jobs, seen from a client with nothing but the wire and the real engine behind it.
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "core/pliant/remesher.h"
#include "tests/protocol/promises.h"
#include "tests/support/job_client.h"
#include "tests/support/mirror.h"
#include "tests/support/temporary_folder.h"

namespace pliant::test {
namespace {

// The same square, in this process.
MeshDiff InProcess(const std::string& size) {
  const Domain square{.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}},
                      .segments = {{0, 1, 1}, {1, 2, 2}, {2, 3, 3}, {3, 0, 4}},
                      .holes = {},
                      .regions = {}};
  auto remesher = Remesher::Create(square, {.source = SizeMetric{size}}, {}).value();
  EXPECT_TRUE(remesher->Step({}).ok());
  return remesher->Commit();
}

// A job that runs for minutes unless it is stopped.
v1::SubmitJob EndlessJob(const std::string& id) { return SquareJob(id, "0.0007"); }

// Method: a mesh large enough to come in chunks; positions, corners and tags are compared by their
// bits with those of the engine in this process.
TEST(Jobs, GiveTheMeshOfTheEngineToTheLastBit) {
  const std::string size = "0.01 + 0.02*x";
  InProcessServer server;
  JobClient client(server);
  ASSERT_TRUE(client.Submit(SquareJob("a", size)).ok());
  const v1::Job job = client.Wait("a");
  ASSERT_EQ(job.state(), v1::JOB_STATE_DONE) << job.error().message();

  const MeshDiff expected = InProcess(size);
  EXPECT_EQ(job.result().state_hash(), expected.summary.state_hash) << kDeterministic;
  EXPECT_EQ(job.result().counts().triangle_count(), expected.summary.triangle_count);
  EXPECT_EQ(job.result().stop_reason(), v1::STOP_REASON_CONVERGED);
  EXPECT_EQ(job.quality().counts().triangle_count(), expected.summary.triangle_count);
  EXPECT_GT(job.quality().q_mean(), 0.9);

  v1::FetchResultRequest request;
  request.set_job_id("a");
  request.add_parts(v1::MESH_PART_METRIC);
  v1::MeshSnapshot snapshot;
  ASSERT_TRUE(client.Fetch(request, &snapshot).ok());
  EXPECT_GT(client.chunk_count, 0) << "the mesh is meant to be large";
  Mirror mirror;
  ASSERT_EQ(mirror.Take(snapshot), "");
  ASSERT_EQ(mirror.vertices.size(), expected.vertex_ids.size());
  for (std::size_t i = 0; i < expected.vertex_ids.size(); ++i) {
    const auto& position = mirror.vertices.at(expected.vertex_ids[i].value());
    ASSERT_EQ(position[0], expected.vertex_positions[i].x) << kDeterministic;
    ASSERT_EQ(position[1], expected.vertex_positions[i].y) << kDeterministic;
  }
  EXPECT_EQ(snapshot.metric().tensors().shape(0),
            static_cast<std::int64_t>(expected.vertex_ids.size()));
}

TEST(Jobs, StopWhenCancelledAndMakeWayForTheNext) {
  InProcessServer server(server::RemesherFactory(), {.workers = 2, .jobs = {.running_max = 1}});
  JobClient client(server);
  ASSERT_TRUE(client.Submit(EndlessJob("runs")).ok());
  ASSERT_TRUE(client.Submit(EndlessJob("waits")).ok());
  ASSERT_TRUE(client.Submit(SquareJob("last")).ok());
  const v1::Job working = client.WaitUntilItWorks("runs");
  EXPECT_EQ(working.state(), v1::JOB_STATE_RUNNING);
  EXPECT_GT(working.progress().vertex_count(), 0);
  v1::Job job;
  ASSERT_TRUE(client.Get("waits", &job).ok());
  EXPECT_EQ(job.state(), v1::JOB_STATE_QUEUED) << "one runs at a time";
  ASSERT_TRUE(client.Cancel("waits", &job).ok());
  EXPECT_EQ(job.state(), v1::JOB_STATE_CANCELLED);
  ASSERT_TRUE(client.Cancel("runs", &job).ok());
  EXPECT_EQ(job.state(), v1::JOB_STATE_CANCELLED);
  EXPECT_EQ(client.Wait("last").state(), v1::JOB_STATE_DONE);
  ASSERT_TRUE(client.Get("runs", &job).ok());
  EXPECT_EQ(job.state(), v1::JOB_STATE_CANCELLED);
  EXPECT_TRUE(job.has_end_time() && job.has_expire_time());
}

// Goal: jobs leave the sessions their part of the workers. Method: as many endless jobs as there
// are places, and a session that must come to its end beside them.
TEST(Jobs, LeaveSessionsTheirPartOfTheWorkers) {
  InProcessServer server(server::RemesherFactory(), {.workers = 1, .jobs = {.running_max = 2}});
  JobClient client(server);
  for (const char* id : {"a", "b"}) {
    ASSERT_TRUE(client.Submit(EndlessJob(id)).ok());
    EXPECT_EQ(client.WaitUntilItWorks(id).state(), v1::JOB_STATE_RUNNING);
  }
  std::string id;
  ASSERT_TRUE(server.Create(UnitSquare("0.1"), &id).ok()) << kIsolated;
  EditClient edit(server, id);
  edit.Advance(1);
  EXPECT_TRUE(edit.Until(1).back().has_advanced()) << kIsolated;
  v1::Job job;
  for (const char* job_id : {"a", "b"}) ASSERT_TRUE(client.Cancel(job_id, &job).ok());
}

TEST(Jobs, AreRefusedOnePastTheBoundUntilOneExpires) {
  InProcessServer server(server::RemesherFactory(), {.jobs = {.jobs_max = 2}});
  JobClient client(server);
  v1::SubmitJob brief = SquareJob("brief", "0.5");
  brief.set_keep_ms(1);
  ASSERT_TRUE(client.Submit(brief).ok());
  ASSERT_TRUE(client.Submit(SquareJob("kept", "0.5")).ok());
  client.Wait("kept");
  v1::Job job;
  while (client.Get("brief", &job).ok()) std::this_thread::yield();
  ASSERT_TRUE(client.Submit(SquareJob("third", "0.5")).ok()) << "the brief one's place";
  const grpc::Status full = client.Submit(SquareJob("fourth", "0.5"));
  EXPECT_EQ(full.error_code(), grpc::StatusCode::RESOURCE_EXHAUSTED);
  EXPECT_EQ(ReasonOf(full), "RESOURCE_EXHAUSTED");
  EXPECT_EQ(ReasonOf(client.Get("brief", &job)), "JOB_NOT_FOUND");
}

TEST(Jobs, FailWithTheErrorOfTheirInput) {
  InProcessServer server;
  JobClient client(server);
  v1::SubmitJob crossing = SquareJob("crossing");
  *crossing.mutable_input()->mutable_domain()->mutable_segments() =
      Ints({0, 2, 2, 1, 1, 3, 3, 0}, 2);
  ASSERT_TRUE(client.Submit(crossing).ok()) << "how arrays fit together shows in the run";
  const v1::Job job = client.Wait("crossing");
  EXPECT_EQ(job.state(), v1::JOB_STATE_FAILED);
  EXPECT_EQ(job.error().reason(), "CROSSING_SEGMENTS");
  EXPECT_EQ(job.error().field(), "domain.segments");
}

// Goal: with a store, jobs survive their server: a result can still be fetched, and what was not
// done is done again from its input, to the same bits.
TEST(Jobs, SurviveTheirServer) {
  const TemporaryFolder folder;
  server::Config config{.workers = 2, .jobs = {.running_max = 1}};
  config.data = folder.path();
  {
    InProcessServer server(server::RemesherFactory(), config);
    JobClient client(server);
    ASSERT_TRUE(client.Submit(SquareJob("done", "0.1")).ok());
    EXPECT_EQ(client.Wait("done").state(), v1::JOB_STATE_DONE);
    ASSERT_TRUE(client.Submit(EndlessJob("cancelled")).ok());
    v1::Job job;
    ASSERT_TRUE(client.Cancel("cancelled", &job).ok());
    ASSERT_TRUE(client.Submit(SquareJob("runs", "0.004")).ok());
    ASSERT_TRUE(client.Submit(SquareJob("waits", "0.05")).ok());
  }
  InProcessServer server(server::RemesherFactory(), config);
  JobClient client(server);
  v1::Job job;
  ASSERT_TRUE(client.Get("cancelled", &job).ok());
  EXPECT_EQ(job.state(), v1::JOB_STATE_CANCELLED);
  for (const auto& [id, size] :
       {std::pair("done", "0.1"), std::pair("runs", "0.004"), std::pair("waits", "0.05")}) {
    job = client.Wait(id);
    ASSERT_EQ(job.state(), v1::JOB_STATE_DONE) << id << ": " << job.error().message();
    const MeshDiff expected = InProcess(size);
    EXPECT_EQ(job.result().state_hash(), expected.summary.state_hash) << id << kDeterministic;
    v1::MeshSnapshot snapshot;
    ASSERT_TRUE(client.Fetch(id, &snapshot).ok());
    EXPECT_EQ(snapshot.state_hash(), expected.summary.state_hash) << id;
  }
}

// Goal: a shutdown waits for no job.
TEST(Jobs, DoNotHoldUpAShutdown) {
  InProcessServer server(server::RemesherFactory(), {.drain_ms = 60'000});
  JobClient client(server);
  ASSERT_TRUE(client.Submit(EndlessJob("a")).ok());
  EXPECT_EQ(client.WaitUntilItWorks("a").state(), v1::JOB_STATE_RUNNING);
  server.server().Shutdown();
  v1::Job job;
  EXPECT_EQ(client.Get("a", &job).error_code(), grpc::StatusCode::UNAVAILABLE);
}

}  // namespace
}  // namespace pliant::test
