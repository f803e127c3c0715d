#include "server/staged_engine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

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

TEST(StagedEngine, StagesFieldsOfTheCurrentRevisionOnly) {
  Fixture f;
  EXPECT_EQ(f.engine.Stage(FieldsUpdate{}).error().code, ErrorCode::kRevisionMismatch)
      << "there is no revision yet";
  ASSERT_TRUE(f.engine.Discard().ok());
  f.engine.Commit();
  EXPECT_TRUE(f.engine.Stage(FieldsUpdate{.revision = Revision(1)}).ok());
  EXPECT_EQ(f.engine.staged_count(), 1);
  EXPECT_THAT(f.script->calls, ElementsAre("fields 0"));
  const Status status = f.engine.Stage(FieldsUpdate{.revision = Revision(2)});
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().field, "fields.revision");
  EXPECT_TRUE(f.engine.tainted());
}

TEST(StagedEngine, StagesOptionsOverThoseThatHold) {
  Fixture f;
  EXPECT_TRUE(f.engine.Stage(OptionsUpdate{.hops_max = 3}).ok());
  EXPECT_TRUE(f.engine.Stage(OptionsUpdate{.age_max = 90}).ok());
  EXPECT_THAT(f.script->calls, ElementsAre("options 3", "options 8"));
  EXPECT_EQ(f.engine.staged_count(), 2);
  f.script->update_error = Error{ErrorCode::kOutOfRange, "no", ""};
  EXPECT_EQ(f.engine.Stage(OptionsUpdate{}).error().field, "options");
  EXPECT_TRUE(f.engine.tainted());
}

TEST(StagedEngine, StagesConstraintsOfTheCurrentRevisionOnly) {
  Fixture f;
  EXPECT_TRUE(f.engine.Stage(ConstraintsUpdate{}).ok()) << "names nothing";
  const ConstraintsUpdate named{.revision = Revision(1), .constraints = {{VertexId(0)}}};
  EXPECT_EQ(f.engine.Stage(named).error().code, ErrorCode::kRevisionMismatch);
  ASSERT_TRUE(f.engine.Discard().ok());
  f.engine.Commit();
  EXPECT_TRUE(f.engine.Stage(named).ok());
  EXPECT_THAT(f.script->calls, ElementsAre("constraints 0", "constraints 1"));
  f.engine.Commit();
  EXPECT_EQ(f.engine.Stage(named).error().field, "constraints.revision");
}

TEST(StagedEngine, TakesASolutionOnceThereIsARevision) {
  Fixture f;
  const MetricUpdate update{.source = SolutionRequest{.name = "u"}};
  EXPECT_EQ(f.engine.Stage(update).error().code, ErrorCode::kRevisionMismatch);
  ASSERT_TRUE(f.engine.Discard().ok());
  f.engine.Commit();
  EXPECT_TRUE(f.engine.Stage(update).ok());
  EXPECT_THAT(f.script->calls, ElementsAre("solution u"));
  EXPECT_EQ(f.engine.Stage(MetricUpdate{.time = 3.0}).error().code, ErrorCode::kProtocolOrder)
      << "the specification is gone, as after tensors";
}

TEST(StagedEngine, ChangesOnlyWhatAnUpdateNames) {
  Fixture f;
  f.engine.Commit();
  ASSERT_TRUE(f.engine.Stage({.source = SizeMetric{"x"}, .time = 4.0}).ok());
  ASSERT_TRUE(f.engine.Stage({.source = {}, .size_min = 0.1}).ok());
  EXPECT_THAT(f.script->calls, ElementsAre("metric t=4", "metric t=4"));
}

MotionUpdate Motion(Revision revision) {
  MotionUpdate motion{.field = "boundary", .revision = revision};
  motion.request.vertices = {VertexId(0)};
  motion.request.positions = {{1, 2}};
  return motion;
}

TEST(StagedEngine, StagesMotionsAndTellsHowFarTheyWent) {
  Fixture f;
  f.engine.Commit();
  EXPECT_FALSE(f.engine.motion_fraction().has_value());
  ASSERT_TRUE(f.engine.StageMotion(Motion(Revision(1))).ok());
  EXPECT_EQ(f.engine.motion_fraction(), 1);
  f.script->motion_fraction = 0.25;
  MotionUpdate all{.field = "nodes", .revision = Revision(1), .names_all = true};
  all.request.positions = {{0, 0}, {1, 0}, {0, 1}};
  ASSERT_TRUE(f.engine.StageMotion(all).ok());
  f.script->motion_fraction = 0.5;
  MotionUpdate by_tag{.field = "boundary"};
  by_tag.request.tags.push_back({{7}, Translation{{1, 0}}});
  ASSERT_TRUE(f.engine.StageMotion(by_tag).ok());
  EXPECT_EQ(f.engine.motion_fraction(), 0.25);
  EXPECT_EQ(f.engine.staged_count(), 3);
  EXPECT_THAT(f.script->calls, ElementsAre("move 1/0", "move 3/0", "move 0/1"));
  f.engine.Commit();
  EXPECT_FALSE(f.engine.motion_fraction().has_value());
}

