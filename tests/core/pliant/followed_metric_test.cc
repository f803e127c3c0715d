#include "core/pliant/followed_metric.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/rng.h"
#include "core/delaunay/import_mesh.h"
#include "core/mesh/mesh_edit.h"

namespace pliant {
namespace {

/// A grid of 8 x 8 cells over [0, 1]^2 that follows the size 0.1.
class FollowedMetricTest : public ::testing::Test {
 protected:
  void SetUp() override {
    MeshData grid;
    for (std::int32_t j = 0; j <= 8; ++j) {
      for (std::int32_t i = 0; i <= 8; ++i) grid.points.push_back({i / 8.0, j / 8.0});
    }
    for (std::int32_t j = 0; j < 8; ++j) {
      for (std::int32_t i = 0; i < 8; ++i) {
        const std::int32_t a = 9 * j + i;
        grid.triangles.push_back({a, a + 1, a + 10});
        grid.triangles.push_back({a, a + 10, a + 9});
      }
    }
    BuildFromPlan(PlanImport(grid).value(), edit_);
    FollowSpec();
  }

  void FollowSpec() {
    followed_.Follow(MakeMetricField(spec_, {{0, 0}, {1, 1}}).value(), &spec_);
    for (const VertexId vertex : LiveVertices(mesh_)) {
      edit_.SetMetric(vertex, At(mesh_.position(vertex)));
    }
  }

  Metric At(Vec2 p) const {
    std::int32_t hint = MetricField::kNoHint;
    return followed_.field().At(p, hint);
  }

  Mesh mesh_;
  MeshEdit edit_{mesh_};
  FollowedMetric followed_{edit_, 0.05};
  MetricSpec spec_{.source = SizeMetric{"0.1"}};
};

TEST_F(FollowedMetricTest, KnowsWhatItFollows) {
  EXPECT_TRUE(followed_.Follows(spec_));
  MetricSpec other = spec_;
  other.time = 1;
  EXPECT_FALSE(followed_.Follows(other));
  const std::vector<VertexId> vertices = {VertexId(40)};
  const std::vector<Metric> tensors = {Metric::Isotropic(0.05)};
  ASSERT_TRUE(followed_.SetTensors(vertices, tensors).ok());
  EXPECT_FALSE(followed_.Follows(spec_)) << "a tensor at a vertex makes it another metric";
}

TEST_F(FollowedMetricTest, WantsNothingForTensorsWithinTheTolerance) {
  const std::vector<VertexId> vertices = {VertexId(40), VertexId(41)};
  const std::vector<Metric> close = {Metric::Isotropic(0.1), Metric::Isotropic(0.099)};
  EXPECT_TRUE(followed_.SetTensors(vertices, close).value().vertices.empty());
  EXPECT_TRUE(followed_.Follows(spec_));
}

TEST_F(FollowedMetricTest, TakesTensorsOnlyAroundTheirVertices) {
  const std::vector<VertexId> vertices = {VertexId(40)};
  const std::vector<Metric> tensors = {Metric::Isotropic(0.05)};
  const WantedTensors wanted = followed_.SetTensors(vertices, tensors).value();
  EXPECT_EQ(wanted.vertices, vertices);
  EXPECT_NEAR(At({0.5, 0.5}).m11, 400, 1e-9);
  EXPECT_NEAR(At({0.5 + 1 / 16.0, 0.5}).m11, 200, 1e-9);  // Halfway, log-Euclidean.
  EXPECT_EQ(At({0.7, 0.5}), Metric::Isotropic(0.1));
}

TEST_F(FollowedMetricTest, LimitsWhereASizeJumps) {
  spec_.gradation = {.gradation = 1.5};
  FollowSpec();
  const std::vector<VertexId> vertices = {VertexId(40)};
  const std::vector<Metric> tensors = {Metric::Isotropic(0.01)};
  const WantedTensors wanted = followed_.SetTensors(vertices, tensors).value();
  EXPECT_TRUE(followed_.limits_again());
  ASSERT_EQ(wanted.vertices.size(), wanted.tensors.size());
  // A neighbour may be larger by ln 1.5 times the distance.
  for (std::size_t i = 0; i < wanted.vertices.size(); ++i) {
    if (wanted.vertices[i] != VertexId(41)) continue;
    EXPECT_NEAR(wanted.tensors[i].m11, std::pow(0.01 + 0.4054651081 / 8, -2), 1e-3);
  }
  EXPECT_GT(At({0.5 + 1 / 8.0, 0.5}).m11, 250);
}

// Goal: state() is everything; what was followed comes back to the bit.
TEST_F(FollowedMetricTest, RestoresItsState) {
  Rng rng(3);
  std::vector<Vec2> points;
  for (int i = 0; i < 200; ++i) points.push_back({rng.Uniform(0, 1), rng.Uniform(0, 1)});
  const auto answers = [&] {
    std::vector<Metric> metrics;
    for (const Vec2 p : points) metrics.push_back(At(p));
    return metrics;
  };
  const std::vector<VertexId> vertices = {VertexId(40), VertexId(3)};
  const std::vector<Metric> first = {Metric::Isotropic(0.05), Metric::Isotropic(0.02)};
  ASSERT_TRUE(followed_.SetTensors(vertices, first).ok());
  const FollowedMetric::State state = followed_.state();
  const std::vector<Metric> before = answers();
  const std::vector<Metric> second = {Metric::Isotropic(0.2), Metric::Isotropic(0.3)};
  ASSERT_TRUE(followed_.SetTensors(vertices, second).ok());
  EXPECT_NE(answers(), before);
  followed_.Restore(state);
  EXPECT_EQ(answers(), before);
}

}  // namespace
}  // namespace pliant
