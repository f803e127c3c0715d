// Goal: nodes that a Lagrangian solver moves by little in every step, all the time, are as many in
// the end as the metric asks for, whether the domain grows, shrinks, or changes its shape alone.
// Each step leaves every single edge good, so that extents alone would never see that all of them
// are a little too long, or too short.

#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <utility>

#include "core/motion/move.h"
#include "core/pliant/remesher.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"
#include "tests/support/steady_count.h"

namespace pliant {
namespace {

constexpr int kSteps = 30;

struct Flow {
  std::string name;
  double nodes;     ///< At the beginning.
  Vec2 of_x, of_y;  ///< What a step makes of (1, 0) and (0, 1).

  [[nodiscard]] Vec2 operator()(Vec2 p) const { return p.x * of_x + p.y * of_y; }
};

/// Those inside segments go along with the ends of these.
MotionRequest RequestOf(const Mesh& mesh, const Flow& flow) {
  MotionRequest request;
  for (const VertexId id : testing::LiveVertices(mesh)) {
    if (mesh.vertex(id).edge.valid() && !mesh.vertex(id).fixed) continue;
    request.vertices.push_back(id);
    request.positions.push_back(flow(mesh.position(id)));
  }
  return request;
}

class SlowMotion : public ::testing::TestWithParam<Flow> {};

// Method: 30 steps; the count against the ideal after each of them, and what is left at the end.
// Without a look at the density around nodes the last count is 0.86 of the ideal where the domain
// grows, and 1.12 where it shrinks.
TEST_P(SlowMotion, KeepsTheCountOfNodes) {
  const Flow& flow = GetParam();
  testing::Case uniform = testing::DiscCase(flow.nodes, testing::DiscState::kOff);
  auto remesher = Remesher::Create(uniform.domain, std::move(uniform.field), Options{}).value();
  ASSERT_TRUE(remesher->Step({}).ok());
  remesher->Commit();
  const auto field = testing::DiscCase(flow.nodes, testing::DiscState::kOff).field;
  for (int step = 0; step < kSteps; ++step) {
    SCOPED_TRACE("step " + std::to_string(step));
    ASSERT_TRUE(MoveVertices(*remesher, RequestOf(remesher->mesh(), flow)).ok());
    ASSERT_TRUE(remesher->Step({}).ok());
    remesher->Commit();
    testing::ExpectSteadyCount(remesher->mesh(), *field, step == kSteps - 1, 0.97);
  }
  EXPECT_EQ(testing::Faults(remesher->mesh()), "");
}

INSTANTIATE_TEST_SUITE_P(Flows, SlowMotion,
                         ::testing::Values(Flow{"Grows", 3500, {1.03, 0}, {0, 1.03}},
                                           Flow{"Shrinks", 20'000, {0.97, 0}, {0, 0.97}},
                                           Flow{"IsDrawnOut", 3500, {1.03, 0}, {0, 1 / 1.03}},
                                           Flow{"IsSheared", 3500, {1, 0}, {0.03, 1}}),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace pliant
