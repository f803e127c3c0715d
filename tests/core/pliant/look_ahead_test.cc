#include "core/pliant/look_ahead.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "core/mesh/linked_triangles.h"
#include "core/metric/background_field.h"
#include "core/metric/function_field.h"
#include "core/pliant/displace.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

constexpr Vec2 kShift{7.3, 2.6};

/// A grid after random edits, and other tensors at its vertices.
struct LevelGrid {
  LevelGrid() {
    testing::RandomEditor editor(*made, /*seed=*/11);
    for (int i = 0; i < 400; ++i) (void)editor.Step();
    std::vector<Metric> tensors;
    for (const VertexId v : testing::LiveVertices(made->mesh)) {
      const Vec2 p = made->mesh.position(v);
      tensors.push_back({1 + p.x * p.x, 0.3, 1 + p.y});
    }
    field = BackgroundField::OfValid(LinkTriangles(made->mesh).linked, tensors);
  }

  std::unique_ptr<testing::EditedMesh> made = testing::ImportedMesh(testing::GridData(40, 30));
  std::unique_ptr<BackgroundField> field;
};

void ExpectAnswers(const Mesh& mesh, const MetricField& field, std::vector<VertexId> vertices) {
  const std::vector<Ahead> aheads = LookAhead(mesh, field, vertices, kShift);
  ASSERT_EQ(aheads.size(), vertices.size());
  for (std::size_t k = 0; k < vertices.size(); ++k) {
    SCOPED_TRACE(::testing::Message() << "vertex " << vertices[k].value());
    const std::optional<Vec2> place = PlaceAfter(mesh, vertices[k], kShift);
    std::int32_t hint = MetricField::kNoHint;
    const std::optional<Metric> answer = place ? field.Probe(*place, hint) : std::nullopt;
    EXPECT_EQ(aheads[k].tensor, answer);
    EXPECT_TRUE(!answer || aheads[k].place == *place);
  }
}

// Goal: in which order vertices are asked, and from where each walks, plays no part. Method: all
// of them, a few that have no neighbours among them, and both in random order, against one question
// each.
TEST(LookAhead, AnswersAsTheFieldDoesOneByOne) {
  const LevelGrid grid;
  std::vector<VertexId> all = testing::LiveVertices(grid.made->mesh);
  std::vector<VertexId> few;
  for (std::size_t k = 0; k < all.size(); k += 23) few.push_back(all[k]);
  ExpectAnswers(grid.made->mesh, *grid.field, all);
  ExpectAnswers(grid.made->mesh, *grid.field, few);
  ExpectAnswers(grid.made->mesh, *grid.field, {all[5]});
  ExpectAnswers(grid.made->mesh, *grid.field, {});
  std::mt19937_64 rng(/*seed=*/3);
  std::ranges::shuffle(all, rng);
  std::ranges::shuffle(few, rng);
  ExpectAnswers(grid.made->mesh, *grid.field, all);
  ExpectAnswers(grid.made->mesh, *grid.field, few);
}

TEST(LookAhead, AsksAFunctionToo) {
  const LevelGrid grid;
  const auto size = [](Vec2 p) { return Metric{1 + p.x * p.x, 0, 2}; };
  ExpectAnswers(grid.made->mesh, FunctionField<decltype(size)>(size),
                testing::LiveVertices(grid.made->mesh));
}

TEST(LookAhead, LeavesTheRestOutWhenItIsStopped) {
  const LevelGrid grid;
  const StopFlag stop(true);
  const std::vector<VertexId> all = testing::LiveVertices(grid.made->mesh);
  EXPECT_EQ(LookAhead(grid.made->mesh, *grid.field, all, kShift, &stop).size(), all.size());
}

}  // namespace
}  // namespace pliant
