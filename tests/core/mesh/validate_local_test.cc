// Goal: the check after an operation finds what an operation can break, where it happened, and does
// not look further. Method: break one thing in a valid mesh, ask about triangles near and far.

#include "core/mesh/validate_local.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "core/base/check.h"
#include "tests/support/mesh_breaker.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::GridData;
using ::testing::HasSubstr;
using testing::ImportedMesh;

struct LocalBreak {
  const char* name;
  std::function<void(MeshBreaker&)> apply;
  const char* message;
};

class FaultAroundFinds : public ::testing::TestWithParam<LocalBreak> {};

// A 4 x 4 grid: vertex 6 lies inside, vertex 1 inside the bottom segment; the last triangle, 31, is
// far from both.
TEST_P(FaultAroundFinds, TheFaultWhereItIs) {
  const auto made = ImportedMesh(GridData(4, 4));
  const std::vector<TriangleId> all = testing::LiveTriangles(made->mesh);
  ASSERT_EQ(FaultAround(made->mesh, all), "");
  MeshBreaker breaker(made->mesh);
  GetParam().apply(breaker);
  EXPECT_THAT(FaultAround(made->mesh, all), HasSubstr(GetParam().message));
  EXPECT_EQ(FaultAround(made->mesh, std::vector{all.back()}), "");
}

INSTANTIATE_TEST_SUITE_P(
    All, FaultAroundFinds,
    ::testing::Values(
        LocalBreak{"Inverted",
                   [](MeshBreaker& b) {
                     b.vertex(6).position = {-1, -1};
                   },
                   "is not counter-clockwise"},
        LocalBreak{"Flat",
                   [](MeshBreaker& b) {
                     b.vertex(6).position = {0, 0};
                   },
                   "is not counter-clockwise"},
        LocalBreak{"DeadCorner", [](MeshBreaker& b) { b.vertex(6).live = false; },
                   "has dead vertex 6"},
        LocalBreak{"DeadTriangle", [](MeshBreaker& b) { b.triangle(0).live = false; }, "is dead"},
        LocalBreak{"LostNeighbor", [](MeshBreaker& b) { b.triangle(0).neighbors = {}; },
                   "lies open"},
        LocalBreak{"OneSidedNeighbor",
                   [](MeshBreaker& b) {
                     for (TriangleId& n : b.triangle(0).neighbors) {
                       if (n.valid()) n = TriangleId(20);
                     }
                   },
                   "are not neighbours both ways"},
        LocalBreak{"HiddenEdge", [](MeshBreaker& b) { b.triangle(0).constrained = 0; },
                   "hides an edge"},
        LocalBreak{"NoEdge", [](MeshBreaker& b) { b.triangle(0).constrained = 7; }, "has no edge"},
        LocalBreak{"DeadEdge", [](MeshBreaker& b) { b.edge(0).live = false; }, "edge 0 is dead"},
        LocalBreak{"BackwardEdge",
                   [](MeshBreaker& b) {
                     b.edge(0).parameters = {1, 0};
                   },
                   "runs backwards"},
        LocalBreak{"EdgeElsewhere", [](MeshBreaker& b) { b.edge(0).triangle = TriangleId(31); },
                   "names triangle 31"},
        LocalBreak{"VertexElsewhere", [](MeshBreaker& b) { b.vertex(6).triangle = TriangleId(31); },
                   "names triangle 31"}),
    [](const auto& tested) { return std::string(tested.param.name); });

TEST(CheckOperation, CountsWhatPassesAndThrowsWhatDoesNot) {
  const auto made = ImportedMesh(GridData(3, 3));
  const std::int64_t before = ValidatedOperationCount();
  CheckOperation(made->mesh, VertexId(5));
  EXPECT_EQ(ValidatedOperationCount(), before + 1);
  MeshBreaker(made->mesh).vertex(5).position = {9, 9};
  EXPECT_THROW(CheckOperation(made->mesh, VertexId(5)), InvariantViolation);
  EXPECT_EQ(ValidatedOperationCount(), before + 1);
}

}  // namespace
}  // namespace pliant
