// A finely drawn body that turns in its layer: MoveVertices, the loop and mending together.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <utility>

#include "core/metric/function_field.h"
#include "core/motion/move.h"
#include "core/pliant/quality.h"
#include "core/pliant/remesher.h"
#include "tests/support/cases.h"

namespace pliant {
namespace {

constexpr std::int32_t kDisc = 7;
constexpr Vec2 kCenter{0.4, 0.5};
constexpr Vec2 kRadii{0.25, 0.05};

/// The size grows with the distance from the ellipse and is four times smaller across than along.
struct BodyLayer {
  double turn = 0;

  Metric operator()(Vec2 p) const {
    const Vec2 axis{std::cos(turn), std::sin(turn)};
    const Vec2 arm = p - kCenter;
    const Vec2 at{Dot(arm, axis) / kRadii.x, Cross(axis, arm) / kRadii.y};
    const double level = Length(at);
    const Vec2 slope{at.x / kRadii.x, at.y / kRadii.y};
    const double steepness = std::max(1e-12, Length(slope));
    const double distance = std::max(0.0, level * (level - 1) / steepness);
    const double along = (0.02 + 0.15 * distance) / 2.25;
    const double across = along / (1 + 3 * std::exp(-distance / 0.05));
    const Vec2 normal = (1 / steepness) * slope;
    const Vec2 n{normal.x * axis.x - normal.y * axis.y, normal.x * axis.y + normal.y * axis.x};
    const double low = 1 / (along * along);
    const double excess = 1 / (across * across) - low;
    return {low + excess * n.x * n.x, excess * n.x * n.y, low + excess * n.y * n.y};
  }
};

Domain SquareWithFlap() {
  Domain domain = testing::Rectangle({0, 0}, {1, 1});
  constexpr std::int32_t kCount = 180;
  for (std::int32_t i = 0; i < kCount; ++i) {
    const double t = 2 * std::numbers::pi * i / kCount;
    domain.points.push_back(kCenter + Vec2{kRadii.x * std::cos(t), kRadii.y * std::sin(t)});
    domain.segments.push_back({4 + i, 4 + (i + 1) % kCount, kDisc});
  }
  domain.holes.push_back(kCenter);
  return domain;
}

// Goal: where the points of the body are closer together than the metric asks for, down to a fifth
// of the wanted length at the tips, the triangles beside them are good all the same, and stay so
// through a full turn.
TEST(Body, IsFinelyDrawnAndHasGoodTrianglesBesideIt) {
  auto made = Remesher::Create(SquareWithFlap(),
                               std::make_unique<FunctionField<BodyLayer>>(BodyLayer{}), Options{});
  ASSERT_TRUE(made.ok()) << made.error().message;
  Remesher& remesher = **made;
  ASSERT_TRUE(remesher.Step({}).ok());
  (void)remesher.Commit();
  const double nodes = remesher.mesh().vertex_count();
  MotionRequest motion;
  motion.tags = {{{kDisc}, Rotation{kCenter, std::numbers::pi / 18}}};
  motion.follow_length = 100;
  for (int step = 0; step <= 36; ++step) {
    SCOPED_TRACE(step);
    const BodyLayer layer{step * std::numbers::pi / 18};
    if (step > 0) {
      ASSERT_TRUE(MoveVertices(remesher, motion).ok());
      ASSERT_TRUE(remesher.SetField(std::make_unique<FunctionField<BodyLayer>>(layer)).ok());
      const auto progress = remesher.Step({});
      ASSERT_TRUE(progress.ok());
      EXPECT_EQ(progress->stop_reason, StopReason::kConverged);
      (void)remesher.Commit();
    }
    const Quality quality = MeasureQuality(remesher.mesh(), remesher.field());
    EXPECT_GE(quality.q_min, 0.48);
    EXPECT_LE(quality.averaged.max, 1.5);
    EXPECT_GE(quality.q_mean, 0.975);
    EXPECT_NEAR(remesher.mesh().vertex_count(), nodes, 0.05 * nodes);
  }
}

}  // namespace
}  // namespace pliant
