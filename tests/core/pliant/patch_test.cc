#include "core/pliant/patch.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>

#include "core/delaunay/import_mesh.h"
#include "core/delaunay/metric_flip.h"
#include "core/geometry/predicates.h"
#include "core/pliant/extent.h"
#include "core/pliant/loop.h"
#include "core/pliant/smooth.h"
#include "tests/support/cases.h"

namespace pliant {
namespace {

/// A mesh that the loop has not finished: all degrees, good and bad triangles.
class PatchTest : public ::testing::Test {
 protected:
  PatchTest() : case_(testing::GaussianCase(3000)), edit_(mesh_), loop_(edit_, Options{}) {
    const auto plan = PlanDomain(case_.domain);
    BuildFromPlan(*plan, edit_);
    loop_.BeginUpdate(SettingsOf(Options{}));
    std::int32_t hint = MetricField::kNoHint;
    for (std::int32_t v = 0; v < mesh_.vertex_slots(); ++v) {
      edit_.SetMetric(VertexId(v), case_.field->At(mesh_.position(VertexId(v)), hint));
      loop_.Wake(VertexId(v));
    }
    Budget budget;
    budget.visits_max = 6000;
    EXPECT_EQ(loop_.Run(*case_.field, budget), StopReason::kVisitBudget);
  }

  /// Calls function(star) for every interior vertex whose star fits. @return how many
  template <class Function>
  int ForEachFittingStar(Function function) {
    int count = 0;
    Star star;
    for (std::int32_t v = 0; v < mesh_.vertex_slots(); ++v) {
      if (!mesh_.IsLive(VertexId(v)) || mesh_.vertex(VertexId(v)).edge.valid()) continue;
      star.Gather(mesh_, VertexId(v));
      if (!Patch::Fits(star)) continue;
      function(star);
      ++count;
    }
    return count;
  }

  testing::Case case_;
  Mesh mesh_;
  MeshEdit edit_;
  PliantLoop loop_;
};

// Goal: columns are only another way to compute the same numbers.
// Method: bit for bit against the plain functions, on every star of an unfinished mesh.
TEST_F(PatchTest, StepAndExtentsAreThoseOfThePlainFunctions) {
  Patch patch;
  const int count = ForEachFittingStar([&](const Star& star) {
    SCOPED_TRACE(::testing::Message() << "vertex " << star.center());
    patch.Gather(mesh_, star);
    patch.Measure();
    EXPECT_EQ(patch.Step(0.3),
              SmoothingStep(mesh_, star.center(), star.ring(), Smoothing::kPliant, 0.3));
    const Patch::Extents extents = patch.MeasureExtents();
    EXPECT_EQ(extents.node, NodeExtent(mesh_, star));
    const SpokeExtent largest = LargestSpokeExtent(mesh_, star);
    EXPECT_EQ(extents.largest, largest.extent);
    EXPECT_EQ(extents.largest_spoke, largest.spoke);
  });
  EXPECT_GT(count, 1000);
}

TEST_F(PatchTest, StaysPositiveIsAskedOfEveryTriangle) {
  Patch patch;
  int refused_count = 0;
  ForEachFittingStar([&](const Star& star) {
    patch.Gather(mesh_, star);
    // Beyond one ring vertex, where it may or may not stay positive.
    const Vec2 p = mesh_.position(star.center());
    const Vec2 target = p + 0.6 * (mesh_.position(star.ring().front()) - p);
    bool positive = true;
    for (std::size_t k = 0; k < star.ring().size(); ++k) {
      positive = positive && Orient2d(target, mesh_.position(star.ring()[k]),
                                      mesh_.position(star.ring_after(k))) > 0;
    }
    EXPECT_EQ(patch.StaysPositive(target), positive);
    refused_count += positive ? 0 : 1;
  });
  EXPECT_GT(refused_count, 0);
}

/// WantsSwap of the edge between ring vertices or spoke ends a and b, opposite p and q.
bool EdgeWantsSwap(const Mesh& mesh, std::array<VertexId, 4> p_a_q_b) {
  const auto& [p, a, q, b] = p_a_q_b;
  const Metric mean = 0.25 * (mesh.metric(p) + mesh.metric(a) + mesh.metric(b) + mesh.metric(q));
  return WantsSwap(mesh.position(b), mesh.position(p), mesh.position(a), mesh.position(q), mean);
}

/// The cosine of the angle at the center of triangle k of a star, in the mean of its metrics.
double CosineAtCenter(const Mesh& mesh, const Star& star, std::size_t k) {
  const VertexId a = star.ring()[k];
  const VertexId b = star.ring_after(k);
  const Metric sum = mesh.metric(star.center()) + mesh.metric(a) + mesh.metric(b);
  const Vec2 u = mesh.position(a) - mesh.position(star.center());
  const Vec2 v = mesh.position(b) - mesh.position(star.center());
  return InnerProduct(sum, u, v) / std::sqrt(SquaredLength(sum, u) * SquaredLength(sum, v));
}

// Goal: the columns find every spoke that wants to be swapped, and every edge of the link that does
// and lies opposite an angle of more than 75 degrees, and cause no search without a find.
// Method: the plain test on every edge. Edges of the link opposite smaller angles may be passed
// over; they are few.
TEST_F(PatchTest, WantsSwapsFindsWhatThePlainTestFinds) {
  Patch patch;
  int found_count = 0;
  int passed_over_count = 0;
  const int count = ForEachFittingStar([&](const Star& star) {
    SCOPED_TRACE(::testing::Message() << "vertex " << star.center());
    bool expected = false;
    bool in_link = false;
    const std::size_t n = star.ring().size();
    for (std::size_t k = 0; k < n; ++k) {
      const VertexId a = star.ring()[k];
      const VertexId b = star.ring_after(k);
      expected |= EdgeWantsSwap(mesh_, {star.ring()[(k + n - 1) % n], a, b, star.center()});
      const TriangleId inner = star.triangles()[k];
      const auto side = static_cast<std::size_t>(mesh_.CornerOf(inner, star.center()));
      if (mesh_.triangle(inner).IsConstrained(side)) continue;
      const TriangleId outer = mesh_.triangle(inner).neighbors[side];
      const auto back = static_cast<std::size_t>(mesh_.SideTowards(outer, inner));
      if (!EdgeWantsSwap(mesh_, {star.center(), a, mesh_.triangle(outer).vertices[back], b})) {
        continue;
      }
      (CosineAtCenter(mesh_, star, k) < std::cos(1.3091) ? expected : in_link) = true;
    }
    patch.Gather(mesh_, star);
    patch.Measure();
    EXPECT_EQ(patch.WantsSwaps(mesh_, star), expected);
    found_count += expected ? 1 : 0;
    passed_over_count += in_link && !expected ? 1 : 0;
  });
  EXPECT_GT(found_count, 10);
  EXPECT_LT(100 * passed_over_count, count);
}

}  // namespace
}  // namespace pliant
