#include "core/pliant/patch.h"

#include <gtest/gtest.h>

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

// Goal: where MaySwap says no, the search would find nothing; and it does say no, or it is useless.
TEST_F(PatchTest, MaySwapNeverHidesASwap) {
  Patch patch;
  MetricFlipper flipper(edit_);
  int spared_count = 0;
  const int count = ForEachFittingStar([&](const Star& star) {
    patch.Gather(mesh_, star);
    if (patch.MaySwap(mesh_, star)) return;
    ++spared_count;
    EXPECT_EQ(flipper.AroundMoved(star), 0) << "vertex " << star.center();
  });
  EXPECT_GT(4 * spared_count, count);
}

}  // namespace
}  // namespace pliant
