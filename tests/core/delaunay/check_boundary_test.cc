// Goal: triangles that overlap or leave a vertex hanging are refused, whatever they look like;
// touching ones are not. Method: small meshes drawn by hand.

#include "core/delaunay/check_boundary.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/delaunay/import_mesh.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::GridData;

void Append(MeshData& to, const MeshData& other, Vec2 shift, double scale) {
  const auto offset = static_cast<std::int32_t>(to.points.size());
  for (const Vec2 p : other.points) to.points.push_back(scale * p + shift);
  for (const auto& [a, b, c] : other.triangles) {
    to.triangles.push_back({a + offset, b + offset, c + offset});
  }
}

void ExpectNotConforming(const MeshData& data) {
  const auto plan = PlanImport(data);
  ASSERT_FALSE(plan.ok());
  EXPECT_EQ(ErrorCodeName(plan.error().code), "NOT_CONFORMING");
  EXPECT_EQ(plan.error().field, "mesh.points");
  EXPECT_GE(plan.error().index, 0);
  EXPECT_LT(plan.error().index, static_cast<std::int64_t>(data.points.size()));
}

TEST(CheckBoundary, RefusesSheetsThatOverlapAcrossTheirBoundaries) {
  MeshData data = GridData(3, 3);
  Append(data, GridData(3, 3), {1.5, 1.25}, 1);
  ExpectNotConforming(data);
}

TEST(CheckBoundary, RefusesASheetInsideAnother) {
  MeshData data = GridData(3, 3);
  Append(data, GridData(2, 2), {1.1, 1.1}, 0.3);
  ExpectNotConforming(data);
  MeshData nested = GridData(2, 2);  // The same with the large one last.
  for (Vec2& p : nested.points) p = 0.3 * p + Vec2{1.1, 1.1};
  Append(nested, GridData(3, 3), {0, 0}, 1);
  ExpectNotConforming(nested);
}

TEST(CheckBoundary, RefusesASheetOnTopOfAnEqualOne) {
  MeshData data = GridData(2, 2);
  Append(data, GridData(2, 2), {0, 0}, 1);
  ExpectNotConforming(data);
}

TEST(CheckBoundary, RefusesAVertexThatHangsOnAnEdge) {
  MeshData data;
  data.points = {{0, 0}, {2, 0}, {1, 1}, {1, 0}, {0.5, -1}, {1.5, -1}};
  data.triangles = {{0, 1, 2}, {0, 4, 3}, {3, 5, 1}};
  ExpectNotConforming(data);
}

TEST(CheckBoundary, RefusesASeamOfDoublePoints) {
  MeshData data;
  data.points = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
  data.triangles = {{0, 1, 2}, {3, 4, 5}};
  ExpectNotConforming(data);
}

/// A strip of triangles around the origin, `cells` of `per_turn` to the full turn; conforming side
/// by side, and it overlaps itself as soon as it is longer than a turn.
MeshData Strip(int cells, int per_turn) {
  MeshData data;
  for (int i = 0; i <= cells; ++i) {
    const double angle = 6.283185307179586 * i / per_turn;
    const double r = 1 + 0.02 * i;
    data.points.push_back({r * std::cos(angle), r * std::sin(angle)});
    data.points.push_back({(r + 1) * std::cos(angle), (r + 1) * std::sin(angle)});
  }
  for (int i = 0; i < cells; ++i) {
    const std::int32_t a = 2 * i;
    data.triangles.push_back({a, a + 1, a + 3});
    data.triangles.push_back({a, a + 3, a + 2});
  }
  return data;
}

TEST(CheckBoundary, RefusesAStripThatOverlapsItselfAfterATurn) {
  EXPECT_TRUE(PlanImport(Strip(11, 12)).ok());
  ExpectNotConforming(Strip(14, 12));
  ExpectNotConforming(Strip(30, 12));
}

TEST(CheckBoundary, AcceptsHolesAndPartsThatTouchInAPoint) {
  MeshData data = GridData(5, 5);
  MeshData holed{data.points, {}, {}, {}, {}};
  for (std::size_t t = 0; t < data.triangles.size(); ++t) {
    const std::size_t cell = t / 2;
    if (cell == 6 || cell == 12 || cell == 18) continue;  // Diagonal holes that touch.
    holed.triangles.push_back(data.triangles[t]);
  }
  const auto plan = PlanImport(holed);
  ASSERT_TRUE(plan.ok()) << plan.error().message;
  const auto made = testing::ImportedMesh(holed);
  EXPECT_EQ(testing::Faults(made->mesh), "");
  EXPECT_TRUE(made->mesh.vertex(VertexId(14)).pinched);
  EXPECT_TRUE(made->mesh.vertex(VertexId(14)).fixed);
}

TEST(CheckBoundary, AcceptsPartsThatDoNotTouch) {
  MeshData data = GridData(2, 2);
  Append(data, GridData(2, 2), {5, 0}, 1);
  EXPECT_TRUE(PlanImport(data).ok());
}

}  // namespace
}  // namespace pliant
