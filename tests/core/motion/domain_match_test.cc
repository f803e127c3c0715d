#include "core/motion/domain_match.h"

#include <gtest/gtest.h>

#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

DomainMatch Match(const Mesh& mesh, const Domain& domain) {
  return MatchDomain(mesh, domain, *TriangulateDomain(domain));
}

/// The unit square with the middle of its lower side as a vertex inside that segment.
std::unique_ptr<testing::EditedMesh> SplitSquare() {
  auto made = testing::DomainMesh(testing::Rectangle({0, 0}, {1, 1}));
  const EdgeId lower = made->mesh.FindEdge(VertexId(0), VertexId(1));
  const TriangleId at = made->mesh.edge(lower).triangle;
  for (int corner = 0; corner < 3; ++corner) {
    const VertexId opposite = made->mesh.triangle(at).vertices[static_cast<std::size_t>(corner)];
    if (opposite == VertexId(0) || opposite == VertexId(1)) continue;
    made->edit.SplitEdge({at, corner}, {0.5, 0}, 0.5);
    break;
  }
  return made;
}

TEST(MatchDomain, KeepsSegmentsWhateverTheirDirection) {
  const auto made = SplitSquare();
  Domain domain = testing::Rectangle({0, 0}, {1, 1});
  std::swap(domain.segments[0].a, domain.segments[0].b);
  const DomainMatch match = Match(made->mesh, domain);
  EXPECT_TRUE(match.gone.empty() && match.dropped.empty() && match.reused.empty());
  EXPECT_TRUE(match.segments[0].reversed);
  EXPECT_FALSE(match.segments[1].reversed);
  // Seen from 1 to 0 the square lies on the right, along the mesh's own segment on the left.
  EXPECT_FALSE(match.segments[0].sides.left.has_value());
  EXPECT_EQ(match.segments[0].sides.right, 0);
  const EdgeId first = made->mesh.FindEdge(VertexId(0), VertexId(4));
  EXPECT_EQ(match.SidesOf(made->mesh, first)->left, 0);
}

// A segment that is cut at a vertex on it keeps its edges; one that is joined keeps them, too.
TEST(MatchDomain, ReusesEdgesOfSegmentsThatAreCut) {
  const auto made = SplitSquare();
  Domain domain = testing::Rectangle({0, 0}, {1, 1});
  domain.points.push_back({0.5, 0});
  domain.segments[0].b = 4;
  domain.segments.push_back({4, 1, 0});
  const DomainMatch match = Match(made->mesh, domain);
  EXPECT_EQ(match.vertex_of_point[4], VertexId(4));
  EXPECT_EQ(match.gone, std::vector<std::int32_t>{0});
  EXPECT_EQ(match.reused.size(), 2U);
  EXPECT_TRUE(match.dropped.empty());
}

TEST(MatchDomain, LetsVerticesOfOldSegmentsRideOnNewOnes) {
  const auto made = SplitSquare();
  const DomainMatch match = Match(made->mesh, testing::Rectangle({0, 0}, {0.75, 1}));
  ASSERT_EQ(match.segments[0].chain.size(), 3U);
  EXPECT_EQ(match.segments[0].chain[1].vertex, VertexId(4));
  EXPECT_DOUBLE_EQ(match.segments[0].chain[1].t, 0.5 / 0.75);
  EXPECT_FALSE(match.segments[0].chain[2].vertex.valid());
  EXPECT_EQ(match.reused.size(), 1U);
  EXPECT_EQ(match.no_longer_given, (std::vector<VertexId>{VertexId(1), VertexId(2)}));
  const EdgeId right = made->mesh.FindEdge(VertexId(1), VertexId(2));
  EXPECT_FALSE(match.SidesOf(made->mesh, right).has_value());
}

}  // namespace
}  // namespace pliant
