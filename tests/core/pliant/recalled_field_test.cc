#include "core/pliant/recalled_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "core/mesh/export_mesh.h"
#include "core/mesh/linked_triangles.h"
#include "core/pliant/remesher.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

constexpr double kNodes = 4000;
constexpr Vec2 kBy{0.02, 0};

/// The mesh of a front at 0.4 that knows it well, and tensors of something else at its vertices.
struct Sent {
  explicit Sent(const MetricField& now) {
    testing::Case shock = testing::ShockCase(kNodes, 0.4);
    auto made = Remesher::Create(shock.domain, std::move(shock.field), {});
    EXPECT_TRUE((*made)->Step({}).ok());
    (void)(*made)->Commit();
    target = testing::ImportedMesh(ExportMesh((*made)->mesh()).data);
    const auto before = testing::ShockCase(kNodes, 0.4).field;
    std::int32_t hint = MetricField::kNoHint;
    std::vector<Metric> tensors;
    for (const VertexId v : testing::LiveVertices(target->mesh)) {
      target->edit.SetMetric(v, before->At(target->mesh.position(v), hint));
      tensors.push_back(now.At(target->mesh.position(v), hint));
    }
    (void)target->edit.Commit(Revision(1));
    MeshTriangles triangles = LinkTriangles(target->mesh, nullptr);
    plain = BackgroundField::OfValid(triangles.linked, tensors);
    field = std::make_unique<RecalledField>(BackgroundField::OfValid(triangles.linked, tensors),
                                            std::make_shared<FrozenMesh>(target->edit));
  }

  /// Recalls at the place where a vertex comes to lie; nothing outside the domain.
  std::optional<Metric> RecallAt(VertexId v) const {
    const VertexRecord& record = target->mesh.vertex(v);
    const Vec2 place = record.position + kBy;
    if (!(place.x < 1)) return std::nullopt;
    std::int32_t hint = MetricField::kNoHint;
    (void)plain->At(place, hint);
    return field->Recall({record.metric, place, hint, record.triangle.value()});
  }

  std::unique_ptr<testing::EditedMesh> target;
  std::unique_ptr<BackgroundField> plain;
  std::unique_ptr<RecalledField> field;
};

// Goal: without a shift, and after one where nothing was recalled, the answers are those of the
// same background mesh, bit for bit.
TEST(RecalledField, IsABackgroundUntilItIsTold) {
  const Sent sent(*testing::ShockCase(kNodes, 0.42).field);
  for (const bool told : {false, true}) {
    if (told) sent.field->SetShift(kBy);
    std::int32_t hint = MetricField::kNoHint;
    std::int32_t other = MetricField::kNoHint;
    for (int i = 0; i < 400; ++i) {
      const Vec2 p{0.05 * (i % 20) + 0.013, 0.05 * (i / 20) + 0.017};
      EXPECT_EQ(sent.field->At(p, hint), sent.plain->At(p, other));
      EXPECT_EQ(hint, other);
      EXPECT_EQ(sent.field->Probe(p, hint), sent.plain->Probe(p, other));
    }
  }
  std::int32_t hint = MetricField::kNoHint;
  EXPECT_FALSE(sent.field->Probe({2, 2}, hint).has_value());
}

// Goal: ahead of a front that is thinner than the mesh there, the tensors alone miss it, and what
// is recalled knows it; at the vertices that were sent nothing changes. Method: both are compared
// with the function that the tensors were taken from.
TEST(RecalledField, KnowsAFrontThatTheTensorsMiss) {
  const auto now = testing::ShockCase(kNodes, 0.42).field;
  const Sent sent(*now);
  sent.field->SetShift(kBy);
  std::int64_t recalled = 0;
  std::int64_t missed = 0;
  double worst = 0;
  std::int32_t hint = MetricField::kNoHint;
  for (const VertexId v : testing::LiveVertices(sent.target->mesh)) {
    const std::optional<Metric> answer = sent.RecallAt(v);
    if (!answer) continue;
    ++recalled;
    const Vec2 place = sent.target->mesh.position(v) + kBy;
    const Metric exact = now->At(place, hint);
    worst = std::max(worst, RelativeChange(exact, *answer));
    std::int32_t other = MetricField::kNoHint;
    missed += RelativeChange(exact, sent.plain->At(place, other)) > 0.5 ? 1 : 0;
    EXPECT_LT(RelativeChange(*answer, sent.field->At(place, other)), 1e-6);
  }
  EXPECT_GT(recalled, 500);
  EXPECT_GT(missed, 100);
  EXPECT_LT(worst, 0.2);

  for (const VertexId v : testing::LiveVertices(sent.target->mesh)) {
    const Vec2 p = sent.target->mesh.position(v);
    std::int32_t other = MetricField::kNoHint;
    // RelativeChange rounds to the root of what doubles do.
    EXPECT_LT(RelativeChange(sent.plain->At(p, other), sent.field->At(p, hint)), 1e-7);
  }
}

// Goal: where what was sent contradicts the shift at the corners, nothing is recalled.
TEST(RecalledField, BelievesTheTensorsWhereTheyDisagree) {
  const Sent sent(*testing::ConstantCase(kNodes).field);
  sent.field->SetShift(kBy);
  std::int64_t recalled = 0;
  for (const VertexId v : testing::LiveVertices(sent.target->mesh)) {
    recalled += sent.RecallAt(v).has_value() ? 1 : 0;
  }
  EXPECT_EQ(recalled, 0);
}

}  // namespace
}  // namespace pliant
