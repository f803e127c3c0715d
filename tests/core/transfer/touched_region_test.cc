#include "core/transfer/touched_region.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "core/mesh/mesh_diff.h"
#include "tests/support/random_transfer.h"

namespace pliant {
namespace {

using testing::RandomTransfer;

/// Triangles of `mesh` that `other` does not have with the same corners at the same places.
std::vector<TriangleId> NotIn(const Mesh& mesh, const Mesh& other) {
  std::vector<TriangleId> result;
  for (const TriangleId id : testing::LiveTriangles(mesh)) {
    const bool there = id.value() < other.triangle_slots() && other.triangle(id).live;
    bool same = there && CanonicalTriangle(mesh.triangle(id).vertices) ==
                             CanonicalTriangle(other.triangle(id).vertices);
    for (const VertexId v : mesh.triangle(id).vertices) {
      same = same && SamePosition(mesh.position(v), other.position(v));
    }
    if (!same) result.push_back(id);
  }
  return result;
}

// Method: the two whole meshes compared, triangle by triangle.
TEST(TouchedRegion, HasExactlyTheTrianglesThatDiffer) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    const RandomTransfer edited(testing::GridData(8, 7), seed, 5 * static_cast<int>(seed));
    const TouchedRegion& region = edited.transfer->region();
    EXPECT_EQ(region.before.triangle_ids, NotIn(edited.before, edited.now->mesh));
    EXPECT_EQ(region.after.triangle_ids, NotIn(edited.now->mesh, edited.before));
    for (std::size_t t = 0; t < region.before.triangles.size(); ++t) {
      EXPECT_EQ(CornersOf(region.before, static_cast<std::int32_t>(t)),
                testing::CornersIn(edited.before, region.before.triangle_ids[t]));
    }
    for (std::size_t t = 0; t < region.after.triangles.size(); ++t) {
      EXPECT_EQ(CornersOf(region.after, static_cast<std::int32_t>(t)),
                testing::CornersIn(edited.now->mesh, region.after.triangle_ids[t]));
    }
  }
}

TEST(TouchedRegion, NamesTheVerticesThatTheDiffLists) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    RandomTransfer edited(testing::GridData(8, 7), seed, 50);
    const std::vector<VertexId> moved = edited.transfer->region().moved;
    EXPECT_EQ(moved, edited.now->edit.Commit(Revision(2)).vertex_ids);
  }
}

TEST(TouchedRegion, IsEmptyWhereNothingChanged) {
  auto edited = testing::ImportedMesh(testing::GridData(3, 3));
  (void)edited->edit.Commit(Revision(1));
  edited->edit.SetMetric(VertexId(3), Metric::Isotropic(0.5));
  EXPECT_TRUE(MeshTransfer(edited->mesh, edited->edit.log()).empty());
}

}  // namespace
}  // namespace pliant
