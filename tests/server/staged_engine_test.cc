#include "server/staged_engine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>

#include "tests/support/fake_server_parts.h"

namespace pliant::server {
namespace {

using testing::ElementsAre;

struct Fixture {
  std::shared_ptr<FakeEngineScript> script = std::make_shared<FakeEngineScript>();
  StagedEngine engine = *StagedEngine::Create(EngineInput{}, FakeFactory(script));
};

VertexTensors OneTensor(Revision revision) {
  return {.revision = revision, .vertices = {{VertexId(0)}}, .tensors = {Metric{}}};
}

TEST(StagedEngine, RefusesTensorsForAnotherRevisionThanTheCurrentOne) {
  Fixture f;
  Status status = f.engine.Stage({.source = OneTensor(Revision(0))});
  ASSERT_FALSE(status.ok()) << "there is no revision yet";
  EXPECT_EQ(status.error().code, ErrorCode::kRevisionMismatch);
  ASSERT_TRUE(f.engine.Discard().ok());
  f.engine.Commit();
  EXPECT_TRUE(f.engine.Stage({.source = OneTensor(Revision(1))}).ok());
  status = f.engine.Stage({.source = OneTensor(Revision(2))});
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().field, "metric.revision");
  EXPECT_TRUE(f.engine.tainted());
  EXPECT_EQ(f.engine.staged_count(), 1);
}

// Goal: for the engine no vertices means all; an empty list from a client must not become that.
TEST(StagedEngine, TakesAnEmptyListOfVerticesAsNoVertex) {
  Fixture f;
  f.engine.Commit();
  ASSERT_TRUE(f.engine
                  .Stage({.source = VertexTensors{.revision = Revision(1),
                                                  .vertices = std::vector<VertexId>(),
                                                  .tensors = {}}})
                  .ok());
  EXPECT_TRUE(f.script->calls.empty());
  ASSERT_TRUE(f.engine
                  .Stage({.source = VertexTensors{.revision = Revision(1),
                                                  .vertices = std::nullopt,
                                                  .tensors = {Metric{}, Metric{}, Metric{}}}})
                  .ok());
  EXPECT_THAT(f.script->calls, ElementsAre("tensors 0/3"));
}

TEST(StagedEngine, ChangesOnlyWhatAnUpdateNames) {
  Fixture f;
  f.engine.Commit();
  ASSERT_TRUE(f.engine.Stage({.source = SizeMetric{"x"}, .time = 4.0}).ok());
  ASSERT_TRUE(f.engine.Stage({.source = {}, .size_min = 0.1}).ok());
  EXPECT_THAT(f.script->calls, ElementsAre("metric t=4", "metric t=4"));
}

TEST(StagedEngine, ForgetsAStagedMetricWithTheStage) {
  Fixture f;
  f.engine.Commit();
  ASSERT_TRUE(f.engine.Stage({.source = {}, .time = 4.0}).ok());
  ASSERT_TRUE(f.engine.Discard().ok());
  ASSERT_TRUE(f.engine.Stage({.source = {}, .size_min = 0.1}).ok());
  EXPECT_THAT(f.script->calls, ElementsAre("metric t=4", "metric t=0"));
  EXPECT_EQ(f.script->rollback_count, 1);
}

TEST(StagedEngine, CannotChangeLimitsOfTensorsYetAndSaysSo) {
  Fixture f;
  f.engine.Commit();
  ASSERT_TRUE(f.engine.Stage({.source = OneTensor(Revision(1))}).ok());
  Status status = f.engine.Stage({.source = {}, .size_min = 0.1});
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kUnimplemented);
  ASSERT_TRUE(f.engine.Discard().ok());
  EXPECT_TRUE(f.engine.Stage({.source = {}, .size_min = 0.1}).ok())
      << "before the tensors there was a specification";
}

TEST(StagedEngine, UndoesNothingWhenNothingWasStaged) {
  Fixture f;
  f.engine.Commit();
  f.engine.Taint();
  ASSERT_TRUE(f.engine.Discard().ok());
  EXPECT_FALSE(f.engine.tainted());
  EXPECT_EQ(f.script->rollback_count, 0);
}

TEST(StagedEngine, NeverCommitsWhileTainted) {
  Fixture f;
  f.engine.Taint();
  EXPECT_THROW(f.engine.Commit(), InvariantViolation);
}

TEST(StagedEngine, NamesTheFieldOfWhatTheEngineRefuses) {
  Fixture f;
  f.engine.Commit();
  f.script->update_error = Error{ErrorCode::kNotPositiveDefinite, "bad", {}, 3};
  const Status status = f.engine.Stage({.source = OneTensor(Revision(1))});
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().field, "metric.tensors");
  EXPECT_EQ(status.error().index, 3);
}

}  // namespace
}  // namespace pliant::server
