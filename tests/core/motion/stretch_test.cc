// Goal: whatever a motion does to lengths and angles, what comes out is as good as a mesh that is
// made for the place, also where nobody moves against a neighbour. Method: domains that are mapped
// as a whole, there and back, at once and in small steps.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "core/geometry/domain.h"
#include "core/metric/metric_spec.h"
#include "core/motion/move.h"
#include "core/pliant/quality.h"
#include "core/pliant/remesher.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

class Stretch : public ::testing::Test {
 protected:
  void Start(Vec2 extent, const char* size) {
    auto made =
        Remesher::Create(testing::Rectangle({0, 0}, extent), {.source = SizeMetric{size}}, {});
    ASSERT_TRUE(made.ok());
    remesher_ = std::move(*made);
    ASSERT_TRUE(remesher_->Step({}).ok());
    (void)remesher_->Commit();
  }

  /// A channel as wide as its mesh is fine: every vertex is on the boundary, and all move alike.
  void StartChannel(const char* size) { Start({5, 0.05}, size); }

  /// Moves all sides, and lets the loop run. @return its visits
  std::int64_t Map(PathShape shape) {
    MotionRequest request;
    request.tags.push_back({{1, 2, 3, 4}, std::move(shape)});
    EXPECT_TRUE(MoveVertices(*remesher_, request).ok());
    const auto progress = remesher_->Step({});
    EXPECT_TRUE(progress.ok());
    EXPECT_EQ(testing::Faults(remesher_->mesh()), "");
    return progress.ok() ? progress->counts.visits : -1;
  }

  double MeanQuality() const {
    return MeasureQuality(remesher_->mesh(), remesher_->field()).q_mean;
  }
  std::int32_t VertexCount() const { return remesher_->mesh().vertex_count(); }

 private:
  std::unique_ptr<Remesher> remesher_;
};

TEST_F(Stretch, ADomainTenfoldAndBack) {
  ASSERT_NO_FATAL_FAILURE(Start({1, 1}, "0.05"));
  Map(AffineMap{10, 0, 0, 1, {0, 0}});
  EXPECT_GT(MeanQuality(), 0.95);
  Map(AffineMap{0.1, 0, 0, 1, {0, 0}});
  EXPECT_GT(MeanQuality(), 0.95);
}

TEST_F(Stretch, AChannelThatIsWidenedGetsNewNodes) {
  ASSERT_NO_FATAL_FAILURE(StartChannel("0.05"));
  Map(AffineMap{1, 0, 0, 10, {0, 0}});
  EXPECT_GT(MeanQuality(), 0.95);
  EXPECT_GT(VertexCount(), 1000);
}

TEST_F(Stretch, AChannelThatGrowsInManySmallStepsGetsNewNodes) {
  ASSERT_NO_FATAL_FAILURE(StartChannel("0.05"));
  double area = 0.25;
  for (int i = 0; i < 8; ++i) {
    Map(AffineMap{1.3, 0, 0, 1.3, {0, 0}});
    area *= 1.3 * 1.3;
  }
  EXPECT_GT(MeanQuality(), 0.93);
  // As many vertices as half the equilateral triangles; those of the boundary come on top.
  const double ideal = area / (0.05 * 0.05 * std::sqrt(0.75));
  EXPECT_GT(VertexCount(), 0.95 * ideal);
  EXPECT_LT(VertexCount(), 1.35 * ideal);
}

TEST_F(Stretch, AChannelThatIsShearedAndShearedBackIsAsGoodAsBefore) {
  ASSERT_NO_FATAL_FAILURE(StartChannel("0.02"));
  Map(AffineMap{1, 20, 0, 1, {0, 0}});
  Map(AffineMap{1, -20, 0, 1, {0, 0}});
  EXPECT_GT(MeanQuality(), 0.9);
}

TEST_F(Stretch, WhatTurnsAsAWholeWakesNobody) {
  ASSERT_NO_FATAL_FAILURE(StartChannel("0.05"));
  EXPECT_EQ(Map(Rotation{{1, 1}, 0.5}), 0);
}

}  // namespace
}  // namespace pliant
