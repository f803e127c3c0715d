#include "core/pliant/extent.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::ImportedMesh;

/// Six equilateral unit triangles around vertex 0.
MeshData Hexagon() {
  MeshData data;
  data.points = {{0, 0},
                 {1, 0},
                 {0.5, testing::kEquilateralHeight},
                 {-0.5, testing::kEquilateralHeight},
                 {-1, 0},
                 {-0.5, -testing::kEquilateralHeight},
                 {0.5, -testing::kEquilateralHeight}};
  for (std::int32_t i = 1; i <= 6; ++i) data.triangles.push_back({0, i, i % 6 + 1});
  return data;
}

Star StarOf(const Mesh& mesh, VertexId id) {
  Star star;
  star.Gather(mesh, id);
  return star;
}

// 2.3 / sqrt(6 * 4) times six times sqrt(3)/4: near 1, so that a perfect node stays.
TEST(NodeExtent, OfTheMiddleOfAUnitHexagonIsNearOne) {
  const auto made = ImportedMesh(Hexagon());
  const double extent = NodeExtent(made->mesh, StarOf(made->mesh, VertexId(0)));
  EXPECT_NEAR(extent, 2.3 / std::sqrt(24.0) * 6 * testing::kEquilateralHeight / 2, 1e-14);
  EXPECT_NEAR(extent, 1.2197, 1e-4);
}

TEST(NodeExtent, GrowsWithTheMetricAndFallsWithTheDegree) {
  const auto made = ImportedMesh(Hexagon());
  const double once = NodeExtent(made->mesh, StarOf(made->mesh, VertexId(0)));
  for (const VertexId id : testing::LiveVertices(made->mesh)) {
    made->edit.SetMetric(id, {4, 0, 4});
  }
  EXPECT_NEAR(NodeExtent(made->mesh, StarOf(made->mesh, VertexId(0))), 4 * once, 1e-13);
}

// Half the square of the two edges on the segment: 2 for two unit edges, whatever else is there.
TEST(NodeExtent, OnASegmentCountsItsTwoEdgesThere) {
  const auto made = ImportedMesh(testing::GridData(2, 1));
  EXPECT_DOUBLE_EQ(NodeExtent(made->mesh, StarOf(made->mesh, VertexId(1))), 2);
  made->edit.SetMetric(VertexId(0), {9, 0, 1});
  // Eq. 4 takes the mean metric: the left edge has length sqrt(5).
  const double sum = 1 + std::sqrt(5.0);
  EXPECT_DOUBLE_EQ(NodeExtent(made->mesh, StarOf(made->mesh, VertexId(1))), 0.5 * sum * sum);
}

TEST(LargestSpokeExtent, OfAUnitHexagonIsBelowOneAndTheFirstOfEquals) {
  const auto made = ImportedMesh(Hexagon());
  const SpokeExtent largest = LargestSpokeExtent(made->mesh, StarOf(made->mesh, VertexId(0)));
  EXPECT_NEAR(largest.extent, 0.8 * 2 * testing::kEquilateralHeight / 2, 1e-14);
}

TEST(LargestSpokeExtent, FindsTheSpokeBetweenTheLargestTriangles) {
  MeshData data = Hexagon();
  data.points[3] = {-2, 4 * testing::kEquilateralHeight};
  const auto made = ImportedMesh(data);
  const Star star = StarOf(made->mesh, VertexId(0));
  const SpokeExtent largest = LargestSpokeExtent(made->mesh, star);
  EXPECT_EQ(star.ring()[largest.spoke], VertexId(3));
  // The triangles 0 2 3 and 0 3 4: half the cross products.
  const double first =
      0.5 * (0.5 * 4 * testing::kEquilateralHeight + 2 * testing::kEquilateralHeight);
  const double second = 0.5 * 4 * testing::kEquilateralHeight;
  EXPECT_NEAR(largest.extent, 0.8 * (first + second), 1e-12);
}

TEST(LargestSpokeExtent, MeasuresConstrainedSpokesByTheirLength) {
  MeshData data = testing::GridData(2, 1);
  for (Vec2& p : data.points) p.x *= 3;  // Edges of length 3 along the bottom.
  const auto made = ImportedMesh(data);
  const Star star = StarOf(made->mesh, VertexId(1));
  const SpokeExtent largest = LargestSpokeExtent(made->mesh, star);
  EXPECT_DOUBLE_EQ(largest.extent, 4.5);
  EXPECT_TRUE(made->mesh.FindEdge(VertexId(1), star.ring()[largest.spoke]).valid());
}

// A spoke that may not be split gives way to the next; where none may, there is none.
TEST(LargestFreeSpokeExtent, PassesOverWhatIsFrozen) {
  const auto made = ImportedMesh(Hexagon());
  const Star star = StarOf(made->mesh, VertexId(0));
  made->edit.SetMetric(VertexId(3), {4, 0, 4});
  const Permissions all;
  EXPECT_EQ(LargestFreeSpokeExtent(made->mesh, star, all).spoke,
            LargestSpokeExtent(made->mesh, star).spoke);
  for (const TriangleId id : star.triangles()) {
    made->edit.SetHold(id, MeshEdit::Hold::kFrozen);
  }
  EXPECT_FALSE(MaySplit(made->mesh, star, 0, all));
  EXPECT_EQ(LargestFreeSpokeExtent(made->mesh, star, all).extent, 0);
  made->edit.SetHold(star.triangles()[4], MeshEdit::Hold::kFree);
  EXPECT_EQ(LargestFreeSpokeExtent(made->mesh, star, all).spoke, 4U);
}

TEST(MaySplit, LeavesAFrozenEdgeAndAKeptSurfaceAlone) {
  const auto made = ImportedMesh(testing::GridData(2, 1));
  const Star star = StarOf(made->mesh, VertexId(1));  // In the middle of the lower side.
  const EdgeId edge = made->mesh.FindEdge(VertexId(1), star.ring()[0]);
  ASSERT_TRUE(edge.valid());
  EXPECT_TRUE(MaySplit(made->mesh, star, 0, {}));
  EXPECT_FALSE(MaySplit(made->mesh, star, 0, {.surface = false}));
  EXPECT_TRUE(MaySplit(made->mesh, star, 1, {.surface = false}));
  made->edit.SetHold(edge, MeshEdit::Hold::kFrozen);
  EXPECT_FALSE(MaySplit(made->mesh, star, 0, {}));
  EXPECT_TRUE(MaySplit(made->mesh, star, 1, {}));
}

}  // namespace
}  // namespace pliant
