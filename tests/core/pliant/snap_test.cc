#include "core/pliant/snap.h"

#include <gtest/gtest.h>

#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::DifferenceOf;
using testing::Faults;
using testing::GridData;
using testing::ImportedMesh;

bool Snap(testing::EditedMesh& made, VertexId id, Vec2 target) {
  Star star;
  star.Gather(made.mesh, id);
  return SnapToCrossedEdge(made.edit, star, target);
}

TEST(SnapToCrossedEdge, PutsANodeThatLeavesTheDomainOnTheBoundary) {
  const auto made = ImportedMesh(GridData(3, 3));
  ASSERT_TRUE(Snap(*made, VertexId(5), {0.75, -1}));  // From (1, 1) over the bottom at x = 0.875.
  EXPECT_EQ(Faults(made->mesh), "");
  EXPECT_NEAR(made->mesh.position(VertexId(5)).x, 0.875, 1e-15);
  EXPECT_EQ(made->mesh.position(VertexId(5)).y, 0);
  const auto [before, after] = made->mesh.SegmentEdges(VertexId(5));
  EXPECT_EQ(made->mesh.edge(before).vertices[0], VertexId(0));
  EXPECT_EQ(made->mesh.edge(after).vertices[1], VertexId(1));
  EXPECT_EQ(made->mesh.triangle_count(), 17);
  EXPECT_EQ(testing::RegionAreas(made->mesh).at(0), 9);
}

TEST(SnapToCrossedEdge, PutsANodeOnAnInternalConstraintAndKeepsTheRegions) {
  MeshData data = GridData(4, 4);
  for (std::size_t t = 0; t < 32; ++t) data.triangle_tags.push_back(t < 16 ? 1 : 2);
  const auto made = ImportedMesh(data);
  ASSERT_TRUE(Snap(*made, VertexId(7), {2.25, 3}));  // From (2, 1) over the line y = 2.
  EXPECT_EQ(Faults(made->mesh), "");
  EXPECT_EQ(made->mesh.position(VertexId(7)).y, 2);
  EXPECT_EQ(testing::RegionAreas(made->mesh).at(1), 8);
  EXPECT_EQ(testing::RegionAreas(made->mesh).at(2), 8);
  EXPECT_EQ(made->mesh.triangle_count(), 32);
}

TEST(SnapToCrossedEdge, RefusesAnEdgeThatIsNotConstrained) {
  const auto made = ImportedMesh(GridData(4, 4));
  const Mesh before = made->mesh;
  EXPECT_FALSE(Snap(*made, VertexId(12), {3.5, 2.4}));
  EXPECT_FALSE(Snap(*made, VertexId(12), {2.1, 2.1})) << "does not even leave the star";
  EXPECT_EQ(DifferenceOf(made->mesh, before), "");
}

// Goal: whatever the target, the mesh is valid afterwards, and untouched where the snap is refused.
TEST(SnapToCrossedEdge, LeavesAValidMeshForRandomStarsAndTargets) {
  int snapped = 0;
  int refused = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const auto made = ImportedMesh(GridData(3, 3));
    testing::RandomEditor editor(*made, seed);
    for (int i = 0; i < 100; ++i) editor.Step();
    for (const VertexId id : testing::LiveVertices(made->mesh)) {
      if (made->mesh.vertex(id).edge.valid()) continue;
      const Mesh before = made->mesh;
      const Vec2 target{editor.rng().Uniform(-3, 6), editor.rng().Uniform(-3, 6)};
      if (Snap(*made, id, target)) {
        ++snapped;
        ASSERT_EQ(Faults(made->mesh), "") << "seed " << seed << " vertex " << id;
        ASSERT_NEAR(testing::RegionAreas(made->mesh).at(0), 9, 1e-12);
      } else {
        ++refused;
        ASSERT_EQ(DifferenceOf(made->mesh, before), "");
      }
    }
  }
  EXPECT_GT(snapped, 20);
  EXPECT_GT(refused, 20);
}

}  // namespace
}  // namespace pliant
