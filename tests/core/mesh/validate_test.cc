// Goal: every fault that Validate looks for is found and named; a checker that cannot fail is
// worthless. Method: break one thing in a valid mesh and read the message.

#include "core/mesh/validate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/mesh_breaker.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using ::testing::Contains;
using testing::GridData;
using ::testing::HasSubstr;
using testing::ImportedMesh;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

struct Break {
  const char* name;
  std::function<void(MeshBreaker&)> apply;
  const char* message;
};

class ValidateFinds : public ::testing::TestWithParam<Break> {};

TEST_P(ValidateFinds, TheFault) {
  // A 3 x 3 grid: vertex 5 and triangle 8 lie inside, vertex 1 inside the bottom segment.
  const auto made = ImportedMesh(GridData(3, 3));
  ASSERT_EQ(testing::Faults(made->mesh), "");
  MeshBreaker breaker(made->mesh);
  GetParam().apply(breaker);
  EXPECT_THAT(Validate(made->mesh), Contains(HasSubstr(GetParam().message)));
}

const Break kBreaks[] = {
    {"PositionNan", [](MeshBreaker& b) { b.vertex(5).position.x = kNan; },
     "vertex 5 is not finite"},
    {"MetricIndefinite",
     [](MeshBreaker& b) {
       b.vertex(5).metric = {1, 2, 1};
     },
     "metric of vertex 5 is not SPD"},
    {"MetricNan", [](MeshBreaker& b) { b.vertex(6).metric.m12 = kNan; },
     "metric of vertex 6 is not SPD"},
    {"PinchedNotFixed", [](MeshBreaker& b) { b.vertex(5).pinched = true; },
     "vertex 5 is pinched but not fixed"},
    {"VertexNamesNoTriangle", [](MeshBreaker& b) { b.vertex(5).triangle = TriangleId(); },
     "vertex 5 names dead triangle -1"},
    {"VertexNamesTriangleBeyondTheEnd",
     [](MeshBreaker& b) { b.vertex(5).triangle = TriangleId(99); }, "names dead triangle 99"},
    {"VertexNamesAnotherTriangle", [](MeshBreaker& b) { b.vertex(0).triangle = TriangleId(17); },
     "vertex 0 is no corner of its triangle 17"},
    {"EdgeListLeavesTheMesh", [](MeshBreaker& b) { b.vertex(1).edge = EdgeId(77); },
     "edge list of vertex 1 is broken at edge 77"},
    {"EdgeListOfAnother", [](MeshBreaker& b) { b.vertex(1).edge = b.vertex(11).edge; },
     "in the list of vertex 1 does not have it"},
    {"EdgeListEndless",
     [](MeshBreaker& b) {
       const EdgeId e = b.vertex(1).edge;
       EdgeRecord& edge = b.edge(e.index());
       edge.next[edge.vertices[0] == VertexId(1) ? 0 : 1] = e;
     },
     "edge list of vertex 1 is broken"},
    {"EdgeNotListed", [](MeshBreaker& b) { b.vertex(1).edge = EdgeId(); },
     "edges are missing in vertex lists"},
    {"TriangleOfDeadVertex", [](MeshBreaker& b) { b.vertex(5).live = false; }, "has dead vertex 5"},
    {"TriangleTurned",
     [](MeshBreaker& b) { std::swap(b.triangle(8).vertices[0], b.triangle(8).vertices[1]); },
     "triangle 8 (6 5 10) is not counter-clockwise"},
    {"TriangleFlat",
     [](MeshBreaker& b) {
       b.vertex(5).position = {2, 2};
     },
     "is not counter-clockwise"},
    {"BitWithoutEdge", [](MeshBreaker& b) { b.triangle(8).constrained = 1; },
     "side 0 of triangle 8 has no edge"},
    {"EdgeWithoutBit", [](MeshBreaker& b) { b.triangle(0).constrained = 0; },
     "of triangle 0 hides an edge"},
    {"HoleWithoutEdge", [](MeshBreaker& b) { b.triangle(8).neighbors[1] = TriangleId(); },
     "side 1 of triangle 8 has no neighbour, no edge"},
    {"DeadNeighbor", [](MeshBreaker& b) { b.triangle(8).neighbors[1] = TriangleId(55); },
     "triangle 8 has dead neighbour 55"},
    {"OneSidedNeighbor", [](MeshBreaker& b) { b.triangle(8).neighbors[1] = TriangleId(0); },
     "triangles 8 and 0 are not neighbours both ways"},
    {"EdgeOfDeadVertex", [](MeshBreaker& b) { b.edge(0).vertices[1] = VertexId(44); },
     "edge 0 has a dead vertex"},
    {"EdgeNamesDeadTriangle", [](MeshBreaker& b) { b.edge(0).triangle = TriangleId(-1); },
     "edge 0 names dead triangle -1"},
    {"EdgeNamesAnotherTriangle", [](MeshBreaker& b) { b.edge(0).triangle = TriangleId(17); },
     "edge 0 is no side of its triangle 17"},
    {"VertexCount", [](MeshBreaker& b) { b.vertices().Free(5); }, "vertex count is wrong"},
    {"TriangleCount", [](MeshBreaker& b) { b.triangles().Free(5); }, "triangle count is wrong"},
    {"EdgeCount", [](MeshBreaker& b) { b.edges().Free(5); }, "edge count is wrong"},
    {"EdgeOfNoSegment", [](MeshBreaker& b) { b.edge(0).segment = -1; }, "edge 0 names no segment"},
    {"EdgeBeyondTheSegments", [](MeshBreaker& b) { b.edge(0).segment = 99; },
     "edge 0 names no segment"},
    {"SegmentWithGap",
     [](MeshBreaker& b) {
       for (std::size_t e = 0; e < 12; ++e) {
         if (b.edge(e).parameters[0] > 0.3) b.edge(e).parameters[0] += 0.01;
       }
     },
     "is interrupted before edge"},
    {"SegmentNotCovered",
     [](MeshBreaker& b) {
       b.segments().push_back({VertexId(5), VertexId(6)});
     },
     "segment 4 is not covered to its end"},
    {"VertexOffItsSegment", [](MeshBreaker& b) { b.vertex(1).position.y = 1e-6; }, "off segment"},
};

INSTANTIATE_TEST_SUITE_P(Validate, ValidateFinds, ::testing::ValuesIn(kBreaks),
                         [](const auto& test) { return std::string(test.param.name); });

// Two squares that share a corner, whose vertex is marked as if it had one fan.
TEST(Validate, FindsATriangleOutsideTheFanOfItsVertex) {
  MeshData data;
  data.points = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {2, 1}, {2, 2}, {1, 2}};
  data.triangles = {{0, 1, 2}, {0, 2, 3}, {2, 4, 5}, {2, 5, 6}};
  const auto made = ImportedMesh(data);
  ASSERT_EQ(testing::Faults(made->mesh), "");
  MeshBreaker(made->mesh).vertex(2).pinched = false;
  EXPECT_THAT(Validate(made->mesh), Contains(HasSubstr("vertex 2 has 4 triangles but a fan of 2")));
}

TEST(Validate, StopsAtTwentyFaults) {
  const auto made = ImportedMesh(GridData(6, 6));
  for (std::size_t v = 0; v < 49; ++v) MeshBreaker(made->mesh).vertex(v).position.x = kNan;
  EXPECT_EQ(Validate(made->mesh).size(), 20U);
}

TEST(Area, IsTheSumOfTheTriangles) { EXPECT_EQ(Area(ImportedMesh(GridData(7, 3))->mesh), 21); }

}  // namespace
}  // namespace pliant
