#include "core/motion/plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/validate.h"
#include "core/metric/edge_length.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// The unit square with the middle of its bottom (tag 1) as vertex 4, which slides.
std::unique_ptr<testing::EditedMesh> SquareWithSlider() {
  auto square = testing::DomainMesh(testing::Rectangle({0, 0}, {1, 1}));
  const EdgeId bottom = square->mesh.FindEdge(VertexId(0), VertexId(1));
  const TriangleId triangle = square->mesh.edge(bottom).triangle;
  const auto& v = square->mesh.triangle(triangle).vertices;
  int corner = 0;
  while (v[static_cast<std::size_t>(corner)] == VertexId(0) ||
         v[static_cast<std::size_t>(corner)] == VertexId(1)) {
    ++corner;
  }
  square->edit.SplitEdge({triangle, corner}, {0.5, 0}, 0.5);
  PLIANT_CHECK(testing::Faults(square->mesh).empty());
  return square;
}

TEST(MotionPlan, RefusesWhatItCannotDo) {
  const auto square = SquareWithSlider();
  struct Bad {
    std::function<void(MotionRequest&)> change;
    ErrorCode code;
    std::string field;
    std::int64_t index;
  };
  const auto shape = [](PathShape made) {
    return [made](MotionRequest& r) { r.tags.push_back({{1}, made}); };
  };
  const std::vector<Bad> all = {
      {[](MotionRequest& r) { r.positions.pop_back(); }, ErrorCode::kArrayLength,
       "motion.positions", -1},
      {[](MotionRequest& r) { r.vertices[1] = VertexId(5); }, ErrorCode::kIndexOutOfRange,
       "motion.vertices", 1},
      {[](MotionRequest& r) { r.vertices[1] = VertexId(-1); }, ErrorCode::kIndexOutOfRange,
       "motion.vertices", 1},
      {[](MotionRequest& r) { r.vertices[1] = r.vertices[0]; }, ErrorCode::kDuplicateId,
       "motion.vertices", 1},
      {[](MotionRequest& r) { r.positions[1].y = kNan; }, ErrorCode::kNotFinite, "motion.positions",
       1},
      {[](MotionRequest& r) { r.follow_length = -1; }, ErrorCode::kOutOfRange,
       "motion.follow_length", -1},
      {[](MotionRequest& r) {
         r.tags.push_back({{9}, Translation{}});
       },
       ErrorCode::kIndexOutOfRange, "motion.tags", 0},
      {[](MotionRequest& r) {
         r.tags = {{{1}, Translation{}}, {{2, 1}, Translation{}}};
       },
       ErrorCode::kDuplicateId, "motion.tags", 1},
      {shape(Translation{{kNan, 0}}), ErrorCode::kNotFinite, "motion.tags", 0},
      {shape(Rotation{{0, 0}, 1001}), ErrorCode::kOutOfRange, "motion.tags", 0},
      {shape(AffineMap{1, 0, 0, -1, {}}), ErrorCode::kOutOfRange, "motion.tags", 0},
      {shape(PolynomialPath{}), ErrorCode::kOutOfRange, "motion.tags", 0},
      {shape(PolynomialPath{std::vector<Vec2>(17)}), ErrorCode::kOutOfRange, "motion.tags", 0},
  };
  for (std::size_t i = 0; i < all.size(); ++i) {
    SCOPED_TRACE(i);
    MotionRequest request;
    request.vertices = {VertexId(0), VertexId(1)};
    request.positions = {{0, 0}, {1, 0}};
    all[i].change(request);
    const auto plan = MotionPlan::Make(square->mesh, request);
    ASSERT_FALSE(plan.ok());
    EXPECT_EQ(plan.error().code, all[i].code) << plan.error().message;
    EXPECT_EQ(plan.error().field, all[i].field);
    EXPECT_EQ(plan.error().index, all[i].index);
  }
}

