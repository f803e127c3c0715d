#include "core/pliant/crowd.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/delaunay/import_mesh.h"
#include "core/mesh/mesh_edit.h"
#include "core/pliant/extent.h"
#include "core/pliant/patch.h"
#include "core/pliant/smooth.h"

namespace pliant {
namespace {

/// A vertex in the middle of eight, of which four are given and 0.4 apart; the metric has size 1.
class CrowdTest : public ::testing::Test {
 protected:
  CrowdTest() : edit_(mesh_) {
    MeshData data;
    data.points = {{-0.6, -0.7}, {-0.2, -0.8}, {0.2, -0.8}, {0.6, -0.7},
                   {1, 0.2},     {0.5, 1},     {-0.5, 1},   {-1, 0.2}};
    for (int k = 0; k < 8; ++k) data.triangles.push_back({k, (k + 1) % 8, 8});
    data.points.push_back({0.05, 0});
    BuildFromPlan(*PlanImport(data), edit_);
    for (std::int32_t v = 0; v < mesh_.vertex_slots(); ++v) {
      edit_.SetMetric(VertexId(v), Metric::Isotropic(1));
      if (v >= 4 && mesh_.vertex(VertexId(v)).fixed) edit_.Unfix(VertexId(v));
      if (v < 4) edit_.Fix(VertexId(v));
    }
    star_.Gather(mesh_, VertexId(8));
    crowd_.Measure(mesh_, star_);
  }
  [[nodiscard]] double Length(int a, int b) const {
    return pliant::Length(mesh_.position(VertexId(a)) - mesh_.position(VertexId(b)));
  }

  Mesh mesh_;
  MeshEdit edit_;
  Star star_;
  Crowd crowd_;
};

// Goal: crowded vertices push as their edges are long, and count as many as these; others count as
// ever.
TEST_F(CrowdTest, CountsWhatEdgesAreLong) {
  const double side = Length(0, 1);
  const double middle = Length(1, 2);
  ASSERT_TRUE(crowd_.is_any());
  EXPECT_NEAR(crowd_.NeighborCount(8), 5 + 2 * side + middle, 1e-15);
  for (std::size_t k = 0; k < 8; ++k) {
    const int vertex = star_.ring()[k].value();
    const bool is_end = vertex == 0 || vertex == 3;
    const double weight = is_end ? side : vertex < 4 ? 0.5 * (side + middle) : 1;
    EXPECT_NEAR(crowd_.weights()[k], weight, 1e-15) << vertex;
  }
}

// Goal: given vertices at a good distance from each other change nothing.
TEST_F(CrowdTest, IsNoneWhereGivenVerticesHaveRoom) {
  for (std::int32_t v = 0; v < mesh_.vertex_slots(); ++v) {
    edit_.SetMetric(VertexId(v), Metric::Isotropic(0.4));
  }
  crowd_.Measure(mesh_, star_);
  EXPECT_FALSE(crowd_.is_any());
  EXPECT_TRUE(crowd_.weights().empty());
  EXPECT_EQ(crowd_.NeighborCount(8), 8);
}

// Goal: the visit by columns sees the same crowd as the plain one, bit for bit, and a node beside a
// crowd is driven less far away, and deleted later, than if every vertex counted in full.
TEST_F(CrowdTest, IsTheSameInColumns) {
  Patch patch;
  patch.Gather(mesh_, star_);
  patch.Measure();
  const Vec2 plain = SmoothingStep(mesh_, VertexId(8), star_.ring(), Smoothing::kPliant, 0.3);
  const Vec2 eased =
      SmoothingStep(mesh_, VertexId(8), star_.ring(), Smoothing::kPliant, 0.3, crowd_.weights());
  EXPECT_EQ(patch.Step(0.3), eased);
  EXPECT_LT(eased.y, plain.y);
  EXPECT_EQ(patch.MeasureExtents().node, NodeExtent(mesh_, star_, crowd_));
  EXPECT_GT(patch.MeasureExtents().node, NodeExtent(mesh_, star_));
}

}  // namespace
}  // namespace pliant
