#include "core/pliant/ask.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/metric/background_field.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::GridData;
using testing::ImportedMesh;

/// Isotropic sizes that grow to the upper right, on a coarse grid.
BackgroundMetric Example() {
  BackgroundMetric metric{.mesh = GridData(3, 3), .tensors = {}};
  for (const Vec2 p : metric.mesh.points) {
    metric.tensors.push_back(Metric::Isotropic(0.1 + p.x + 2 * p.y));
  }
  return metric;
}

// Goal: the answers are those of one question after the other, and each vertex knows from then on
// where its search ended, whether it had a hint before or not.
TEST(AskAt, AnswersAsOneByOneAndKeepsHints) {
  const auto made = ImportedMesh(GridData(9, 9));
  const auto field = BackgroundField::Make(Example(), {}).value();
  const std::vector<VertexId> vertices = testing::LiveVertices(made->mesh);
  ASSERT_GT(vertices.size(), 64U);
  for (std::size_t i = 20; i < vertices.size(); ++i) made->edit.Hint(vertices[i]) = 5;
  std::vector<Metric> metrics(vertices.size());
  AskAt(made->edit, *field, vertices, metrics);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    std::int32_t hint = MetricField::kNoHint;
    EXPECT_EQ(metrics[i], field->At(made->mesh.position(vertices[i]), hint)) << i;
    EXPECT_EQ(made->mesh.hint(vertices[i]), hint) << i;
  }
}

TEST(AskAt, TakesNoVertices) {
  const auto made = ImportedMesh(GridData(1, 1));
  const auto field = BackgroundField::Make(Example(), {}).value();
  AskAt(made->edit, *field, {}, {});
  for (const VertexId id : testing::LiveVertices(made->mesh)) {
    EXPECT_EQ(made->mesh.hint(id), MetricField::kNoHint);
  }
}

}  // namespace
}  // namespace pliant
