#include "core/mesh/star.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <span>
#include <vector>

#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using ::testing::ElementsAre;
using testing::GridData;
using testing::ImportedMesh;

std::vector<int> Values(std::span<const VertexId> ids) {
  std::vector<int> values;
  for (const VertexId id : ids) values.push_back(id.value());
  return values;
}

/// Turns the list so that it begins with its smallest entry.
std::vector<int> Rotated(std::vector<int> values) {
  std::rotate(values.begin(), std::min_element(values.begin(), values.end()), values.end());
  return values;
}

TEST(Star, OfAnInteriorVertexRunsOnceAroundCounterClockwise) {
  const auto made = ImportedMesh(GridData(2, 2));
  Star star;
  for (const TriangleId start : testing::LiveTriangles(made->mesh)) {
    const auto& corners = made->mesh.triangle(start).vertices;
    if (std::find(corners.begin(), corners.end(), VertexId(4)) == corners.end()) continue;
    star.Gather(made->mesh, VertexId(4), start);
    EXPECT_TRUE(star.closed());
    EXPECT_EQ(star.center(), VertexId(4));
    EXPECT_THAT(Rotated(Values(star.ring())), ElementsAre(0, 1, 5, 8, 7, 3));
    ASSERT_EQ(star.triangles().size(), 6U);
    for (std::size_t k = 0; k < 6; ++k) {
      const auto& v = made->mesh.triangle(star.triangles()[k]).vertices;
      for (const VertexId id : {VertexId(4), star.ring()[k], star.ring_after(k)}) {
        EXPECT_EQ(std::count(v.begin(), v.end(), id), 1) << "triangle " << k;
      }
    }
  }
}

TEST(Star, OfABoundaryVertexRunsFromOneBoundaryEdgeToTheOther) {
  const auto made = ImportedMesh(GridData(2, 2));
  Star star;
  star.Gather(made->mesh, VertexId(1));
  EXPECT_FALSE(star.closed());
  EXPECT_THAT(Values(star.ring()), ElementsAre(2, 5, 4, 0));
  EXPECT_EQ(star.triangles().size(), 3U);
  star.Gather(made->mesh, VertexId(2));  // A corner of one triangle... and of no other.
  EXPECT_THAT(Values(star.ring()), ElementsAre(5, 1));
}

// Two squares that share the point (1, 1) alone.
MeshData Bowtie() {
  MeshData data;
  data.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {2, 1}, {2, 2}, {1, 2}};
  data.triangles = {{0, 1, 2}, {0, 2, 3}, {2, 4, 5}, {2, 5, 6}};
  return data;
}

TEST(FansOf, FindsEveryFanOfAPinchedVertexAndOneElsewhere) {
  const auto made = ImportedMesh(Bowtie());
  EXPECT_TRUE(made->mesh.vertex(VertexId(2)).pinched);
  const std::vector<TriangleId> fans = FansOf(made->mesh, VertexId(2));
  ASSERT_EQ(fans.size(), 2U);
  Star star;
  std::vector<std::vector<int>> rings;
  for (const TriangleId fan : fans) {
    star.Gather(made->mesh, VertexId(2), fan);
    rings.push_back(Values(star.ring()));
  }
  EXPECT_THAT(rings, ::testing::UnorderedElementsAre(ElementsAre(3, 0, 1), ElementsAre(4, 5, 6)));
  EXPECT_EQ(FansOf(made->mesh, VertexId(0)).size(), 1U);
  EXPECT_FALSE(made->mesh.vertex(VertexId(0)).pinched);
}

}  // namespace
}  // namespace pliant
