// Goal: the audit lets pass what the proof of termination allows and finds everything it forbids.
// Method: visits played by hand on a small mesh: what a visit may do to the ages is done through
// MeshEdit between Begin and End.

#include "core/pliant/visit_audit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::EditedMesh;
using ::testing::HasSubstr;

constexpr std::uint32_t kEpoch = 3;
constexpr VertexId kNode(6);       // Inside a 4 x 4 grid.
constexpr VertexId kNeighbor(7);   // Next to it.
constexpr VertexId kUnreached(8);  // Next to that; the update has not come so far.

void SetAge(EditedMesh& target, VertexId vertex, int age) {
  target.edit.Visit(vertex).epoch = kEpoch;
  target.edit.Visit(vertex).age = static_cast<std::uint8_t>(age);
}

VertexId SplitSpoke(EditedMesh& target, int age) {
  const TriangleId triangle = target.mesh.vertex(kNode).triangle;
  const int corner = NextCorner(target.mesh.CornerOf(triangle, kNode));
  const auto& v = target.mesh.triangle(triangle).vertices;
  const VertexId far = v[static_cast<std::size_t>(PreviousCorner(corner))] == kNode
                           ? v[static_cast<std::size_t>(NextCorner(corner))]
                           : v[static_cast<std::size_t>(PreviousCorner(corner))];
  const Vec2 middle = 0.5 * (target.mesh.position(kNode) + target.mesh.position(far));
  const VertexId made = target.edit.SplitEdge({triangle, corner}, middle, 0.5);
  SetAge(target, made, age);
  return made;
}

/// What the audit says of a visit of kNode, aged 10 before it.
std::string AuditOf(const std::function<void(EditedMesh&)>& visit) {
  const auto target = testing::ImportedMesh(testing::GridData(4, 4));
  SetAge(*target, kNode, 10);
  SetAge(*target, kNeighbor, 20);
  VisitAudit audit;
  audit.Sync(target->mesh);
  audit.Begin(target->mesh, kNode, kEpoch);
  visit(*target);
  return audit.End(target->mesh);
}

TEST(VisitAudit, LetsPassWhatAVisitMayDo) {
  EXPECT_EQ(AuditOf([](EditedMesh& m) { SetAge(m, kNode, 11); }), "");
  EXPECT_EQ(AuditOf([](EditedMesh& m) {
              SetAge(m, kNode, 11);
              SplitSpoke(m, 11);
            }),
            "");
  // Reaching a node is paid for by the update, not by the visit.
  EXPECT_EQ(AuditOf([](EditedMesh& m) {
              SetAge(m, kNode, 11);
              SetAge(m, kUnreached, 0);
            }),
            "");
}

TEST(VisitAudit, FindsAVisitThatDoesNotAge) {
  EXPECT_THAT(AuditOf([](EditedMesh&) {}), HasSubstr("is as old as before"));
}

TEST(VisitAudit, FindsRejuvenation) {
  EXPECT_THAT(AuditOf([](EditedMesh& m) {
                SetAge(m, kNode, 11);
                SetAge(m, kNeighbor, 19);
              }),
              HasSubstr("node 7 has grown younger"));
}

TEST(VisitAudit, FindsANewNodeThatIsTooYoung) {
  EXPECT_THAT(AuditOf([](EditedMesh& m) {
                SetAge(m, kNode, 11);
                SplitSpoke(m, 10);
              }),
              HasSubstr("must be above 10"));
}

TEST(VisitAudit, FindsTwoNewNodes) {
  EXPECT_THAT(AuditOf([](EditedMesh& m) {
                SetAge(m, kNode, 11);
                SplitSpoke(m, 11);
                SplitSpoke(m, 11);
              }),
              HasSubstr("made 2 nodes"));
}

TEST(VisitAudit, CountsANodeThatWaitedSinceAnEarlierUpdateAsReachedNow) {
  const auto target = testing::ImportedMesh(testing::GridData(4, 4));
  target->edit.Visit(kNode).epoch = kEpoch - 1;
  target->edit.Visit(kNode).age = 70;
  VisitAudit audit;
  audit.Sync(target->mesh);
  audit.Begin(target->mesh, kNode, kEpoch);
  SetAge(*target, kNode, 1);
  EXPECT_EQ(audit.End(target->mesh), "");
  EXPECT_EQ(audit.visit_count(), 1);
}

TEST(SignOfPotentialChange, IsThatOfTheSum) {
  const auto sign = [](const std::vector<std::int64_t>& changes) {
    return SignOfPotentialChange(changes);
  };
  EXPECT_EQ(sign({0, 0, 0}), 0);
  EXPECT_EQ(sign({-1, 2, 0}), -1);  // -1 + 2/3
  EXPECT_EQ(sign({-1, 3, 0}), 0);   // -1 + 3/3
  EXPECT_EQ(sign({-1, 4, -2}), 1);  // -1 + 4/3 - 2/9
  EXPECT_EQ(sign({-1, 4, -3}), 0);  // -1 + 4/3 - 3/9
  EXPECT_EQ(sign({-1, 4, -4}), -1);
  // Beyond what a double or a 64-bit integer can tell: 3^250 against its sum from below.
  std::vector<std::int64_t> long_tail(251, 2);
  long_tail.front() = -1;
  EXPECT_EQ(sign(long_tail), -1);  // 2/3 + 2/9 + ... stays below 1.
  long_tail.back() = 3;
  EXPECT_EQ(sign(long_tail), 0);  // The last one closes the gap exactly,
  long_tail.back() = 4;
  EXPECT_EQ(sign(long_tail), 1);  // and this one tips it.
}

}  // namespace
}  // namespace pliant
