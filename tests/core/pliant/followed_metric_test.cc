#include "core/pliant/followed_metric.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/rng.h"
#include "core/delaunay/import_mesh.h"
#include "core/mesh/mesh_edit.h"
#include "core/metric/function_field.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

/// A committed grid of 8 x 8 cells over [0, 1]^2 that follows the size 0.1.
class FollowedMetricTest : public ::testing::Test {
 protected:
  void SetUp() override {
    MeshData grid = testing::GridData(8, 8);
    for (Vec2& p : grid.points) p = (1 / 8.0) * p;
    BuildFromPlan(PlanImport(grid).value(), edit_);
    Start();
  }

  /// Follows spec_ from the first commit on.
  void Start() {
    followed_.Follow(MakeMetricField(spec_, {{0, 0}, {1, 1}}).value(), &spec_);
    for (const VertexId vertex : LiveVertices(mesh_)) {
      edit_.SetMetric(vertex, At(mesh_.position(vertex)));
    }
    Commit();
  }

  void Commit() {
    Take(followed_.Settle());
    revision_ = Revision(static_cast<std::int64_t>(revision_) + 1);
    (void)edit_.Commit(revision_);
    (void)followed_.AfterCommit();
    committed_ = followed_.state();
  }
  void Rollback() {
    edit_.Rollback();
    followed_.Rollback(committed_);
  }

  void SetSpec(const MetricSpec& spec) {
    auto field = MakeMetricField(spec, {{0, 0}, {1, 1}}).value();
    WantedTensors raw = followed_.Evaluate(*field).value();
    Take(followed_.SetField(std::move(field), &spec, std::move(raw)));
  }

  void SetSize(VertexId vertex, double size) {
    const Metric tensor = Metric::Isotropic(size);
    ASSERT_TRUE(followed_.CheckTensors({&vertex, 1}, {&tensor, 1}).ok());
    Take(followed_.SetTensors({&vertex, 1}, {&tensor, 1}));
  }

  /// What Remesher does with wanted tensors, but for waking.
  void Take(const Result<WantedTensors>& wanted) {
    ASSERT_TRUE(wanted.ok());
    for (std::size_t i = 0; i < wanted->vertices.size(); ++i) {
      if (followed_.Differs(mesh_.metric(wanted->vertices[i]), wanted->tensors[i])) {
        edit_.SetMetric(wanted->vertices[i], wanted->tensors[i]);
      }
    }
  }

  Metric At(Vec2 p) const {
    std::int32_t hint = MetricField::kNoHint;
    return followed_.field().At(p, hint);
  }
  Metric RawAt(Vec2 p) const {
    std::int32_t hint = MetricField::kNoHint;
    return followed_.RawField()->At(p, hint);
  }
  std::vector<Metric> Answers() const {
    Rng rng(3);
    std::vector<Metric> metrics;
    for (int i = 0; i < 200; ++i) metrics.push_back(At({rng.Uniform(0, 1), rng.Uniform(0, 1)}));
    return metrics;
  }

  Revision revision_ = Revision::kNone;
  testing::EditedMesh edited_;
  Mesh& mesh_ = edited_.mesh;
  MeshEdit& edit_ = edited_.edit;
  FollowedMetric followed_{edit_, 0.05};
  FollowedMetric::State committed_;
  MetricSpec spec_{.source = SizeMetric{"0.1"}};
};

TEST_F(FollowedMetricTest, KnowsWhatItFollows) {
  EXPECT_TRUE(followed_.Follows(spec_));
  MetricSpec other = spec_;
  other.time = 1;
  EXPECT_FALSE(followed_.Follows(other));
  SetSize(VertexId(40), 0.05);
  EXPECT_FALSE(followed_.Follows(spec_)) << "a tensor at a vertex makes it another metric";
}

// Goal: many vertices asked at once, in any order and some twice, get the bits that each would get
// alone; one more than a block of questions, and none.
TEST_F(FollowedMetricTest, AsksManyVerticesAsItWouldOne) {
  const auto formula = MakeMetricField(
      {.source = ExpressionMetric{"100+x", "sin(y)", "exp(x*y)+9"}}, {{0, 0}, {1, 1}});
  const auto function = [](Vec2 p) { return Metric{100 + p.x, p.y, 9}; };
  const FunctionField<decltype(function)> own(function);
  Rng rng(5);
  std::vector<VertexId> vertices;
  vertices.reserve(1025);
  for (int i = 0; i < 1025; ++i) vertices.emplace_back(static_cast<std::int32_t>(rng.Below(81)));
  for (const MetricField* field : std::array<const MetricField*, 2>{formula->get(), &own}) {
    const std::vector<Metric> tensors = followed_.Ask(*field, vertices).value();
    ASSERT_EQ(tensors.size(), vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      std::int32_t hint = MetricField::kNoHint;
      EXPECT_EQ(tensors[i], field->At(mesh_.position(vertices[i]), hint));
    }
  }
  EXPECT_TRUE(followed_.Ask(own, {}).value().empty());
  const StopFlag stop(true);
  EXPECT_EQ(followed_.Ask(own, vertices, &stop).error().code, ErrorCode::kCancelled);
}

