#include "core/motion/domain_swap.h"

#include <gtest/gtest.h>

#include "core/mesh/validate.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

// Goal: what the change tells the engine is what it did: new vertices without a metric, and every
// live vertex with a new triangle; slots of triangles that come again as they were stay.
TEST(DomainSwap, TellsWhatItDisturbed) {
  const auto made = testing::ImportedMesh(testing::GridData(8, 8));
  (void)made->edit.Commit(Revision(1));
  Domain domain = testing::Rectangle({0, 0}, {8, 8});
  for (const Vec2 p : {Vec2{3.2, 3.1}, Vec2{4.4, 3.3}, Vec2{3.9, 4.6}}) domain.points.push_back(p);
  for (std::int32_t i = 0; i < 3; ++i) domain.segments.push_back({4 + i, 4 + (i + 1) % 3, 1});
  domain.holes.push_back({3.8, 3.7});
  DomainSwap swap(domain);
  const auto outcome = swap.Apply(made->edit);
  ASSERT_TRUE(outcome.ok()) << outcome.error().message;
  EXPECT_EQ(outcome->created.size(), 3U);
  for (const VertexId id : outcome->created) made->edit.SetMetric(id, Metric());
  EXPECT_EQ(testing::Faults(made->mesh), "");
  EXPECT_NEAR(Area(made->mesh), 64 - 0.5 * (1.2 * 1.5 - 0.7 * 0.2), 1e-12);
  std::vector<VertexId> corners;
  for (const auto& [id, old] : made->edit.log().triangles) {
    const TriangleRecord& now = made->mesh.triangle(id);
    if (!now.live || (old.live && old.vertices == now.vertices)) continue;
    for (const VertexId vertex : now.vertices) {
      EXPECT_TRUE(std::binary_search(outcome->disturbed.begin(), outcome->disturbed.end(), vertex));
    }
  }
  EXPECT_LT(outcome->disturbed.size(), 20U);
}

// Goal: a vertex that lies exactly on a new segment becomes one of it and keeps its slot.
TEST(DomainSwap, TakesVerticesOnTheWay) {
  const auto made = testing::ImportedMesh(testing::GridData(4, 4));
  (void)made->edit.Commit(Revision(1));
  Domain domain = testing::Rectangle({0, 0}, {4, 4});
  domain.segments.push_back({0, 2, 5});
  DomainSwap swap(domain);
  ASSERT_TRUE(swap.Apply(made->edit).ok());
  EXPECT_EQ(testing::Faults(made->mesh), "");
  for (std::int32_t i = 0; i < 4; ++i) {
    const EdgeId edge = made->mesh.FindEdge(VertexId(6 * i), VertexId(6 * (i + 1)));
    ASSERT_TRUE(edge.valid()) << i;
    EXPECT_EQ(made->mesh.edge(edge).tag, 5);
    EXPECT_EQ(made->mesh.vertex(VertexId(6 * i)).fixed, i == 0);
  }
}

}  // namespace
}  // namespace pliant
