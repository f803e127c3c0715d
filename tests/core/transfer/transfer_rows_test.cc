#include "core/transfer/transfer_rows.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/rng.h"
#include "tests/support/random_transfer.h"

namespace pliant {
namespace {

using testing::RandomTransfer;

TransferRow RowOf(const std::array<double, 3>& weights) {
  return MakeTransferRow({VertexId(9), VertexId(4), VertexId(7)}, weights);
}

// Goal: weights add up to exactly 1, as the protocol promises, in whatever order they are added.
TEST(MakeTransferRow, GivesWeightsThatAddUpToOneInAnyOrder) {
  Rng rng(1);
  for (int trial = 0; trial < 20000; ++trial) {
    std::array<double, 3> raw{};
    double sum = 0;
    for (double& weight : raw) {
      weight = std::pow(rng.Unit(), trial % 40);
      sum += weight;
    }
    for (double& weight : raw) weight /= sum;
    const TransferRow row = RowOf(raw);
    const auto [a, b, c] = row.weights;
    ASSERT_EQ((a + b) + c, 1);
    ASSERT_EQ((a + c) + b, 1);
    ASSERT_EQ((b + c) + a, 1);
    for (std::size_t i = 0; i < 3; ++i) {
      ASSERT_GE(row.weights[i], 0);
      ASSERT_EQ(row.weights[i] * 0x1p53, std::floor(row.weights[i] * 0x1p53));
      ASSERT_EQ(row.weights[i] > 0, row.sources[i].valid());
    }
  }
}

TEST(MakeTransferRow, OrdersSourcesAndDropsThoseWithoutWeight) {
  const TransferRow row = RowOf({0.25, 0.75, 0});
  EXPECT_EQ(row.sources, (std::array{VertexId(4), VertexId(9), VertexId()}));
  EXPECT_EQ(row.weights, (std::array{0.75, 0.25, 0.0}));
  EXPECT_EQ(RowOf({1, 0x1p-60, 0}).sources, (std::array{VertexId(9), VertexId(), VertexId()}));
}

TEST(ApplyRow, KeepsConstantsToTheBit) {
  Rng rng(2);
  for (int trial = 0; trial < 1000; ++trial) {
    const double a = rng.Unit() / 2;
    const double b = rng.Unit() / 2;
    const double constant = 2 * rng.Unit() - 1;
    EXPECT_EQ(ApplyRow(RowOf({a, b, 1 - a - b}), [&](VertexId) { return constant; }), constant);
  }
}

// Goal: the rows reproduce linear functions, on well-shaped and on thin triangles, boundary too.
TEST(MakeTransferRows, GivesLinearFunctionsBack) {
  for (const MeshData& data : {testing::GridData(8, 8), testing::ThinGrid()}) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      SCOPED_TRACE(::testing::Message() << "seed " << seed);
      const RandomTransfer edited(data, seed, 80);
      const TransferRows& rows = edited.transfer->rows();
      ASSERT_EQ(rows.rows.size(), rows.vertex_ids.size());
      ASSERT_GT(rows.rows.size(), 5U);
      const auto linear = [](Vec2 p) { return 3 + 2 * p.x - 5 * p.y; };
      for (std::size_t i = 0; i < rows.rows.size(); ++i) {
        const double value = ApplyRow(rows.rows[i], [&](VertexId source) {
          EXPECT_TRUE(edited.before.IsLive(source));
          return linear(edited.before.position(source));
        });
        EXPECT_NEAR(value, linear(edited.now->mesh.position(rows.vertex_ids[i])), 1e-12);
      }
    }
  }
}

// Goal: what stands on a segment takes nothing from the interior, although its position is rounded.
// Method: a field that is 0 on the boundary and huge inside.
TEST(MakeTransferRows, TakesBoundaryValuesFromTheBoundaryAlone) {
  int boundary_rows = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const RandomTransfer edited(testing::ThinGrid(), seed, 120);
    const TransferRows& rows = edited.transfer->rows();
    for (std::size_t i = 0; i < rows.rows.size(); ++i) {
      const VertexRecord& vertex = edited.now->mesh.vertex(rows.vertex_ids[i]);
      if (!vertex.edge.valid() || vertex.fixed) continue;
      ++boundary_rows;
      for (const VertexId source : rows.rows[i].sources) {
        EXPECT_TRUE(!source.valid() || edited.before.vertex(source).edge.valid())
            << "seed " << seed << " vertex " << rows.vertex_ids[i] << " takes from " << source;
      }
    }
  }
  EXPECT_GT(boundary_rows, 50);
}

// Goal: parameters of a segment that was cut since the commit mean other points, and are not used.
TEST(MakeTransferRows, KnowsSegmentsThatWereCut) {
  auto edited = testing::ImportedMesh(testing::GridData(4, 1));
  (void)edited->edit.Commit(Revision(1));
  edited->edit.CutSegment(VertexId(2));  // Of the side from (0, 0) to (4, 0).
  edited->edit.SlideVertex(VertexId(3), 0.75);
  ASSERT_EQ(edited->mesh.position(VertexId(3)), (Vec2{3.5, 0}));
  const MeshTransfer transfer(edited->mesh, edited->edit.log());
  ASSERT_EQ(transfer.rows().vertex_ids, std::vector{VertexId(3)});
  EXPECT_EQ(transfer.rows().rows[0].sources, (std::array{VertexId(3), VertexId(4), VertexId()}));
  EXPECT_EQ(transfer.rows().rows[0].weights, (std::array{0.5, 0.5, 0.0}));
}

// Goal: a boundary vertex that moved out of the old domain takes the nearest old boundary point.
TEST(MakeTransferRows, TakesTheNearestOldPointOutsideOfTheOldDomain) {
  auto edited = testing::ImportedMesh(testing::GridData(4, 4));
  (void)edited->edit.Commit(Revision(1));
  edited->edit.MoveVertex(VertexId(0), {-1, 0.25});  // The corner (0, 0).
  const MeshTransfer transfer(edited->mesh, edited->edit.log());
  ASSERT_EQ(transfer.rows().vertex_ids, std::vector{VertexId(0)});
  // The foot on the left side, from (0, 0) to (0, 1), which is vertex 5.
  const TransferRow& row = transfer.rows().rows[0];
  EXPECT_EQ(row.sources, (std::array{VertexId(0), VertexId(5), VertexId()}));
  EXPECT_EQ(row.weights, (std::array{0.75, 0.25, 0.0}));
}

}  // namespace
}  // namespace pliant
