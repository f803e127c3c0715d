#include "core/pliant/nodal_field.h"

#include <gtest/gtest.h>

#include <array>
#include <memory>
#include <vector>

#include "core/base/rng.h"
#include "core/mesh/export_mesh.h"
#include "core/metric/background_field.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

// Goal: the same field as that of a background mesh which is a copy of it, while the mesh changes.
TEST(NodalField, IsThatOfACopyAsABackgroundMesh) {
  const auto made = testing::ImportedMesh(testing::GridData(10, 10));
  (void)made->edit.Commit(Revision(1));
  testing::RandomEditor editor(*made, 4);
  for (int i = 0; i < 300; ++i) (void)editor.Step();
  (void)made->edit.Commit(Revision(2));

  BackgroundMetric copy{ExportMesh(made->mesh).data, {}};
  for (const VertexId v : testing::LiveVertices(made->mesh)) {
    copy.tensors.push_back(made->mesh.metric(v));
  }
  const auto expected = BackgroundField::Make(copy, {}).value();
  const NodalField field(std::make_shared<FrozenMesh>(made->edit));
  Rng rng(1);
  std::int32_t hint = MetricField::kNoHint;
  std::int32_t other_hint = MetricField::kNoHint;
  for (int i = 0; i < 500; ++i) {
    (void)editor.Step();
    const Vec2 p = {rng.Uniform(-1, 11), rng.Uniform(-1, 11)};
    EXPECT_LT(RelativeChange(expected->At(p, other_hint), field.At(p, hint)), 1e-7);
    EXPECT_TRUE(hint >= 0);
    std::array<MetricField::LogQuestion, 1> question = {{{p, hint, {}}}};
    field.ProbeLogEach(question);
    EXPECT_EQ(Exp(*question[0].answer), field.At(p, hint));
  }
}

}  // namespace
}  // namespace pliant
