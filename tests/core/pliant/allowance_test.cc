// Goal: the guard grants what the metric asks for, however late that shows, and no more.

#include "core/pliant/allowance.h"

#include <gtest/gtest.h>

#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::EditedMesh;

void SetSize(EditedMesh& target, double size) {
  for (const VertexId id : testing::LiveVertices(target.mesh)) {
    target.edit.SetMetric(id, Metric::Isotropic(size));
  }
}

std::int64_t TakeAll(InsertionAllowance& allowance, const Mesh& mesh) {
  std::int64_t count = 0;
  while (count < 10'000'000 && allowance.Take(mesh)) ++count;
  return count;
}

TEST(WantedNodeCount, IsTheAreaOverThatOfANode) {
  const auto target = testing::ImportedMesh(testing::GridData(10, 10));
  SetSize(*target, 0.1);
  // A unit lattice has sqrt(3)/2 of area for each node: 100 / (0.01 * 0.866) nodes.
  EXPECT_NEAR(WantedNodeCount(target->mesh), 11'547, 1);
}

TEST(InsertionAllowance, IsLinearInWhatThereIsAndWhatIsWanted) {
  const auto target = testing::ImportedMesh(testing::GridData(10, 10));
  InsertionAllowance allowance;
  SetSize(*target, 1);  // Wants 115 nodes; there are 121.
  allowance.BeginUpdate(target->mesh);
  EXPECT_EQ(TakeAll(allowance, target->mesh), kAllowanceFloor + kAllowancePerNode * 121);
  EXPECT_FALSE(allowance.Take(target->mesh));
  SetSize(*target, 0.1);
  EXPECT_FALSE(allowance.Take(target->mesh)) << "a refusal holds for the update";
  allowance.BeginUpdate(target->mesh);
  EXPECT_EQ(TakeAll(allowance, target->mesh), kAllowanceFloor + kAllowancePerNode * 11'547);
}

TEST(InsertionAllowance, GrantsMoreWhenTheMetricTurnsOutFiner) {
  const auto target = testing::ImportedMesh(testing::GridData(10, 10));
  InsertionAllowance allowance;
  SetSize(*target, 1);
  allowance.BeginUpdate(target->mesh);
  for (int i = 0; i < 1'900; ++i) ASSERT_TRUE(allowance.Take(target->mesh));
  SetSize(*target, 0.1);
  EXPECT_EQ(1'900 + TakeAll(allowance, target->mesh), kAllowanceFloor + kAllowancePerNode * 11'547);
}

}  // namespace
}  // namespace pliant