TEST(MotionPlan, FollowsEveryShapeOfPath) {
  const auto square = SquareWithSlider();
  struct Path {
    PathShape shape;
    Vec2 half;  // Where vertex 1, at (1, 0), is at s = 0.5 and at s = 1.
    Vec2 end;
  };
  const std::vector<Path> paths = {
      {Translation{{2, 4}}, {2, 2}, {3, 4}},
      {Rotation{{0, 0}, std::numbers::pi}, {0, 1}, {-1, 0}},
      {Rotation{{1, 1}, -std::numbers::pi / 2}, {1 - std::sqrt(0.5), 1 - std::sqrt(0.5)}, {0, 1}},
      {AffineMap{3, 0, 4, 1, {1, 0}}, {2.5, 2}, {4, 4}},
      {PolynomialPath{{{1, 0}, {0, 4}}}, {1.5, 1}, {2, 4}},
  };
  for (std::size_t i = 0; i < paths.size(); ++i) {
    SCOPED_TRACE(i);
    MotionRequest request;
    request.tags.push_back({{1, 2}, paths[i].shape});
    auto plan = MotionPlan::Make(square->mesh, request);
    ASSERT_TRUE(plan.ok());
    plan->FindRiders(square->mesh);
    ASSERT_EQ(plan->movers().size(), 3U);
    const Mover& mover = plan->movers()[1];
    EXPECT_EQ(mover.vertex, VertexId(1));
    EXPECT_EQ(plan->At(mover, 0), (Vec2{1, 0}));
    EXPECT_LT(Length(plan->At(mover, 0.5) - paths[i].half), 1e-15);
    EXPECT_LT(Length(plan->At(mover, 1) - paths[i].end), 1e-15);
    ASSERT_EQ(plan->riders().size(), 1U);
    EXPECT_EQ(plan->riders()[0].vertex, VertexId(4));
    EXPECT_EQ(plan->riders()[0].t, 0.5);
    // The bottom and both its neighbours; the top has no end that moves but (1, 1).
    EXPECT_EQ(plan->moved_segments().size(), 4U);
  }
}

TEST(MotionPlan, TheFirstMotionOfAPointWinsAndIdsComeBeforeTags) {
  const auto square = SquareWithSlider();
  MotionRequest request;
  request.vertices = {VertexId(0)};
  request.positions = {{-1, -1}};
  request.tags = {{{2}, Translation{{5, 0}}}, {{1}, Translation{{0, 5}}}};
  const auto plan = MotionPlan::Make(square->mesh, request);
  ASSERT_TRUE(plan.ok());
  for (const Mover& mover : plan->movers()) {
    if (mover.vertex == VertexId(0)) {
      EXPECT_EQ(plan->At(mover, 1), (Vec2{-1, -1}));
    }
    if (mover.vertex == VertexId(1)) {
      EXPECT_EQ(plan->At(mover, 1), (Vec2{6, 0}));
    }
    if (mover.vertex == VertexId(2)) {
      EXPECT_EQ(plan->At(mover, 1), (Vec2{6, 1}));
    }
    EXPECT_NE(mover.vertex, VertexId(3));
  }
}

TEST(MotionPlan, CutsASegmentOnlyWhereItBends) {
  const auto square = SquareWithSlider();
  MotionRequest request;
  request.vertices = {VertexId(0), VertexId(1), VertexId(4)};
  request.positions = {{0, -0.1}, {1, -0.2}, {0.25, -0.125}};  // On the new line, elsewhere.
  auto plan = MotionPlan::Make(square->mesh, request);
  ASSERT_TRUE(plan.ok());
  EXPECT_TRUE(plan->cuts().empty());
  plan->FindRiders(square->mesh);
  ASSERT_EQ(plan->riders().size(), 1U);
  EXPECT_TRUE(plan->riders()[0].given);
  EXPECT_NEAR(plan->riders()[0].t_end, 0.25, 1e-15);
  EXPECT_EQ(plan->riders()[0].to, request.positions[2]);

  request.positions[2].y -= 1e-9;
  const auto bent = MotionPlan::Make(square->mesh, request);
  ASSERT_TRUE(bent.ok());
  EXPECT_EQ(bent->cuts(), std::vector<VertexId>{VertexId(4)});
}

TEST(MotionPlan, FollowersAreThoseWithinTheLength) {
  auto grid = testing::ImportedMesh(testing::GridData(8, 8));
  MotionRequest request;
  request.vertices = {VertexId(0)};
  request.positions = {{-0.5, -0.5}};
  request.follow_length = 2.5;
  auto plan = MotionPlan::Make(grid->mesh, request);
  ASSERT_TRUE(plan.ok());
  plan->FindRiders(grid->mesh);
  plan->AddFollowers(grid->mesh);
  for (std::size_t i = 1; i < plan->movers().size(); ++i) {
    const Mover& mover = plan->movers()[i];
    EXPECT_FALSE(mover.given);
    EXPECT_LE(Length(mover.from), 2.5);
    EXPECT_FALSE(grid->mesh.vertex(mover.vertex).edge.valid());
    EXPECT_EQ(plan->At(mover, 1), (mover.from + Vec2{-0.5, -0.5}));
  }
  EXPECT_GE(plan->movers().size(), 2U);
}

