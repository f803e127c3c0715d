#include "core/delaunay/import_mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/rng.h"
#include "core/mesh/validate.h"
#include "core/pliant/remesher.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::Faults;
using testing::GridData;
using testing::ImportedMesh;

struct BadMesh {
  const char* name;
  void (*break_it)(MeshData&);
  ErrorCode code;
  const char* field;
  std::int64_t index;
};

// Goal: each error comes with its field and the first bad index. Method: one thing broken in a
// 2 x 2 grid of 8 triangles and 9 points.
TEST(PlanImport, RefusesEachFaultWithItsIndex) {
  const BadMesh cases[] = {
      {"no triangles", [](MeshData& m) { m.triangles.clear(); }, ErrorCode::kEmpty,
       "mesh.triangles", -1},
      {"triangle tags",
       [](MeshData& m) {
         m.triangle_tags = {1, 2};
       },
       ErrorCode::kArrayLength, "mesh.triangle_tags", -1},
      {"edge tags", [](MeshData& m) { m.edge_tags = {1}; }, ErrorCode::kArrayLength,
       "mesh.edge_tags", -1},
      {"NaN", [](MeshData& m) { m.points[3].y = std::numeric_limits<double>::quiet_NaN(); },
       ErrorCode::kNotFinite, "mesh.points", 3},
      {"infinite", [](MeshData& m) { m.points[8].x = std::numeric_limits<double>::infinity(); },
       ErrorCode::kNotFinite, "mesh.points", 8},
      {"index too large", [](MeshData& m) { m.triangles[5][1] = 9; }, ErrorCode::kIndexOutOfRange,
       "mesh.triangles", 5},
      {"index negative", [](MeshData& m) { m.triangles[2][0] = -1; }, ErrorCode::kIndexOutOfRange,
       "mesh.triangles", 2},
      {"edge index",
       [](MeshData& m) {
         m.edges = {{0, 1}, {1, 9}};
       },
       ErrorCode::kIndexOutOfRange, "mesh.edges", 1},
      {"repeated corner", [](MeshData& m) { m.triangles[4][1] = m.triangles[4][0]; },
       ErrorCode::kTriangleDegenerate, "mesh.triangles", 4},
      {"no area",
       [](MeshData& m) {
         m.points[4] = {2, 0};
       },
       ErrorCode::kTriangleDegenerate, "mesh.triangles", 0},
      {"one turned", [](MeshData& m) { std::swap(m.triangles[6][0], m.triangles[6][1]); },
       ErrorCode::kTriangleOrientation, "mesh.triangles", 6},
      {"a triangle twice", [](MeshData& m) { m.triangles.push_back(m.triangles[1]); },
       ErrorCode::kNonManifoldEdge, "mesh.triangles", 8},
      {"unused point",
       [](MeshData& m) {
         m.points.push_back({5, 5});
       },
       ErrorCode::kPointOutsideDomain, "mesh.points", 9},
      {"edge not in mesh",
       [](MeshData& m) {
         m.edges = {{0, 1}, {1, 3}};
       },
       ErrorCode::kEdgeNotInMesh, "mesh.edges", 1},
      {"edge twice",
       [](MeshData& m) {
         m.edges = {{0, 1}, {1, 4}, {1, 0}};
       },
       ErrorCode::kDuplicateSegment, "mesh.edges", 2},
  };
  for (const BadMesh& bad : cases) {
    MeshData data = GridData(2, 2);
    bad.break_it(data);
    const auto plan = PlanImport(data);
    ASSERT_FALSE(plan.ok()) << bad.name;
    EXPECT_EQ(ErrorCodeName(plan.error().code), ErrorCodeName(bad.code)) << bad.name;
    EXPECT_EQ(plan.error().field, bad.field) << bad.name;
    EXPECT_EQ(plan.error().index, bad.index) << bad.name;
    EXPECT_FALSE(plan.error().message.empty()) << bad.name;
  }
}

TEST(PlanImport, TurnsAMeshWhoseTrianglesAreAllClockwise) {
  MeshData data = GridData(3, 2);
  for (auto& triangle : data.triangles) std::swap(triangle[0], triangle[1]);
  data.edges = {{1, 0}, {5, 6}};
  const auto made = ImportedMesh(data);
  EXPECT_EQ(Faults(made->mesh), "");
  EXPECT_EQ(Area(made->mesh), 6);
}

TEST(PlanImport, KeepsNumbersTagsAndInternalConstraints) {
  MeshData data = GridData(3, 3);
  data.triangle_tags.assign(18, 7);
  data.edges = {{5, 6}, {0, 1}};
  data.edge_tags = {4, 5};
  const auto made = ImportedMesh(data);
  EXPECT_EQ(Faults(made->mesh), "");
  for (std::size_t i = 0; i < data.points.size(); ++i) {
    EXPECT_EQ(made->mesh.position(VertexId::FromIndex(i)), data.points[i]);
  }
  const EdgeId inner = made->mesh.FindEdge(VertexId(5), VertexId(6));
  EXPECT_EQ(inner, EdgeId(0));
  EXPECT_EQ(made->mesh.edge(inner).tag, 4);
  EXPECT_EQ(made->mesh.edge(EdgeId(1)).tag, 5);
  EXPECT_EQ(made->mesh.edge_count(), 1 + 12);
  EXPECT_EQ(made->mesh.triangle(TriangleId(9)).region, 7);
}

// Goal: regions keep their shape even if nobody says that the edges between them are constrained.
TEST(PlanImport, ConstrainsEdgesBetweenRegions) {
  MeshData data = GridData(8, 8);
  Rng rng(5);
  for (std::size_t t = 0; t < data.triangles.size(); ++t) {
    data.triangle_tags.push_back(static_cast<std::int32_t>(t / 16 < 3 ? 1 : 2 + rng.Below(2)));
  }
  const auto before = testing::RegionAreas(ImportedMesh(data)->mesh);
  MetricSpec spec;
  spec.source = SizeMetric{"0.7"};
  auto remesher = Remesher::Create(data, spec, {});
  ASSERT_TRUE(remesher.ok());
  ASSERT_TRUE((*remesher)->Step({}).ok());
  EXPECT_EQ(Faults((*remesher)->mesh()), "");
  const auto after = testing::RegionAreas((*remesher)->mesh());
  ASSERT_EQ(after.size(), 3U);
  for (const auto& [region, area] : before) EXPECT_NEAR(after.at(region), area, 1e-9) << region;
}

TEST(PlanDomain, MakesOneEdgePerSegmentAndFixesEveryPoint) {
  Domain domain = testing::Rectangle({0, 0}, {2, 1});
  domain.points.push_back({1, 0.5});
  const auto made = testing::DomainMesh(domain);
  EXPECT_EQ(Faults(made->mesh), "");
  EXPECT_EQ(made->mesh.edge_count(), 4);
  for (std::int32_t e = 0; e < 4; ++e) {
    EXPECT_EQ(made->mesh.edge(EdgeId(e)).tag, e + 1);
    EXPECT_EQ(made->mesh.edge(EdgeId(e)).segment, e);
  }
  for (std::int32_t v = 0; v < 5; ++v) EXPECT_TRUE(made->mesh.vertex(VertexId(v)).fixed);
  EXPECT_EQ(Area(made->mesh), 2);
}

}  // namespace
}  // namespace pliant
