#include "core/delaunay/recover_segments.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::Faults;
using testing::GridData;
using testing::ImportedMesh;

std::vector<int> FixedVertices(const Mesh& mesh) {
  std::vector<int> fixed;
  for (const VertexId id : testing::LiveVertices(mesh)) {
    if (mesh.vertex(id).fixed) fixed.push_back(id.value());
  }
  return fixed;
}

TEST(RecoverSegments, JoinsStraightRunsAndFixesCorners) {
  const auto made = ImportedMesh(GridData(4, 3));
  EXPECT_EQ(Faults(made->mesh), "");
  EXPECT_EQ(made->mesh.segments().size(), 4U);
  EXPECT_EQ(FixedVertices(made->mesh), (std::vector<int>{0, 4, 15, 19}));
}

TEST(RecoverSegments, GivesParametersByTheWayAlongTheRun) {
  MeshData data = GridData(4, 1);
  data.points[1].x = 0.25;  // Unevenly spaced: 0, 0.25, 2, 3, 4.
  const auto made = ImportedMesh(data);
  const auto [before, after] = made->mesh.SegmentEdges(VertexId(1));
  EXPECT_DOUBLE_EQ(made->mesh.edge(before).parameters[1], 0.0625);
  EXPECT_DOUBLE_EQ(made->mesh.edge(after).parameters[1], 0.5);
}

TEST(RecoverSegments, EndsARunWhereTheTagChanges) {
  MeshData data = GridData(4, 1);
  data.edges = {{0, 1}, {1, 2}, {2, 3}, {3, 4}};
  data.edge_tags = {1, 1, 2, 2};
  const auto made = ImportedMesh(data);
  EXPECT_EQ(made->mesh.segments().size(), 5U);
  EXPECT_EQ(FixedVertices(made->mesh), (std::vector<int>{0, 2, 4, 5, 9}));
}

TEST(RecoverSegments, FixesWhereConstraintsBranch) {
  MeshData data = GridData(4, 4);
  data.edges = {{10, 11}, {11, 12}, {12, 13}, {13, 14}, {12, 17}};
  const auto made = ImportedMesh(data);
  EXPECT_EQ(Faults(made->mesh), "");
  EXPECT_TRUE(made->mesh.vertex(VertexId(12)).fixed);
  EXPECT_TRUE(made->mesh.vertex(VertexId(17)).fixed) << "the end of a constraint";
  EXPECT_TRUE(made->mesh.vertex(VertexId(10)).fixed) << "where it meets the boundary";
  EXPECT_FALSE(made->mesh.vertex(VertexId(11)).fixed);
  EXPECT_FALSE(made->mesh.vertex(VertexId(13)).fixed);
}

// A constraint whose edges were given in alternating directions is one line all the same, in the
// direction of the edge that was given first.
TEST(RecoverSegments, JoinsEdgesOfAnyDirection) {
  const auto segments_of = [](std::vector<std::array<std::int32_t, 2>> edges) {
    MeshData data = GridData(4, 4);
    data.edges = std::move(edges);
    const auto made = ImportedMesh(data);
    EXPECT_EQ(Faults(made->mesh), "");
    EXPECT_EQ(FixedVertices(made->mesh), (std::vector<int>{0, 4, 10, 14, 20, 24}));
    std::vector<std::pair<int, int>> lines;
    for (const SegmentRecord& segment : made->mesh.segments()) {
      if (segment.a.value() + segment.b.value() != 24) continue;
      lines.emplace_back(segment.a.value(), segment.b.value());
    }
    return lines;
  };
  using Lines = std::vector<std::pair<int, int>>;
  EXPECT_EQ(segments_of({{10, 11}, {11, 12}, {12, 13}, {13, 14}}), (Lines{{10, 14}}));
  EXPECT_EQ(segments_of({{10, 11}, {12, 11}, {12, 13}, {14, 13}}), (Lines{{10, 14}}));
  EXPECT_EQ(segments_of({{12, 11}, {10, 11}, {12, 13}, {14, 13}}), (Lines{{14, 10}}));
}

/// A disc of `n` triangles around its center.
MeshData Disc(int n) {
  MeshData data;
  data.points = {{3, 4}};
  for (int i = 0; i < n; ++i) {
    const double angle = 6.283185307179586 * i / n;
    data.points.push_back({3 + std::cos(angle), 4 + std::sin(angle)});
    data.triangles.push_back({0, 1 + i, 1 + (i + 1) % n});
  }
  return data;
}

TEST(RecoverSegments, KeepsCirclesFixedHoweverFine) {
  for (const int n : {3, 12, 100, 5'000, 50'000}) {
    const auto made = ImportedMesh(Disc(n));
    EXPECT_EQ(Faults(made->mesh), "");
    EXPECT_EQ(FixedVertices(made->mesh).size(), static_cast<std::size_t>(n)) << n;
  }
}

// Goal: lines that are straight only up to rounding are straight. Method: a rotated and shifted
// grid whose points are rounded.
TEST(RecoverSegments, ForgivesTheRoundingOfARotatedLine) {
  MeshData data = GridData(50, 2);
  for (Vec2& p : data.points) {
    p = {0.1 * (0.6 * p.x - 0.8 * p.y) + 1.0 / 3, 0.1 * (0.8 * p.x + 0.6 * p.y) + 1.0 / 7};
  }
  const auto made = ImportedMesh(data);
  EXPECT_EQ(Faults(made->mesh), "");
  EXPECT_EQ(made->mesh.segments().size(), 4U);
}

// A line that bends by a tiny angle at each of many vertices is a curve, not a line.
TEST(RecoverSegments, CutsAnArcThatNoSingleAngleGivesAway) {
  MeshData data = GridData(1000, 1);
  for (Vec2& p : data.points) p.y -= 1e-9 * p.x * p.x;
  const auto made = ImportedMesh(data);
  EXPECT_EQ(Faults(made->mesh), "");
  EXPECT_GT(made->mesh.segments().size(), 20U);
}

}  // namespace
}  // namespace pliant
