#include "core/pliant/smooth.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "core/base/rng.h"
#include "core/mesh/star.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::GridData;
using testing::ImportedMesh;

// The four functions of figure 6 by hand.
TEST(SmoothingForce, PliantIsOneAtZeroZeroAtOneAndAttractsBeyond) {
  EXPECT_NEAR(SmoothingForce(Smoothing::kPliant, 1e-9), 1, 1e-12);
  EXPECT_EQ(SmoothingForce(Smoothing::kPliant, 1), 0);
  for (double d = 0.01; d < 4; d += 0.01) {
    const long double d4 = static_cast<long double>(d) * d * d * d;
    const long double expected = (1 - d4) * std::exp(-d4);
    EXPECT_NEAR(SmoothingForce(Smoothing::kPliant, d), static_cast<double>(expected), 1e-13) << d;
  }
  EXPECT_EQ(SmoothingForce(Smoothing::kPliant, 4.5), 0);
  EXPECT_EQ(SmoothingForce(Smoothing::kPliant, 1e100), 0);
}

TEST(SmoothingForce, LaplacianIsASpring) {
  for (const double d : {0.1, 1.0, 3.0}) EXPECT_EQ(SmoothingForce(Smoothing::kLaplacian, d), -d);
}

TEST(SmoothingForce, LennardJonesIsLimitedNearZero) {
  EXPECT_EQ(SmoothingForce(Smoothing::kLennardJones, 1), 0);
  EXPECT_EQ(SmoothingForce(Smoothing::kLennardJones, 2), std::pow(2, -13) - std::pow(2, -7));
  EXPECT_EQ(SmoothingForce(Smoothing::kLennardJones, 0.5), 1);
  EXPECT_EQ(SmoothingForce(Smoothing::kLennardJones, 1e-20), 1);
}

TEST(SmoothingForce, BubbleIsACubicThatReachesToOneAndAHalf) {
  EXPECT_EQ(SmoothingForce(Smoothing::kBubble, 0), 1.125);
  EXPECT_EQ(SmoothingForce(Smoothing::kBubble, 1), 0);
  EXPECT_NEAR(SmoothingForce(Smoothing::kBubble, 1.4999999), 0, 1e-6);
  EXPECT_EQ(SmoothingForce(Smoothing::kBubble, 1.5), 0);
  EXPECT_LT(SmoothingForce(Smoothing::kBubble, 1.25), 0);
}

/// The middle of a 2 x 2 grid, moved off its place, with random metrics around it.
struct Middle {
  explicit Middle(std::uint64_t seed) : made(ImportedMesh(GridData(2, 2))) {
    Rng rng(seed);
    made->edit.MoveVertex(node, {1 + rng.Uniform(-0.3, 0.3), 1 + rng.Uniform(-0.3, 0.3)});
    for (const VertexId id : testing::LiveVertices(made->mesh)) {
      made->edit.SetMetric(id, {rng.Uniform(1, 2), rng.Uniform(-0.5, 0.5), rng.Uniform(1, 2)});
    }
    star.Gather(made->mesh, node);
  }
  VertexId node{4};
  std::unique_ptr<testing::EditedMesh> made;
  Star star;
};

TEST(SmoothingStep, OfTheLaplacianLeadsToTheCentroidOfTheNeighbours) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Middle middle(seed);
    Vec2 centroid;
    for (const VertexId id : middle.star.ring()) {
      centroid += (1.0 / 6) * middle.made->mesh.position(id);
    }
    const Vec2 step = SmoothingStep(middle.made->mesh, middle.node, middle.star.ring(),
                                    Smoothing::kLaplacian, 0.123);
    const Vec2 end = middle.made->mesh.position(middle.node) + step;
    EXPECT_NEAR(end.x, centroid.x, 1e-14);
    EXPECT_NEAR(end.y, centroid.y, 1e-14);
  }
}

// Goal: the step is eq. 2. Method: the sum as the paper writes it, in long double.
TEST(SmoothingStep, IsTheSumOfForcesTimesDirections) {
  for (const Smoothing smoothing :
       {Smoothing::kPliant, Smoothing::kLennardJones, Smoothing::kBubble}) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const Middle middle(seed);
      const Mesh& mesh = middle.made->mesh;
      long double x = 0;
      long double y = 0;
      for (const VertexId id : middle.star.ring()) {
        const Vec2 e = mesh.position(middle.node) - mesh.position(id);
        const Metric& a = mesh.metric(middle.node);
        const Metric& b = mesh.metric(id);
        const long double m11 = (static_cast<long double>(a.m11) + b.m11) / 2;
        const long double m12 = (static_cast<long double>(a.m12) + b.m12) / 2;
        const long double m22 = (static_cast<long double>(a.m22) + b.m22) / 2;
        const long double d = std::sqrt(m11 * e.x * e.x + 2 * m12 * e.x * e.y + m22 * e.y * e.y);
        const long double f = SmoothingForce(smoothing, static_cast<double>(d));
        x += f / d * e.x;
        y += f / d * e.y;
      }
      const Vec2 step = SmoothingStep(mesh, middle.node, middle.star.ring(), smoothing, 0.3);
      EXPECT_NEAR(step.x, static_cast<double>(0.3L * x), 1e-13);
      EXPECT_NEAR(step.y, static_cast<double>(0.3L * y), 1e-13);
    }
  }
}

}  // namespace
}  // namespace pliant
