#include "core/transfer/nodal_projection.h"

#include <gtest/gtest.h>

#include "tests/support/field_testing.h"

namespace pliant {
namespace {

using testing::FieldOf;
using testing::IntegralOf;
using testing::RandomTransfer;

Field Projected(const Field& field, const Mesh& now, const MeshTransfer& transfer) {
  OverlapFinder finder(transfer.region(), transfer.locator());
  NodalSystem system = MakeNodalSystem(now, transfer.region());
  NodalProjection nodes(field, transfer.region(), transfer.rows());
  for (std::size_t t = 0; t < transfer.region().after.triangles.size(); ++t) {
    finder.Find(static_cast<std::int32_t>(t));
    system.components.AddOverlaps(static_cast<std::int32_t>(t), finder);
    nodes.Add(static_cast<std::int32_t>(t), finder);
  }
  system.components.Finish(transfer.locator());
  const FieldRows rows = nodes.Finish(system);
  Field result = field;
  result.values.resize(static_cast<std::size_t>(now.vertex_slots()));
  for (std::size_t i = 0; i < rows.slots.size(); ++i) {
    result.values[static_cast<std::size_t>(rows.slots[i])] = rows.values[i];
  }
  return result;
}

Field NodalField(const Mesh& mesh, const std::function<double(Vec2)>& f) {
  return FieldOf(mesh, FieldLocation::kVertex, TransferKind::kConservative, f);
}

double StepAndSlope(Vec2 p) { return p.x * p.x - 30 * p.y + (p.x > 5 ? 17.0 : 0.0); }

TEST(NodalProjection, KeepsTheIntegral) {
  for (const MeshData& data : {testing::GridData(9, 9), testing::ThinGrid()}) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      SCOPED_TRACE(::testing::Message() << "seed " << seed);
      const RandomTransfer edited(data, seed, 100);
      const Field before = NodalField(edited.before, StepAndSlope);
      const Field after = Projected(before, edited.now->mesh, *edited.transfer);
      const auto old_integral = IntegralOf(edited.before, before);
      EXPECT_NEAR(IntegralOf(edited.now->mesh, after).value, old_integral.value,
                  1e-14 * old_integral.magnitude);
    }
  }
}

TEST(NodalProjection, KeepsConstantsToTheBitAndLinearFunctionsUpToRounding) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    const RandomTransfer edited(testing::GridData(9, 9), seed, 100);
    const auto linear = [](Vec2 p) { return 1 + 2 * p.x - 3 * p.y; };
    const Field constant = Projected(NodalField(edited.before, [](Vec2) { return 0.1; }),
                                     edited.now->mesh, *edited.transfer);
    const Field plane =
        Projected(NodalField(edited.before, linear), edited.now->mesh, *edited.transfer);
    for (const VertexId id : testing::LiveVertices(edited.now->mesh)) {
      EXPECT_EQ(constant.values[id.index()], 0.1);
      EXPECT_NEAR(plane.values[id.index()], linear(edited.now->mesh.position(id)), 1e-11);
    }
  }
}

TEST(NodalProjection, LeavesVerticesAloneWhoseTrianglesDidNotChange) {
  const RandomTransfer edited(testing::GridData(12, 12), /*seed=*/1, /*steps=*/20);
  const Field before = NodalField(edited.before, StepAndSlope);
  const Field after = Projected(before, edited.now->mesh, *edited.transfer);
  const auto& touched = edited.transfer->region().after.vertex_ids;
  int alone = 0;
  for (const VertexId id : testing::LiveVertices(edited.now->mesh)) {
    if (std::ranges::find(touched, id) != touched.end()) continue;
    ++alone;
    EXPECT_EQ(after.values[id.index()], before.values[id.index()]);
  }
  EXPECT_GT(alone, 20);
}

