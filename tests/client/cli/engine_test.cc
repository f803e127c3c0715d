#include "client/cli/engine.h"

#include <gtest/gtest.h>

#include "tests/client/cli/support.h"

namespace pliant::cli {
namespace {

RemeshJob Job(const std::string& size) {
  RemeshJob job;
  job.start = UnitSquare();
  job.metric.source = SizeMetric{size};
  return job;
}

TEST(Engine, MakesAMeshOfADomain) {
  const auto result = RemeshLocally(Job("0.1"), {});
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(result->report.stop, client::AdvanceStop::kConverged);
  EXPECT_EQ(result->report.active_count, 0);
  const auto vertices = static_cast<std::int64_t>(result->mesh.mesh.points.size());
  EXPECT_GT(vertices, 80);
  EXPECT_LT(vertices, 200);
  EXPECT_EQ(result->quality.vertex_count, vertices);
  EXPECT_EQ(result->report.summary.vertex_count, vertices);
  EXPECT_EQ(result->mesh.metrics.size(), result->mesh.mesh.points.size());
  EXPECT_GT(result->quality.q_mean, 0.9);
}

// Goal: --threads changes no bit. Meshes of 32,768 vertices and more are worked on in blocks.
TEST(Engine, ThreadsDoNotChangeTheMesh) {
  RemeshJob job = Job("0.0029");
  job.thread_count = 1;
  const auto alone = RemeshLocally(job, {});
  job.thread_count = 3;
  const auto together = RemeshLocally(job, {});
  ASSERT_TRUE(alone.ok() && together.ok());
  EXPECT_GT(alone->report.summary.vertex_count, 131'072);
  EXPECT_EQ(alone->report.summary, together->report.summary);
}

// Goal: however the loop is cut into steps, the mesh is the same.
TEST(Engine, StepsThatAreCutByLimitsAddUpToTheSameMesh) {
  const auto whole = RemeshLocally(Job("0.01"), {});
  ASSERT_TRUE(whole.ok());
  ASSERT_GT(whole->report.visits, 20'000) << "must take several steps to test anything";
  RemeshJob limited = Job("0.01");
  limited.advance.visits_max = whole->report.visits;
  const auto same = RemeshLocally(limited, {});
  ASSERT_TRUE(same.ok());
  EXPECT_EQ(same->report.summary, whole->report.summary);

  limited.advance.visits_max = 10'001;
  const auto part = RemeshLocally(limited, {});
  ASSERT_TRUE(part.ok());
  EXPECT_EQ(part->report.stop, client::AdvanceStop::kVisitBudget);
  EXPECT_EQ(part->report.visits, 10'001);
  EXPECT_GT(part->report.active_count, 0);
}

TEST(Engine, AnEndlessJobEndsByTimeOrCancel) {
  RemeshJob job = Job("0.001");
  job.advance.time_max = std::chrono::milliseconds(1);
  const auto timed = RemeshLocally(job, {});
  ASSERT_TRUE(timed.ok());
  EXPECT_EQ(timed->report.stop, client::AdvanceStop::kTimeBudget);

  int calls = 0;
  const auto cancelled = RemeshLocally(Job("0.0005"), [&](const client::AdvanceProgress& progress) {
    EXPECT_GT(progress.visits, 0);
    EXPECT_GT(progress.vertex_count, 4);
    return ++calls == 2 ? Proceed::kCancel : Proceed::kGoOn;
  });
  ASSERT_FALSE(cancelled.ok());
  EXPECT_EQ(cancelled.error().code, ErrorCode::kCancelled);
  EXPECT_EQ(calls, 2);
}

TEST(Engine, WhatTheCoreRefusesIsItsError) {
  const auto result = RemeshLocally(Job("0.1 +"), {});
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::kExpressionSyntax);
}

TEST(Engine, AServerThatIsNotThereIsUnavailable) {
  const auto result = RemeshOnServer("unix:no_such_server.sock", Job("0.1"), {});
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::kUnavailable);
}

}  // namespace
}  // namespace pliant::cli