TEST_F(FollowedMetricTest, WantsNothingForTensorsWithinTheTolerance) {
  const std::vector<VertexId> vertices = {VertexId(40), VertexId(41)};
  const std::vector<Metric> close = {Metric::Isotropic(0.1), Metric::Isotropic(0.099)};
  EXPECT_TRUE(followed_.SetTensors(vertices, close).value().vertices.empty());
  EXPECT_TRUE(followed_.Follows(spec_));
}

TEST_F(FollowedMetricTest, RefusesTensorsWithTheFirstBadIndex) {
  const Metric good = Metric::Isotropic(1);
  const auto index = [&](const std::vector<VertexId>& vertices, const std::vector<Metric>& tensors,
                         ErrorCode code) {
    const Status status = followed_.CheckTensors(vertices, tensors);
    EXPECT_FALSE(status.ok());
    if (status.ok()) return std::int64_t{-2};
    EXPECT_EQ(status.error().code, code) << status.error().message;
    return status.error().index;
  };
  const VertexId a(40);
  const VertexId b(3);
  EXPECT_EQ(index({a}, {good, good}, ErrorCode::kArrayLength), -1);
  EXPECT_EQ(index({a, VertexId(999)}, {good, good}, ErrorCode::kIndexOutOfRange), 1);
  EXPECT_EQ(index({a, b, a}, {good, good, good}, ErrorCode::kDuplicateId), 2);
  EXPECT_EQ(index({b, a, a}, {good, good, good}, ErrorCode::kDuplicateId), 2);
  EXPECT_EQ(index({a, b}, {good, {NAN, 0, 1}}, ErrorCode::kNotFinite), 1);
  EXPECT_EQ(index({a, b}, {{1, 2, 1}, good}, ErrorCode::kNotPositiveDefinite), 0);
  EXPECT_TRUE(followed_.CheckTensors(std::vector{a, b}, std::vector{good, good}).ok());
}

TEST_F(FollowedMetricTest, TakesTensorsOnlyAroundTheirVertices) {
  const std::vector<VertexId> vertices = {VertexId(40)};
  const std::vector<Metric> tensors = {Metric::Isotropic(0.05)};
  const WantedTensors wanted = followed_.SetTensors(vertices, tensors).value();
  EXPECT_EQ(wanted.vertices, vertices);
  EXPECT_NEAR(At({0.5, 0.5}).m11, 400, 1e-9);
  EXPECT_NEAR(At({0.5 + 1 / 16.0, 0.5}).m11, 200, 1e-9);  // Halfway, log-Euclidean.
  EXPECT_LT(RelativeChange(At({0.7, 0.5}), Metric::Isotropic(0.1)), 1e-7);
}

// Goal: the field stays that of the mesh when the update began, and a commit makes it that of the
// mesh as it has become.
TEST_F(FollowedMetricTest, MovesOnWithTheMeshAtACommit) {
  SetSize(VertexId(40), 0.05);
  const Metric between = At({0.5 + 1 / 16.0, 0.5});
  edit_.MoveVertex(VertexId(40), {0.53, 0.51});
  EXPECT_EQ(At({0.5 + 1 / 16.0, 0.5}), between);
  EXPECT_NEAR(At({0.5, 0.5}).m11, 400, 1e-9);
  Commit();
  EXPECT_NEAR(At({0.53, 0.51}).m11, 400, 1e-9);
  EXPECT_LT(At({0.5, 0.5}).m11, 390);
}

// Goal: few tensors and many of them make the same field. Method: the same tensors at all vertices,
// which is a copy, and at one, which is a mesh that is read.
TEST_F(FollowedMetricTest, FollowsFewTensorsLikeMany) {
  std::vector<Metric> all(81, Metric::Isotropic(0.1));
  all[40] = Metric::Isotropic(0.05);
  Take(followed_.SetTensors(LiveVertices(mesh_), all));
  const std::vector<Metric> many = Answers();
  Rollback();
  SetSize(VertexId(40), 0.05);
  const std::vector<Metric> few = Answers();
  for (std::size_t i = 0; i < few.size(); ++i) EXPECT_LT(RelativeChange(many[i], few[i]), 1e-12);
}

// Goal: tensors for all vertices, of which few are others than those followed, are no more than
// those few: who is within the tolerance stays. Where many are others, all that was sent holds.
TEST_F(FollowedMetricTest, FollowsOnlyWhatIsOtherWhereThatIsLittle) {
  constexpr double kWithinTolerance = 0.101;
  for (const std::size_t other_count : {1U, 20U}) {
    std::vector<Metric> all(81, Metric::Isotropic(kWithinTolerance));
    std::fill_n(all.begin(), other_count, Metric::Isotropic(0.05));
    const Result<WantedTensors> wanted = followed_.SetTensors(LiveVertices(mesh_), all);
    ASSERT_TRUE(wanted.ok());
    EXPECT_EQ(wanted->vertices.size(), other_count == 1 ? 1U : 81U);
    const double size = other_count == 1 ? 0.1 : kWithinTolerance;
    EXPECT_LT(RelativeChange(Metric::Isotropic(size), At(mesh_.position(VertexId(60)))), 1e-7);
    EXPECT_LT(RelativeChange(all[0], At(mesh_.position(VertexId(0)))), 1e-7);
    Rollback();
  }
}