// Goal: it is a projection: the error is orthogonal to every change that keeps the integral, so no
// such change makes it smaller.
// Method: the squared L2 distance of old and new function, integrated over the overlaps by the
// corners' and middles' rule, for the result and for results with values moved back and forth.
TEST(NodalProjection, IsNearestToTheOldFunctionOfAllWithItsIntegral) {
  const RandomTransfer edited(testing::GridData(5, 5), /*seed=*/2, /*steps=*/40);
  const Mesh& now = edited.now->mesh;
  const TouchedRegion& region = edited.transfer->region();
  const Field before = NodalField(edited.before, StepAndSlope);
  const Field after = Projected(before, now, *edited.transfer);
  const auto distance = [&](const Field& field) {
    const auto value = [](const std::array<Vec2, 3>& c, const std::array<double, 3>& v, Vec2 p) {
      const double area = Cross(c[1] - c[0], c[2] - c[0]);
      return (v[0] * Cross(c[1] - p, c[2] - p) + v[1] * Cross(c[2] - p, c[0] - p) +
              v[2] * Cross(c[0] - p, c[1] - p)) /
             area;
    };
    double sum = 0;
    // Triangles that did not change, but whose values at the rim did, count as well.
    for (const TriangleId id : testing::LiveTriangles(now)) {
      if (std::ranges::find(region.after.triangle_ids, id) != region.after.triangle_ids.end()) {
        continue;
      }
      std::array<double, 3> d{};
      for (std::size_t i = 0; i < 3; ++i) {
        const auto v = now.triangle(id).vertices[i].index();
        d[i] = field.values[v] - before.values[v];
      }
      sum += AreaOf(testing::CornersIn(now, id)) / 6 *
             (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + d[0] * d[1] + d[1] * d[2] + d[2] * d[0]);
    }
    OverlapFinder finder(region, edited.transfer->locator());
    for (std::size_t t = 0; t < region.after.triangles.size(); ++t) {
      finder.Find(static_cast<std::int32_t>(t));
      const auto corners = testing::CornersIn(now, region.after.triangle_ids[t]);
      const auto& v = now.triangle(region.after.triangle_ids[t]).vertices;
      for (const Overlap& overlap : finder.overlaps()) {
        const TriangleId old = region.before.triangle_ids[static_cast<std::size_t>(overlap.before)];
        const auto& w = edited.before.triangle(old).vertices;
        for (std::size_t i = 2; i < overlap.polygon.count; ++i) {
          const auto& c = overlap.polygon.corners;
          const std::array<Vec2, 3> fan{c[0], c[i - 1], c[i]};
          for (std::size_t side = 0; side < 3; ++side) {
            const Vec2 p = corners[0] + 0.5 * (fan[side] + fan[(side + 1) % 3]);
            const double d = value(corners,
                                   {field.values[v[0].index()], field.values[v[1].index()],
                                    field.values[v[2].index()]},
                                   p) -
                             value(testing::CornersIn(edited.before, old),
                                   {before.values[w[0].index()], before.values[w[1].index()],
                                    before.values[w[2].index()]},
                                   p);
            sum += AreaOf(fan) / 3 * d * d;
          }
        }
      }
    }
    return sum;
  };

  const double least = distance(after);
  MassMatrix lumped = MakeNodalSystem(now, region).matrix;
  const std::size_t count = region.after.vertex_ids.size();
  ASSERT_GT(count, 5U);
  for (std::size_t a = 0; a < count; ++a) {
    const std::size_t b = (a + 1) % count;
    for (const double step : {1e-3, -1e-3}) {
      Field other = after;
      other.values[region.after.vertex_ids[a].index()] += step / lumped.lumped()[a];
      other.values[region.after.vertex_ids[b].index()] -= step / lumped.lumped()[b];
      EXPECT_GT(distance(other), least) << a;
    }
  }
}

TEST(NodalProjection, KeepsTheIntegralWhenTheBoundaryMoves) {
  for (const double factor : {0.5, 1.5}) {
    auto edited = testing::ImportedMesh(testing::GridData(6, 2));
    (void)edited->edit.Commit(Revision(1));
    const Mesh before = edited->mesh;
    for (const VertexId id : testing::LiveVertices(before)) {
      const Vec2 p = before.position(id);
      if (p.x > 3) edited->edit.MoveVertex(id, {3 + factor * (p.x - 3), p.y});
    }
    const MeshTransfer transfer(edited->mesh, edited->edit.log());
    const Field field = NodalField(before, [](Vec2 p) { return 1 + p.x; });
    const Field after = Projected(field, edited->mesh, transfer);
    EXPECT_NEAR(IntegralOf(edited->mesh, after).value, IntegralOf(before, field).value, 1e-12);
  }
}

}  // namespace
}  // namespace pliant