TEST(StagedEngine, StagesAnotherDomain) {
  Fixture f;
  f.engine.Commit();
  DomainUpdate update;
  update.domain.points.resize(3);
  ASSERT_TRUE(f.engine.Stage(update).ok());
  EXPECT_EQ(f.engine.staged_count(), 1);
  EXPECT_THAT(f.script->calls, ElementsAre("domain 3"));
  f.script->update_error = Error{ErrorCode::kCrossingSegments, "no", "domain.segments", 3};
  const Status status = f.engine.Stage(update);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().field, "domain.segments");
  EXPECT_TRUE(f.engine.tainted());
}

TEST(StagedEngine, RefusesDomainsOfTooManyPoints) {
  Fixture f;
  f.engine.Commit();
  DomainUpdate update;
  update.domain.points.resize(static_cast<std::size_t>(Options().vertices_max));
  EXPECT_TRUE(f.engine.Stage(update).ok()) << "as many as the limit says";
  update.domain.points.emplace_back();
  const Status status = f.engine.Stage(update);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kTooLarge);
}

// Goal: the displacement comes before the metric that is sent with it, and is undone with the
// stage; without one the specification no longer says what the mesh follows.
TEST(StagedEngine, DisplacesBeforeItFollows) {
  Fixture f;
  f.engine.Commit();
  const DisplacementUpdate moved{Revision(1), {VertexId(0), VertexId(2)}, {{1, 0}, {0, 1}}};
  ASSERT_TRUE(f.engine.Stage({.time = 4, .displacement = moved}).ok());
  EXPECT_THAT(f.script->calls, ElementsAre("displace 2", "metric t=4"));
  EXPECT_NE(f.engine.spec(), nullptr);
  ASSERT_TRUE(f.engine.Stage({.displacement = moved}).ok());
  EXPECT_EQ(f.engine.spec(), nullptr);
  ASSERT_TRUE(f.engine.Discard().ok());
  EXPECT_NE(f.engine.spec(), nullptr);
  EXPECT_FALSE(f.engine.stepped());
  const DisplacementUpdate old{Revision(2), {VertexId(0)}, {{1, 0}}};
  const Status status = f.engine.Stage({.displacement = old});
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kRevisionMismatch);
  EXPECT_EQ(status.error().field, "metric.displacement.revision");
}

// Goal: tensors that come with a displacement are handed over with it, in one go; where either is
// refused, the stage is undone as a whole.
TEST(StagedEngine, TakesTensorsWithTheirDisplacement) {
  Fixture f;
  f.engine.Commit();
  const DisplacementUpdate moved{Revision(1), {VertexId(0), VertexId(2)}, {{1, 0}, {0, 1}}};
  const VertexTensors all{Revision(1), {}, std::vector<Metric>(3)};
  ASSERT_TRUE(f.engine.Stage({.source = all, .displacement = moved}).ok());
  EXPECT_THAT(f.script->calls, ElementsAre("displace 2", "tensors 0/3"));
  EXPECT_EQ(f.engine.spec(), nullptr);
  EXPECT_TRUE(f.engine.stepped());
  f.script->calls.clear();
  const VertexTensors none{Revision(1), std::vector<VertexId>{}, {}};
  ASSERT_TRUE(f.engine.Stage({.source = none, .displacement = moved}).ok());
  EXPECT_THAT(f.script->calls, ElementsAre("displace 2", "limits"));
  f.script->calls.clear();
  const DisplacementUpdate nobody{Revision(1), {}, {}};
  ASSERT_TRUE(f.engine.Stage({.source = all, .displacement = nobody}).ok());
  EXPECT_THAT(f.script->calls, ElementsAre("tensors 0/3"));
  const DisplacementUpdate old{Revision(2), {VertexId(0)}, {{1, 0}}};
  const Status mismatch = f.engine.Stage({.source = all, .displacement = old});
  ASSERT_FALSE(mismatch.ok());
  EXPECT_EQ(mismatch.error().field, "metric.displacement.revision");
  ASSERT_TRUE(f.engine.Discard().ok());
  f.script->update_error = Error{ErrorCode::kNotFinite, "no", "metric.tensors", 1};
  const Status refused = f.engine.Stage({.source = all, .displacement = moved});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().field, "metric.tensors");
  EXPECT_TRUE(f.engine.tainted());
  EXPECT_TRUE(f.engine.stepped()) << "so that a discard undoes what may have moved";
}