// Goal: where a mover is does not depend on the times that were asked for before.
TEST(MotionPlan, PlacesDoNotDependOnTheOrderOfQuestions) {
  const auto square = SquareWithSlider();
  MotionRequest request;
  request.tags = {{{1}, Rotation{{0.3, 0.2}, 1.5}}};
  const auto plan = MotionPlan::Make(square->mesh, request);
  ASSERT_TRUE(plan.ok());
  for (const double s : {0.25, 0.5, 0.25, 0.5, 0.75, 0.25, 1.0, 0.75, 0.5, 0.5, 0.125}) {
    const auto fresh = MotionPlan::Make(square->mesh, request);
    ASSERT_TRUE(fresh.ok());
    for (std::size_t i = 0; i < plan->movers().size(); ++i) {
      EXPECT_EQ(plan->At(plan->movers()[i], s), fresh->At(fresh->movers()[i], s)) << s;
    }
  }
}

/// Shortest ways over edges from some vertices, through vertices that may follow: by looking at all
/// triangles until nothing becomes shorter. Infinite where there is none.
std::vector<double> WaysFrom(const Mesh& mesh, std::span<const VertexId> sources) {
  const double none = std::numeric_limits<double>::infinity();
  std::vector<double> ways(static_cast<std::size_t>(mesh.vertex_slots()), none);
  for (const VertexId source : sources) ways[source.index()] = 0;
  for (bool shorter = true; shorter;) {
    shorter = false;
    for (const TriangleId id : testing::LiveTriangles(mesh)) {
      for (const VertexId from : mesh.triangle(id).vertices) {
        const VertexRecord& record = mesh.vertex(from);
        if (ways[from.index()] > 0 && (record.fixed || record.edge.valid())) continue;
        for (const VertexId to : mesh.triangle(id).vertices) {
          if (to == from) continue;
          const double way = ways[from.index()] + Distance(record.position, record.metric,
                                                           mesh.position(to), mesh.metric(to));
          if (!(way < ways[to.index()])) continue;
          ways[to.index()] = way;
          shorter = true;
        }
      }
    }
  }
  return ways;
}

// Goal: followers are found in the order of their distance, and none is left out.
TEST(MotionPlan, FollowersComeInTheOrderOfTheirDistance) {
  const auto grid = testing::ImportedMesh(testing::GridData(20, 20));
  for (const VertexId id : testing::LiveVertices(grid->mesh)) {
    const Vec2 p = grid->mesh.position(id);
    grid->edit.SetMetric(id, Metric::Isotropic(1 + 0.05 * p.x));
  }
  MotionRequest request;
  request.vertices = {VertexId(0), VertexId(440)};  // Two corners: no side moves as a whole.
  request.positions = {{-0.5, -0.5}, {20, 19}};
  request.follow_length = 5;
  auto plan = MotionPlan::Make(grid->mesh, request);
  ASSERT_TRUE(plan.ok());
  plan->FindRiders(grid->mesh);
  std::vector<VertexId> sources;
  for (const Mover& mover : plan->movers()) sources.push_back(mover.vertex);
  ASSERT_EQ(sources.size(), 2U);
  plan->AddFollowers(grid->mesh);
  const std::vector<double> ways = WaysFrom(grid->mesh, sources);
  std::vector<std::pair<double, VertexId>> expected;
  for (const VertexId id : testing::LiveVertices(grid->mesh)) {
    const VertexRecord& record = grid->mesh.vertex(id);
    const double way = ways[id.index()];
    if (way > 0 && way <= 5 && !record.fixed && !record.edge.valid())
      expected.emplace_back(way, id);
  }
  std::ranges::sort(expected);
  ASSERT_GT(expected.size(), 30U);
  ASSERT_EQ(plan->movers().size(), sources.size() + expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(plan->movers()[sources.size() + i].vertex, expected[i].second) << i;
  }
}

TEST(MotionPlan, CarriedTensorsKeepTheLengthOfCarriedEdges) {
  const auto square = SquareWithSlider();
  const Metric metric{3, 1, 7};
  const Vec2 edge{0.3, -0.2};
  MotionRequest request;
  request.tags = {{{1}, AffineMap{2, 1, 0.5, 1.5, {3, 4}}}};
  const auto plan = MotionPlan::Make(square->mesh, request);
  ASSERT_TRUE(plan.ok());
  const Metric carried = plan->Carried(plan->movers()[0], metric, 1);
  const Vec2 mapped{2 * edge.x + edge.y, 0.5 * edge.x + 1.5 * edge.y};
  EXPECT_NEAR(SquaredLength(carried, mapped), SquaredLength(metric, edge), 1e-14);
}

}  // namespace
}  // namespace pliant
