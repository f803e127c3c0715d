#include "core/pliant/density.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::ImportedMesh;

constexpr std::int32_t kColumns = 9;

/// Rows of equilateral triangles of edge length `size`.
MeshData Lattice(double size) {
  MeshData data;
  for (std::int32_t j = 0; j < kColumns; ++j) {
    for (std::int32_t i = 0; i < kColumns; ++i) {
      data.points.push_back({size * (i + 0.5 * (j % 2)), size * testing::kEquilateralHeight * j});
    }
  }
  for (std::int32_t j = 0; j + 1 < kColumns; ++j) {
    for (std::int32_t i = 0; i + 1 < kColumns; ++i) {
      const std::int32_t v = kColumns * j + i;
      const std::int32_t up = v + kColumns;
      if (j % 2 == 0) {
        data.triangles.push_back({v, v + 1, up});
        data.triangles.push_back({v + 1, up + 1, up});
      } else {
        data.triangles.push_back({v, v + 1, up + 1});
        data.triangles.push_back({v, up + 1, up});
      }
    }
  }
  return data;
}

double LackInTheMiddle(double size) {
  const auto made = ImportedMesh(Lattice(size));
  Star star;
  star.Gather(made->mesh, VertexId(kColumns * (kColumns / 2) + kColumns / 2));
  DensityProbe probe(made->mesh);
  return probe.LackAround(star);
}

TEST(LackAround, IsNothingInALatticeOfUnitEdges) { EXPECT_NEAR(LackInTheMiddle(1), 0, 1e-12); }

// Two rings are 24 triangles, as many as 12 nodes have: of a lattice whose edges are longer by 1 %,
// 2 % of them are missing.
TEST(LackAround, CountsTheNodesThatAreMissing) {
  EXPECT_NEAR(LackInTheMiddle(1.01), 12 * (1.01 * 1.01 - 1), 1e-12);
  EXPECT_NEAR(LackInTheMiddle(0.9), 12 * (0.9 * 0.9 - 1), 1e-12);
}

// Near a border there are fewer triangles, and nothing is missing there either.
TEST(LackAround, DoesNotTakeABorderForAHole) {
  const auto made = ImportedMesh(Lattice(1));
  Star star;
  star.Gather(made->mesh, VertexId(kColumns + 1));
  DensityProbe probe(made->mesh);
  EXPECT_NEAR(probe.LackAround(star), 0, 1e-12);
}

TEST(StretchAround, EndsAtGivenVerticesOrAfterTenEdges) {
  // Vertices inside the four sides of a box; the bottom has edges of length 2.
  MeshData data = testing::GridData(30, 2);
  for (Vec2& p : data.points) p.x *= 2;
  const auto made = ImportedMesh(data);
  const DensityProbe probe(made->mesh);
  for (const std::int32_t v : {1, 5, 15, 29}) {
    const DensityProbe::Stretch stretch = probe.StretchAround(VertexId(v));
    EXPECT_EQ(stretch.count, std::min(v, 10) + std::min(30 - v, 10)) << v;
    EXPECT_DOUBLE_EQ(stretch.length, 2.0 * stretch.count) << v;
  }
}

TEST(StretchOfEdges, LacksAnEdgeAtTheLengthWhereTheLoopSplitsASingleOne) {
  EXPECT_FALSE((DensityProbe::Stretch{.length = 1.414, .count = 1}.lacks()));
  EXPECT_TRUE((DensityProbe::Stretch{.length = 1.415, .count = 1}.lacks()));
  EXPECT_FALSE((DensityProbe::Stretch{.length = 0.1, .count = 1}.is_crowded()));
  EXPECT_TRUE((DensityProbe::Stretch{.length = 1.413, .count = 2}.is_crowded()));
  EXPECT_FALSE((DensityProbe::Stretch{.length = 1.415, .count = 2}.is_crowded()));
}

// What was split is not taken back at once, and the other way round.
TEST(StretchOfEdges, KeepsADistanceBetweenLackAndCrowd) {
  for (int count = 2; count < 30; ++count) {
    for (double length = 0.5 * count; length < 2 * count; length += 0.001) {
      const DensityProbe::Stretch before{.length = length, .count = count};
      const DensityProbe::Stretch after{.length = length, .count = count + 1};
      EXPECT_FALSE(before.lacks() && after.is_crowded()) << count << " edges of " << length;
      EXPECT_FALSE(before.lacks() && before.is_crowded()) << count << " edges of " << length;
    }
    EXPECT_TRUE((DensityProbe::Stretch{.length = count + 0.61, .count = count}.lacks()));
    EXPECT_TRUE((DensityProbe::Stretch{.length = count - 0.65, .count = count}.is_crowded()));
  }
}

}  // namespace
}  // namespace pliant
