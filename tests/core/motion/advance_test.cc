#include "core/motion/advance.h"

#include <gtest/gtest.h>

#include <set>
#include <utility>
#include <vector>

#include "core/mesh/validate.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::Faults;

/// A grid of 8 x 8 cells with one vertex of its interior given a way to go.
struct Board {
  Board(VertexId vertex, Vec2 to, ImpossibleMotion on_impossible = ImpossibleMotion::kRefuse) {
    MotionRequest request;
    request.on_impossible = on_impossible;
    request.vertices = {vertex};
    request.positions = {to};
    auto made = MotionPlan::Make(grid->mesh, request);
    PLIANT_CHECK(made.ok());
    plan.emplace(std::move(*made));
    plan->FindRiders(grid->mesh);
  }

  std::unique_ptr<testing::EditedMesh> grid = testing::ImportedMesh(testing::GridData(8, 8));
  std::optional<MotionPlan> plan;
};

TEST(Advance, AShortWayTakesOneStepAndRemovesNobody) {
  Board board(VertexId(40), {4.2, 4.1});
  Advance advance(board.grid->edit, *board.plan);
  EXPECT_EQ(advance.RunTo(1), 1);
  EXPECT_EQ(board.grid->mesh.position(VertexId(40)), (Vec2{4.2, 4.1}));
  EXPECT_EQ(advance.report().sub_step_count, 1);
  EXPECT_EQ(advance.report().removed_count, 0);
  EXPECT_EQ(Faults(board.grid->mesh), "");
}

TEST(Advance, AVertexGoesThroughOthers) {
  Board board(VertexId(40), {6.9, 4.5});
  int looks = 0;
  double last = 0;
  Advance advance(board.grid->edit, *board.plan, [&](double s) {
    ++looks;
    EXPECT_GT(s, last);
    last = s;
    EXPECT_EQ(Faults(board.grid->mesh), "");
  });
  EXPECT_EQ(advance.RunTo(1), 1);
  EXPECT_EQ(board.grid->mesh.position(VertexId(40)), (Vec2{6.9, 4.5}));
  EXPECT_EQ(looks, advance.report().sub_step_count);
  EXPECT_EQ(last, 1);
  const auto [disturbed, strained] = advance.Disturbed();
  EXPECT_TRUE(std::is_sorted(disturbed.begin(), disturbed.end()));
  EXPECT_TRUE(std::binary_search(disturbed.begin(), disturbed.end(), VertexId(40)));
  EXPECT_TRUE(std::ranges::includes(disturbed, strained));
  // It goes among other triangles.
  EXPECT_FALSE(std::ranges::binary_search(strained, VertexId(40)));
  // Far from the way nothing was touched.
  EXPECT_FALSE(std::binary_search(disturbed.begin(), disturbed.end(), VertexId(0)));
}

TEST(Advance, StopsAtItsLimit) {
  Board board(VertexId(40), {6, 4});
  Advance advance(board.grid->edit, *board.plan);
  EXPECT_EQ(advance.RunTo(0.25), 0.25);
  EXPECT_EQ(board.grid->mesh.position(VertexId(40)), (Vec2{4.5, 4}));
}

// Out of the domain it cannot go, and whoever wants to know before anything else is told.
TEST(Advance, NamesWhoWouldBeOutside) {
  Board board(VertexId(40), {12, 4});
  Advance advance(board.grid->edit, *board.plan);
  EXPECT_EQ(advance.RunTo(1), 0);
  ASSERT_TRUE(advance.Misplaced().has_value());
  EXPECT_EQ(advance.Misplaced()->code, ErrorCode::kPointOutsideDomain);
  EXPECT_EQ(advance.Misplaced()->index, 40);
  EXPECT_EQ(Faults(board.grid->mesh), "");
}

// Else the mesh stays valid, and the vertex stops just before the wall.
TEST(Advance, GoesAsFarAsItCan) {
  Board board(VertexId(40), {12, 4}, ImpossibleMotion::kStop);
  Advance advance(board.grid->edit, *board.plan);
  const double reached = advance.RunTo(1);
  EXPECT_LT(reached, 0.5);
  EXPECT_GT(reached, 0.498);
  EXPECT_LT(board.grid->mesh.position(VertexId(40)).x, 8);
  EXPECT_EQ(Faults(board.grid->mesh), "");
  EXPECT_TRUE(advance.Misplaced().has_value());
  ASSERT_TRUE(advance.Blockers().first.valid());
  const EdgeRecord& wall = board.grid->mesh.edge(advance.Blockers().first);
  for (const VertexId end : wall.vertices) EXPECT_EQ(board.grid->mesh.position(end).x, 8);
}

// Two neighbours change places: no triangle between them can stay, and none can be removed.
TEST(Advance, OpensCavitiesWhereNothingElseHelps) {
  auto grid = testing::ImportedMesh(testing::GridData(8, 8));
  MotionRequest request;
  // Everyone in the interior is named, so nobody may go; a block of 3 x 3 turns by 90 degrees.
  for (std::int32_t y = 1; y < 8; ++y) {
    for (std::int32_t x = 1; x < 8; ++x) {
      request.vertices.emplace_back(9 * y + x);
      const bool turns = x >= 3 && x <= 5 && y >= 3 && y <= 5;
      const Vec2 p{static_cast<double>(x), static_cast<double>(y)};
      request.positions.push_back(turns ? Vec2{8 - p.y, p.x} : p);
    }
  }
  auto plan = MotionPlan::Make(grid->mesh, request);
  ASSERT_TRUE(plan.ok());
  plan->FindRiders(grid->mesh);
  Advance advance(grid->edit, *plan, [&](double) { EXPECT_EQ(Faults(grid->mesh), ""); });
  EXPECT_EQ(advance.RunTo(1), 1);
  EXPECT_EQ(advance.report().removed_count, 0);
  for (std::size_t i = 0; i < request.vertices.size(); ++i) {
    EXPECT_EQ(grid->mesh.position(request.vertices[i]), request.positions[i]);
  }
}

}  // namespace
}  // namespace pliant