TEST(StagedEngine, RefusesMotionsInTheWordsOfTheRequest) {
  Fixture f;
  f.engine.Commit();
  const std::vector<std::pair<const char*, const char*>> names = {
      {"motion.vertices", "boundary.vertices.vertex_ids"},
      {"motion.positions", "boundary.vertices.positions"},
      {"motion.tags", "boundary.tags"},
      {"motion.follow_length", "boundary.metric_follow_length"},
      {"vertices", "vertices"},
      {"edges", "edges"},
      {"triangles", "triangles"},
      {"motion", "boundary"}};
  for (const auto& [inside, outside] : names) {
    f.script->update_error = Error{ErrorCode::kNotFinite, "no", inside, 3};
    const Status status = f.engine.StageMotion(Motion(Revision(1)));
    ASSERT_FALSE(status.ok());
    EXPECT_EQ(status.error().field, outside);
    EXPECT_EQ(status.error().index, 3);
    EXPECT_TRUE(f.engine.tainted());
  }
  const Status status = f.engine.StageMotion(Motion(Revision(2)));
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kRevisionMismatch);
  EXPECT_EQ(status.error().field, "boundary.vertices.revision");
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

TEST(StagedEngine, ChangesLimitsOfTensorsWithThemAndAfterThem) {
  Fixture f;
  f.engine.Commit();
  ASSERT_TRUE(f.engine.Stage({.source = OneTensor(Revision(1)), .gradation = 1.5}).ok());
  ASSERT_TRUE(f.engine.Stage({.source = {}, .size_min = 0.1}).ok());
  EXPECT_THAT(f.script->calls, ElementsAre("tensors 1/1", "limits"));
  MetricLimits limits;
  limits.bounds.size_min = 0.1;
  limits.gradation.gradation = 1.5;
  EXPECT_EQ(f.engine.engine().limits(), limits) << "what an update does not name stays";
  ASSERT_TRUE(f.engine.Discard().ok());
  EXPECT_EQ(f.engine.engine().limits(), MetricLimits());
}

TEST(StagedEngine, KeepsTheLimitsOfTensorsForTheFormulaAfterThem) {
  Fixture f;
  f.engine.Commit();
  ASSERT_TRUE(f.engine.Stage({.source = OneTensor(Revision(1)), .gradation = 1.5}).ok());
  ASSERT_TRUE(f.engine.Stage({.source = SizeMetric{"x"}}).ok());
  EXPECT_EQ(f.engine.spec()->gradation.gradation, 1.5);
}

TEST(StagedEngine, KnowsNoTimeOfTensors) {
  Fixture f;
  f.engine.Commit();
  const Status status = f.engine.Stage({.source = OneTensor(Revision(1)), .time = 2.0});
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kProtocolOrder);
  EXPECT_EQ(status.error().field, "metric.time");
}

FunctionsSpec OneFunction() { return {.parts = {SizeMetric{"0.1 + t"}}, .before_count = 1}; }

TEST(StagedEngine, KeepsTheTimeOfFunctionsBesideTensors) {
  Fixture f;
  f.engine.Commit();
  ASSERT_TRUE(f.engine.Stage({.source = SizeMetric{"x"}, .time = 4.0}).ok());
  const VertexTensors all{.revision = Revision(1), .tensors = {Metric{}, Metric{}, Metric{}}};
  ASSERT_TRUE(f.engine.Stage({.source = all, .functions = OneFunction()}).ok());
  ASSERT_TRUE(f.engine.Stage({.source = OneTensor(Revision(1))}).ok());
  ASSERT_TRUE(f.engine.Stage({.source = OneTensor(Revision(1)), .time = 5.0}).ok());
  ASSERT_TRUE(f.engine.Stage({.source = {}, .time = 6.0}).ok());
  ASSERT_TRUE(f.engine.Stage({.source = {}, .size_min = 0.1}).ok());
  ASSERT_TRUE(f.engine.Stage({.source = SizeMetric{"y"}}).ok());
  EXPECT_THAT(f.script->calls,
              ElementsAre("metric t=4", "tensors 0/3 beside 1 from 1 t=4",
                          "tensors 1/1 beside 1 from 1 t=4", "tensors 1/1 beside 1 from 1 t=5",
                          "functions beside 1 from 1 t=6", "limits", "metric t=6"));
}

// Goal: an empty list of ids with functions changes the functions alone, and values at all vertices
// end them.
TEST(StagedEngine, ReplacesFunctionsBesideTensorsAndEndsThem) {
  Fixture f;
  f.engine.Commit();
  const VertexTensors none{.revision = Revision(1), .vertices = std::vector<VertexId>()};
  ASSERT_TRUE(f.engine.Stage({.source = none, .functions = OneFunction()}).ok());
  EXPECT_EQ(f.engine.spec(), nullptr);
  const SolutionRequest solution{.name = "u"};
  ASSERT_TRUE(f.engine.Stage({.source = solution, .functions = OneFunction(), .time = 2.0}).ok());
  ASSERT_TRUE(f.engine.Stage({.source = solution}).ok());
  EXPECT_THAT(f.script->calls, ElementsAre("functions beside 1 from 1 t=0",
                                           "solution u beside 1 from 1 t=2", "solution u"));
  EXPECT_EQ(f.engine.Stage({.source = solution, .time = 3.0}).error().code,
            ErrorCode::kProtocolOrder);
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
