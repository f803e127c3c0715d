#include "core/pliant/merit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/delaunay/import_mesh.h"
#include "core/mesh/mesh_edit.h"

namespace pliant {
namespace {

MeritCorner At(double x, double y) { return {{x, y}, Metric::Isotropic(1)}; }

double Merit(const MeritCorner& a, const MeritCorner& b, const MeritCorner& c) {
  return MeritOf(MeritShapeOf(a, b, c));
}

// Goal: the least of Q, longest and shortest edge decides, each relative to what is good enough.
TEST(Merit, IsThatOfTheWorst) {
  const double height = std::sqrt(0.75);
  EXPECT_NEAR(Merit(At(0, 0), At(1, 0), At(0.5, height)), 1 / 0.8, 1e-12);
  EXPECT_NEAR(Merit(At(0, 0), At(2, 0), At(1, 2 * height)), 1.42 * 1.42 / 4, 1e-12);
  EXPECT_NEAR(Merit(At(0, 0), At(0.5, 0), At(0.25, 0.5 * height)), 0.25 / (0.65 * 0.65), 1e-12);
  EXPECT_EQ(ShortfallOf(At(0, 0), At(1, 0), At(0.5, height)), 0);
  EXPECT_GT(ShortfallOf(At(0, 0), At(1, 0), At(0.5, 0.4)), 0);
}

// Goal: what is quick to tell agrees with the merit, near the bound too.
TEST(Merit, SurelyAboveAgreesWithTheMerit) {
  int above = 0;
  for (int k = 0; k < 1000; ++k) {
    const MeritShape shape = MeritShapeOf(At(0, 0), At(1, 0), At(0.1, 0.2 + 0.001 * k));
    if (std::fabs(MeritOf(shape) - 1) < 1e-8) continue;
    EXPECT_EQ(IsMeritSurelyAbove(shape, 1), MeritOf(shape) > 1) << k;
    above += MeritOf(shape) > 1 ? 1 : 0;
  }
  EXPECT_GT(above, 100);
}

// Goal: an edge between given vertices, which nobody can lengthen, does not hide what is wrong with
// a triangle on it, and does not call for mending by itself.
TEST(Merit, AGivenEdgeMayBeShort) {
  MeshData data;
  data.points = {{0, 0}, {0.3, 0}, {0.15, 0.3}};
  data.triangles = {{0, 1, 2}};
  Mesh mesh;
  MeshEdit edit(mesh);
  BuildFromPlan(*PlanImport(data), edit);
  for (std::int32_t v = 0; v < 3; ++v) edit.SetMetric(VertexId(v), Metric::Isotropic(1));
  edit.Unfix(VertexId(2));
  const MeritCorner a = MeritCornerAt(mesh, VertexId(0));
  const MeritCorner b = MeritCornerAt(mesh, VertexId(1));
  EXPECT_TRUE(IsCrowded(a));
  EXPECT_FALSE(IsCrowded(MeritCornerAt(mesh, VertexId(2))));
  EXPECT_GT(Merit(a, b, At(0.15, 0.3)), 1);
  EXPECT_LT(Merit(At(0, 0), At(0.3, 0), At(0.15, 0.3)), 0.3);
  EXPECT_LT(Merit(a, b, At(0.15, 1)), Merit(a, b, At(0.15, 0.5)));
}

}  // namespace
}  // namespace pliant
