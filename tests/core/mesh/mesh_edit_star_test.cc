// Goal: taking a vertex out of its star gives the mesh, bit for bit, that replacing any cavity
// gives.

#include <gtest/gtest.h>

#include <vector>

#include "core/base/rng.h"
#include "core/mesh/mesh_edit.h"
#include "core/pliant/retriangulate.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::DifferenceOf;
using testing::Faults;
using testing::GridData;
using testing::ImportedMesh;

bool IsInside(const Mesh& mesh, VertexId id) {
  const VertexRecord& record = mesh.vertex(id);
  return record.live && !record.fixed && !record.edge.valid();
}

std::vector<NewTriangle> EarsOf(const Mesh& mesh, const Star& star) {
  const auto ears = CutEars(mesh, star.ring(), Metric::Isotropic(1), 7);
  EXPECT_TRUE(ears.has_value());
  return ears.value_or(std::vector<NewTriangle>());
}

TEST(ReplaceStar, IsReplaceCavityForEveryVertexInside) {
  // The inside of the grid has a line of constrained edges, so that stars have such sides.
  MeshData data = GridData(6, 6);
  data.edges = {{15, 16}, {16, 17}, {17, 18}};
  data.edge_tags = {6, 6, 6};
  const auto by_star = ImportedMesh(data);
  const auto by_cavity = ImportedMesh(data);
  Rng rng(1996);
  std::vector<VertexId> inside;
  for (std::int32_t v = 0; v < by_star->mesh.vertex_slots(); ++v) {
    if (IsInside(by_star->mesh, VertexId(v))) inside.emplace_back(v);
  }
  ASSERT_GT(inside.size(), 20U);
  while (!inside.empty()) {
    const std::size_t pick = static_cast<std::size_t>(rng.Below(inside.size()));
    const VertexId id = inside[pick];
    inside.erase(inside.begin() + static_cast<std::ptrdiff_t>(pick));
    SCOPED_TRACE(::testing::Message() << "vertex " << id.value());
    Star star;
    star.Gather(by_star->mesh, id);
    const std::vector<NewTriangle> ears = EarsOf(by_star->mesh, star);
    by_star->edit.ReplaceStar(star, ears);
    by_star->edit.RemoveVertex(id);
    by_cavity->edit.ReplaceCavity(star.triangles(), ears);
    by_cavity->edit.RemoveVertex(id);
    ASSERT_EQ(DifferenceOf(by_star->mesh, by_cavity->mesh), "");
  }
  EXPECT_EQ(Faults(by_star->mesh), "");
}

TEST(ReplaceStar, IsUndoneByARollback) {
  const auto made = ImportedMesh(GridData(4, 4));
  const auto before = ImportedMesh(GridData(4, 4));
  (void)made->edit.Commit(Revision(1));
  (void)before->edit.Commit(Revision(1));
  for (std::int32_t v = 0; v < before->mesh.vertex_slots(); ++v) {
    if (!IsInside(made->mesh, VertexId(v))) continue;
    Star star;
    star.Gather(made->mesh, VertexId(v));
    made->edit.ReplaceStar(star, EarsOf(made->mesh, star));
    made->edit.RemoveVertex(VertexId(v));
  }
  EXPECT_LT(made->mesh.vertex_count(), before->mesh.vertex_count());
  made->edit.Rollback();
  EXPECT_EQ(DifferenceOf(made->mesh, before->mesh), "");
  EXPECT_EQ(Faults(made->mesh), "");
}

TEST(ReplaceStar, IsABugWhereEarsAreMissing) {
  const auto made = ImportedMesh(GridData(3, 3));
  Star star;
  star.Gather(made->mesh, VertexId(5));
  std::vector<NewTriangle> ears = EarsOf(made->mesh, star);
  ears.pop_back();
  EXPECT_THROW(made->edit.ReplaceStar(star, ears), InvariantViolation);
}

}  // namespace
}  // namespace pliant
