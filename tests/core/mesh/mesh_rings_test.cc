#include "core/mesh/mesh_rings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using ::testing::UnorderedElementsAre;
using ::testing::UnorderedElementsAreArray;

TEST(MeshRings, AreTheEndsOfTheEdgesAtAVertex) {
  const auto made = testing::ImportedMesh(testing::GridData(2, 2));
  MeshRings rings(made->mesh);
  EXPECT_THAT(rings.Neighbors(4), UnorderedElementsAre(0, 1, 5, 8, 7, 3));
  EXPECT_THAT(rings.Neighbors(2), UnorderedElementsAre(1, 5));
  EXPECT_EQ(rings.position(5), (Vec2{2, 1}));
  EXPECT_EQ(rings.Area(4), 1);
  EXPECT_NEAR(rings.Area(2), 1.0 / 6, 1e-15);
}

// Goal: rings that are remembered are those of the mesh, also where two share a place in memory.
// Method: a mesh with more vertices than are remembered, each asked twice and in between others.
TEST(MeshRings, AreTheSameWhenAskedAgain) {
  const auto made = testing::ImportedMesh(testing::GridData(100, 60));
  MeshRings rings(made->mesh);
  Star star;
  const std::int32_t count = made->mesh.vertex_slots();
  for (const std::int32_t step : {1, 1, 4096, 1777}) {
    for (std::int32_t i = 0; i < count; ++i) {
      const auto v = static_cast<std::int32_t>(std::int64_t{i} * step % count);
      star.Gather(made->mesh, VertexId(v));
      ASSERT_TRUE(std::ranges::equal(rings.Neighbors(v), star.ring(), {}, {}, &VertexId::value))
          << "vertex " << v;
    }
  }
}

// Two triangles that touch at a point: its ring is that of both.
TEST(MeshRings, JoinTheFansOfAPinchedVertex) {
  MeshData data;
  data.points = {{0, 0}, {1, 0}, {0, 1}, {-1, 0}, {0, -1}};
  data.triangles = {{0, 1, 2}, {0, 3, 4}};
  const auto made = testing::ImportedMesh(data);
  ASSERT_TRUE(made->mesh.vertex(VertexId(0)).pinched);
  MeshRings rings(made->mesh);
  EXPECT_THAT(rings.Neighbors(0), UnorderedElementsAreArray({1, 2, 3, 4}));
  EXPECT_NEAR(rings.Area(0), 1.0 / 3, 1e-15);
}

}  // namespace
}  // namespace pliant
