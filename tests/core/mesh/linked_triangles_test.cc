#include "core/mesh/linked_triangles.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/mesh/export_mesh.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

// Goal: the triangles are those of ExportMesh, and the neighbours those that FindNeighbors finds by
// their sides. Method: a mesh with holes in its numbering, after random edits.
TEST(LinkTriangles, AreThoseOfTheMeshWithTheirNeighbors) {
  const auto made = testing::ImportedMesh(testing::GridData(12, 9));
  testing::RandomEditor editor(*made, /*seed=*/7);
  for (int round = 0; round < 20; ++round) {
    for (int i = 0; i < 30; ++i) (void)editor.Step();
    const ExportedMesh exported = ExportMesh(made->mesh);
    const MeshTriangles triangles = LinkTriangles(made->mesh);
    ASSERT_TRUE(std::ranges::equal(triangles.linked.points, exported.data.points))
        << "seed 7, round " << round;
    const auto across = FindNeighbors(exported.data.triangles,
                                      static_cast<std::int32_t>(exported.data.points.size()))
                            .across;
    ASSERT_EQ(triangles.linked.triangles.size(), exported.data.triangles.size());
    for (std::size_t t = 0; t < across.size(); ++t) {
      ASSERT_EQ(triangles.linked.triangles[t].corners, exported.data.triangles[t]);
      ASSERT_EQ(triangles.linked.triangles[t].neighbors, across[t]);
    }
    for (std::size_t rank = 0; rank < exported.triangle_ids.size(); ++rank) {
      ASSERT_EQ(triangles.rank_of[exported.triangle_ids[rank].index()],
                static_cast<std::int32_t>(rank));
    }
  }
}

TEST(LinkTriangles, CanBeStopped) {
  const auto made = testing::ImportedMesh(testing::GridData(12, 9));
  const StopFlag stop(true);
  EXPECT_TRUE(LinkTriangles(made->mesh, &stop).linked.triangles.empty());
}

}  // namespace
}  // namespace pliant
