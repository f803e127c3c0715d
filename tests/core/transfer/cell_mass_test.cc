#include "core/transfer/cell_mass.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/field_testing.h"

namespace pliant {
namespace {

using testing::FieldOf;
using testing::IntegralOf;
using testing::RandomTransfer;

/// The field after the transfer, over the slots of the new mesh.
Field Transferred(const Field& field, const Mesh& now, const MeshTransfer& transfer) {
  OverlapFinder finder(transfer.region(), transfer.locator());
  OverlapComponents pieces(transfer.region());
  CellMass cells(field, transfer.region());
  for (std::size_t t = 0; t < transfer.region().after.triangles.size(); ++t) {
    finder.Find(static_cast<std::int32_t>(t));
    pieces.AddOverlaps(static_cast<std::int32_t>(t), finder);
    cells.Add(static_cast<std::int32_t>(t), finder);
  }
  pieces.Finish(transfer.locator());
  const FieldRows rows = cells.Finish(pieces);
  Field result = field;
  result.values.resize(static_cast<std::size_t>(now.triangle_slots()));
  for (std::size_t i = 0; i < rows.slots.size(); ++i) {
    result.values[static_cast<std::size_t>(rows.slots[i])] = rows.values[i];
  }
  return result;
}

Field Wave(const Mesh& mesh) {
  return FieldOf(mesh, FieldLocation::kTriangle, TransferKind::kConservative,
                 [](Vec2 p) { return p.x * p.x - 30 * p.y + (p.x > 5 ? 17.0 : 0.0); });
}

TEST(CellMass, KeepsTheIntegralAndMakesNoNewExtrema) {
  for (const MeshData& data : {testing::GridData(9, 9), testing::ThinGrid()}) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      SCOPED_TRACE(::testing::Message() << "seed " << seed);
      const RandomTransfer edited(data, seed, 100);
      const Field before = Wave(edited.before);
      const Field after = Transferred(before, edited.now->mesh, *edited.transfer);
      const auto old_integral = IntegralOf(edited.before, before);
      EXPECT_NEAR(IntegralOf(edited.now->mesh, after).value, old_integral.value,
                  1e-14 * old_integral.magnitude);
      double low = 1e300;
      double high = -1e300;
      for (const TriangleId id : testing::LiveTriangles(edited.before)) {
        low = std::min(low, before.values[id.index()]);
        high = std::max(high, before.values[id.index()]);
      }
      for (const TriangleId id : testing::LiveTriangles(edited.now->mesh)) {
        EXPECT_GE(after.values[id.index()], low);
        EXPECT_LE(after.values[id.index()], high);
      }
    }
  }
}

TEST(CellMass, KeepsConstantsToTheBit) {
  const RandomTransfer edited(testing::ThinGrid(), /*seed=*/4, /*steps=*/100);
  const Field before = FieldOf(edited.before, FieldLocation::kTriangle, TransferKind::kConservative,
                               [](Vec2) { return 0.1; });
  const Field after = Transferred(before, edited.now->mesh, *edited.transfer);
  for (const TriangleId id : testing::LiveTriangles(edited.now->mesh)) {
    EXPECT_EQ(after.values[id.index()], 0.1);
  }
}

// Goal: what is split keeps its value; what is merged gets the mean.
TEST(CellMass, IsTheMeanOverTheOldTriangles) {
  auto edited = testing::ImportedMesh(testing::GridData(1, 1));
  (void)edited->edit.Commit(Revision(1));
  Field field{.name = "f",
              .location = FieldLocation::kTriangle,
              .transfer = TransferKind::kConservative,
              .values = {1, 3}};
  for (int corner = 0; corner < 3; ++corner) {
    const auto& triangle = edited->mesh.triangle(TriangleId(0));
    if (triangle.neighbors[static_cast<std::size_t>(corner)].valid()) {
      edited->edit.SwapEdge({TriangleId(0), corner});
      break;
    }
  }
  const MeshTransfer transfer(edited->mesh, edited->edit.log());
  EXPECT_EQ(Transferred(field, edited->mesh, transfer).values, (std::vector<double>{2, 2}));
}

// Goal: a piston. The integral stays when the domain is squeezed and when it expands, and a density
// stays positive.
TEST(CellMass, KeepsTheIntegralWhenTheBoundaryMoves) {
  for (const double factor : {0.3, 0.9, 1.2, 3.0}) {
    SCOPED_TRACE(::testing::Message() << "factor " << factor);
    auto edited = testing::ImportedMesh(testing::GridData(6, 2));
    (void)edited->edit.Commit(Revision(1));
    const Mesh before = edited->mesh;
    for (const VertexId id : testing::LiveVertices(before)) {
      const Vec2 p = before.position(id);
      if (p.x > 3) edited->edit.MoveVertex(id, {3 + factor * (p.x - 3), p.y});
    }
    const MeshTransfer transfer(edited->mesh, edited->edit.log());
    for (const double steepness : {0.0, 1.0}) {
      const Field density = FieldOf(before, FieldLocation::kTriangle, TransferKind::kConservative,
                                    [&](Vec2 p) { return 1 + steepness * p.x; });
      const Field after = Transferred(density, edited->mesh, transfer);
      EXPECT_NEAR(IntegralOf(edited->mesh, after).value, IntegralOf(before, density).value, 1e-13);
      for (const double value : after.values) EXPECT_GT(value, 0);
    }
  }
}

}  // namespace
}  // namespace pliant
