#include "server/engine.h"

#include <gtest/gtest.h>

#include "core/pliant/remesher.h"

namespace pliant::server {
namespace {

EngineInput Square() {
  Domain domain{.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}},
                .segments = {{0, 1, 1}, {1, 2, 2}, {2, 3, 3}, {3, 0, 4}},
                .holes = {},
                .regions = {}};
  return {.start = std::move(domain), .metric = {.source = SizeMetric{"0.2"}}, .options = {}};
}

// Goal: a session's engine is the core's engine: the same calls give the same mesh, whatever the
// budgets of the single steps.
TEST(Engine, GivesTheSameMeshAsTheCoreInOneGo) {
  const EngineInput input = Square();
  auto remesher = *Remesher::Create(std::get<Domain>(input.start), input.metric, input.options);
  ASSERT_TRUE(remesher->Step({}).ok());
  const MeshDiff expected = remesher->Commit();

  auto engine = *RemesherFactory()(input);
  for (;;) {
    const Result<Progress> progress = engine->Step({.visits_max = 7});
    ASSERT_TRUE(progress.ok());
    if (progress->stop_reason != StopReason::kVisitBudget) break;
  }
  const MeshDiff diff = engine->Commit();
  EXPECT_EQ(diff.summary, expected.summary);
  EXPECT_EQ(engine->Snapshot().summary, expected.summary);
  EXPECT_EQ(engine->revision(), Revision(1));
  EXPECT_TRUE(engine->Validate().empty());
  EXPECT_EQ(engine->MeasureQuality().vertex_count, expected.summary.vertex_count);
}

TEST(Engine, PassesTheCoresRefusalsOn) {
  EngineInput input = Square();
  std::get<Domain>(input.start).segments.pop_back();
  const auto engine = RemesherFactory()(input);
  ASSERT_FALSE(engine.ok());
  EXPECT_EQ(engine.error().code, ErrorCode::kOpenLoop);
}

}  // namespace
}  // namespace pliant::server
