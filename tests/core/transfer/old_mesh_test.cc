#include "core/transfer/old_mesh.h"

#include <gtest/gtest.h>

#include "tests/support/random_transfer.h"

namespace pliant {
namespace {

TEST(OldMesh, IsTheMeshOfTheLastCommit) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    const testing::RandomTransfer edited(testing::GridData(6, 5), seed, 60);
    const OldMesh old(edited.now->mesh, edited.now->edit.log());
    for (std::int32_t v = 0; v < edited.before.vertex_slots(); ++v) {
      const VertexRecord& expected = edited.before.vertex(VertexId(v));
      EXPECT_EQ(old.vertex(VertexId(v)).live, expected.live) << v;
      EXPECT_EQ(old.position(VertexId(v)), expected.position) << v;
    }
    for (std::int32_t t = 0; t < edited.before.triangle_slots(); ++t) {
      const TriangleRecord& expected = edited.before.triangle(TriangleId(t));
      EXPECT_EQ(old.triangle(TriangleId(t)).live, expected.live) << t;
      EXPECT_EQ(old.triangle(TriangleId(t)).vertices, expected.vertices) << t;
      EXPECT_EQ(old.triangle(TriangleId(t)).neighbors, expected.neighbors) << t;
    }
  }
}

}  // namespace
}  // namespace pliant