TEST_F(FollowedMetricTest, LimitsWhereASizeJumps) {
  spec_.gradation = {.gradation = 1.5};
  SetSpec(spec_);
  Commit();
  const std::vector<VertexId> vertices = {VertexId(40)};
  const std::vector<Metric> tensors = {Metric::Isotropic(0.01)};
  const WantedTensors wanted = followed_.SetTensors(vertices, tensors).value();
  EXPECT_TRUE(followed_.limits_again());
  ASSERT_EQ(wanted.vertices.size(), wanted.tensors.size());
  // A neighbour may be larger by ln 1.5 times the distance.
  bool found = false;
  for (std::size_t i = 0; i < wanted.vertices.size(); ++i) {
    if (wanted.vertices[i] != VertexId(41)) continue;
    found = true;
    EXPECT_NEAR(wanted.tensors[i].m11, std::pow(0.01 + 0.4054651081 / 8, -2), 1e-3);
  }
  EXPECT_TRUE(found);
  EXPECT_GT(At({0.5 + 1 / 8.0, 0.5}).m11, 250);
  EXPECT_LT(RawAt({0.5 + 1 / 8.0, 0.5}).m11, 101);
}

// Goal: limits that have nothing to do leave the formula what it is, also between the vertices.
TEST_F(FollowedMetricTest, AsksTheFormulaWhereNothingIsLimited) {
  spec_.source = SizeMetric{"0.1 + 0.02*sin(20*x)"};
  SetSpec(spec_);
  const std::vector<Metric> as_sent = Answers();
  spec_.gradation = {.gradation = 1.5, .rotation = 0.7};
  SetSpec(spec_);
  EXPECT_EQ(Answers(), as_sent);
  Commit();
  EXPECT_EQ(Answers(), as_sent);
  EXPECT_FALSE(followed_.limits().limits_anything());
  spec_.source = SizeMetric{"x < 0.4 ? 0.01 : 0.3"};
  SetSpec(spec_);
  EXPECT_TRUE(followed_.limits().limits_anything());
  EXPECT_GT(At({0.45, 0.5}).m11, RawAt({0.45, 0.5}).m11);
  spec_.gradation = {};
  SetSpec(spec_);
  EXPECT_FALSE(followed_.limits().report().limits);
}

// Goal: a new formula costs what it changes in the limits, and gives what limiting anew gives.
// Method: the same formula by way of another one, and at once.
TEST_F(FollowedMetricTest, LimitsAnotherFormulaAsIfAnew) {
  const auto with_size = [&](const char* size) {
    MetricSpec spec{.source = SizeMetric{size}};
    spec.gradation = {.gradation = 1.4, .rotation = 0.7, .geometry = 0.5};
    return spec;
  };
  SetSpec(with_size("0.05 + 0.3*abs(x - 0.1)"));
  Commit();
  SetSpec(with_size("x < 0.02 ? 0.01 : 0.05 + 0.3*abs(x - 0.1)"));
  const std::vector<Metric> followed = Answers();
  const MetricReport report = followed_.limits().report();
  Rollback();
  SetSpec({.source = SizeMetric{"1"}});
  Commit();
  SetSpec(with_size("x < 0.02 ? 0.01 : 0.05 + 0.3*abs(x - 0.1)"));
  const std::vector<Metric> anew = Answers();
  for (std::size_t i = 0; i < anew.size(); ++i) {
    EXPECT_LT(RelativeChange(anew[i], followed[i]), 1e-12);
  }
  EXPECT_EQ(report.gradation_count, followed_.limits().report().gradation_count);
  EXPECT_EQ(report.limited_complexity, followed_.limits().report().limited_complexity);
}

// Goal: what was followed comes back to the bit, with limits and without.
TEST_F(FollowedMetricTest, RollsBack) {
  for (const double gradation : {0.0, 1.5}) {
    SCOPED_TRACE(gradation);
    spec_.gradation = {.gradation = gradation};
    SetSpec(spec_);
    SetSize(VertexId(3), 0.02);
    Commit();
    const std::vector<Metric> before = Answers();
    for (int round = 0; round < 3; ++round) {
      testing::RandomEditor editor(edited_, 9);
      for (int i = 0; i < 20; ++i) (void)editor.Step();
      SetSize(LiveVertices(mesh_)[30], 0.03);
      EXPECT_NE(Answers(), before);
      Rollback();
      EXPECT_EQ(Answers(), before);
    }
  }
}

}  // namespace
}  // namespace pliant
