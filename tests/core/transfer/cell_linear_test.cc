#include "core/transfer/cell_linear.h"

#include <gtest/gtest.h>

#include "tests/support/field_testing.h"

namespace pliant {
namespace {

using testing::RandomTransfer;

FieldRows Transfer(const RandomTransfer& edited, const Field& field) {
  return TransferCells(edited.transfer->old(), edited.transfer->region(),
                       edited.transfer->locator(), field);
}

TEST(TransferCells, GivesLinearFunctionsBackOnTheBoundaryToo) {
  const auto linear = [](Vec2 p) { return 1 + 2 * p.x - 3 * p.y; };
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed);
    const RandomTransfer edited(testing::GridData(8, 8), seed, 60);
    const FieldRows rows = Transfer(
        edited,
        testing::FieldOf(edited.before, FieldLocation::kTriangle, TransferKind::kLinear, linear));
    ASSERT_EQ(rows.slots.size(), edited.transfer->region().after.triangles.size());
    for (std::size_t i = 0; i < rows.slots.size(); ++i) {
      const auto corners = testing::CornersIn(edited.now->mesh, TriangleId(rows.slots[i]));
      EXPECT_NEAR(rows.values[i], linear(CenterOf(corners)), 1e-11);
    }
  }
}

TEST(TransferCells, KeepsConstantsToTheBit) {
  const RandomTransfer edited(testing::ThinGrid(), /*seed=*/4, /*steps=*/80);
  for (const TransferKind kind : {TransferKind::kLinear, TransferKind::kBounded}) {
    const FieldRows rows = Transfer(
        edited,
        testing::FieldOf(edited.before, FieldLocation::kTriangle, kind, [](Vec2) { return 0.1; }));
    for (const double value : rows.values) EXPECT_EQ(value, 0.1);
  }
}

// Goal: a jump gets no over- or undershoots with kBounded; with kLinear it does, so the test can
// tell them apart.
TEST(TransferCells, MakesNoNewExtremaIfBounded) {
  const auto jump = [](Vec2 p) { return p.x < 4.1 ? -1.0 : 1.0; };
  const auto extreme = [&](TransferKind kind) {
    double most = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const RandomTransfer edited(testing::GridData(8, 8), seed, 60);
      const FieldRows rows =
          Transfer(edited, testing::FieldOf(edited.before, FieldLocation::kTriangle, kind, jump));
      for (const double value : rows.values) most = std::max(most, std::fabs(value));
    }
    return most;
  };
  EXPECT_EQ(extreme(TransferKind::kBounded), 1);
  EXPECT_GT(extreme(TransferKind::kLinear), 1.05);
}

}  // namespace
}  // namespace pliant
