#include "core/pliant/refill.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <vector>

#include "core/mesh/validate.h"
#include "core/pliant/displace.h"
#include "tests/support/loop_mesh.h"

namespace pliant {
namespace {

using testing::EditedMesh;
using testing::Faults;

std::unique_ptr<EditedMesh> Square() {
  return testing::LoopMesh(testing::DiscCase(600, testing::DiscState::kOff));
}

double EdgeLength(const Mesh& mesh) { return 1 / std::sqrt(mesh.metric(VertexId(0)).m11); }

/// Displacements of the middle third of the square.
std::vector<Displacement> Middle(const Mesh& mesh, Vec2 by) {
  std::vector<Displacement> list;
  for (const VertexId vertex : testing::LiveVertices(mesh)) {
    if (std::fabs(mesh.position(vertex).x - 0.5) > 0.17) continue;
    if (const auto place = PlaceAfter(mesh, vertex, by)) list.push_back({vertex, *place});
  }
  return list;
}

double LongestEdge(const Mesh& mesh) {
  double longest = 0;
  for (const VertexId vertex : testing::LiveVertices(mesh)) {
    Star star;
    star.Gather(mesh, vertex);
    for (const VertexId other : star.ring()) {
      const Vec2 e = mesh.position(other) - mesh.position(vertex);
      longest = std::max(longest, std::sqrt(SquaredLength(mesh.metric(vertex), e)));
    }
  }
  return longest;
}

// Goal: the gap is filled with what stood there: new vertices lie, to the bit, where some were that
// have moved, none is nearer to another than half an edge, tensors are those around, the mesh is
// valid, and no edge is as long as the gap any more but at the walls.
TEST(RefillGap, PutsVerticesWhereOthersWere) {
  for (const double edges : {1.5, 2.5, 4.0, -3.0}) {
    SCOPED_TRACE(edges);
    auto square = Square();
    auto torn = Square();
    const Mesh& mesh = square->mesh;
    const double edge = EdgeLength(mesh);
    const Vec2 by{edges * edge, 0};
    const std::vector<Displacement> list = Middle(mesh, by);
    std::map<std::pair<double, double>, VertexId> before;
    for (const VertexId vertex : testing::LiveVertices(mesh)) {
      const Vec2 p = mesh.position(vertex);
      before[{p.x, p.y}] = vertex;
    }
    ASSERT_TRUE(Displace(torn->edit, list, Behind::kLeft).has_value());
    const auto displaced = Displace(square->edit, list, Behind::kRefilled);
    ASSERT_TRUE(displaced.has_value());
    EXPECT_EQ(Faults(mesh), "");
    EXPECT_NEAR(Area(mesh), 1, 1e-12);

    const auto rows = static_cast<std::size_t>(std::fabs(edges));
    EXPECT_GT(displaced->created.size(), rows * 10);
    EXPECT_LE(displaced->created.size(), static_cast<std::size_t>(displaced->removed_count));
    EXPECT_TRUE(std::ranges::is_sorted(displaced->created));
    EXPECT_TRUE(std::ranges::includes(displaced->disturbed, displaced->created));
    for (const VertexId vertex : displaced->created) {
      ASSERT_TRUE(mesh.IsLive(vertex));
      const Vec2 p = mesh.position(vertex);
      EXPECT_TRUE(before.contains({p.x, p.y}));
      EXPECT_NEAR(mesh.metric(vertex).m11 * edge * edge, 1, 1e-12);
      EXPECT_NEAR(mesh.metric(vertex).m12 * edge * edge, 0, 1e-12);
      for (const VertexId other : testing::LiveVertices(mesh)) {
        if (other == vertex) continue;
        EXPECT_GT(Length(mesh.position(other) - p), 0.5 * edge);
      }
    }
    EXPECT_LT(LongestEdge(mesh), LongestEdge(torn->mesh));
  }
}

TEST(RefillGap, StopsAtTheGivenCountAndLeavesNarrowGaps) {
  auto square = Square();
  const double edge = EdgeLength(square->mesh);
  auto narrow = Displace(square->edit, Middle(square->mesh, {0.3 * edge, 0}), Behind::kRefilled);
  ASSERT_TRUE(narrow.has_value());
  EXPECT_TRUE(narrow->created.empty());

  auto torn = Square();
  const Mesh& mesh = torn->mesh;
  std::map<VertexId, Vec2> before;
  const std::vector<Displacement> list = Middle(mesh, {3 * edge, 0});
  for (const Displacement& one : list) before[one.vertex] = mesh.position(one.vertex);
  ASSERT_TRUE(Displace(torn->edit, list, Behind::kLeft).has_value());
  std::vector<TriangleId> triangles;
  for (std::int32_t t = 0; t < mesh.triangle_slots(); ++t) triangles.emplace_back(t);
  const Gap gap{.triangles = triangles,
                .before = [&](VertexId vertex) -> std::optional<Vec2> {
                  const auto at = before.find(vertex);
                  if (at == before.end()) return std::nullopt;
                  return at->second;
                },
                .count_max = 5};
  EXPECT_EQ(RefillGap(torn->edit, gap).size(), 5U);
  EXPECT_EQ(Faults(mesh), "");
}

// Goal: a session that may not insert does not insert here either.
TEST(RefillGap, IsNotAskedForWithoutPermission) {
  for (const bool insert : {true, false}) {
    auto square = Square();
    const std::vector<Displacement> list = Middle(square->mesh, {3 * EdgeLength(square->mesh), 0});
    std::vector<VertexId> vertices;
    for (const Displacement& one : list) vertices.push_back(one.vertex);
    const std::vector<Vec2> by(vertices.size(), Vec2{3 * EdgeLength(square->mesh), 0});
    DisplaceVertices displace(vertices, by);
    displace.Permit({.insert = insert});
    const auto outcome = displace.Apply(square->edit);
    ASSERT_TRUE(outcome.ok());
    const auto is_new = [&](VertexId vertex) {
      return !(std::ranges::find(vertices, vertex) != vertices.end());
    };
    EXPECT_EQ(std::ranges::any_of(outcome->carriers, is_new), insert);
  }
}

}  // namespace
}  // namespace pliant
