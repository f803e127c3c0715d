#include "core/motion/move.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <memory>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/mesh_diff.h"
#include "core/mesh/validate.h"
#include "core/pliant/quality.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"
#include "tests/support/remesher_testing.h"

namespace pliant {
namespace {

using testing::Faults;
using testing::LeastQuality;

constexpr std::int32_t kWall = 1;
constexpr std::int32_t kBody = 7;

/// The unit square with a polygonal hole, tagged kBody.
Domain SquareWithHole(const std::vector<Vec2>& hole, Vec2 seed) {
  Domain domain = testing::Rectangle({0, 0}, {1, 1});
  const auto first = static_cast<std::int32_t>(domain.points.size());
  domain.points.insert(domain.points.end(), hole.begin(), hole.end());
  const auto count = static_cast<std::int32_t>(hole.size());
  for (std::int32_t i = 0; i < count; ++i) {
    domain.segments.push_back({first + i, first + (i + 1) % count, kBody});
  }
  domain.holes.push_back(seed);
  return domain;
}

std::vector<Vec2> Circle(Vec2 center, double radius, int count) {
  std::vector<Vec2> points;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    points.push_back(center + radius * Vec2{std::cos(angle), std::sin(angle)});
  }
  return points;
}

std::unique_ptr<Remesher> StartWith(const Domain& domain, const MetricSpec& spec) {
  auto made = Remesher::Create(domain, spec, {});
  PLIANT_CHECK(made.ok(), "error", made.error().message);
  PLIANT_CHECK((*made)->Step({}).ok());
  (void)(*made)->Commit();
  return std::move(*made);
}

std::unique_ptr<Remesher> Start(const Domain& domain, const std::string& size) {
  MetricSpec spec;
  spec.source = SizeMetric{size};
  return StartWith(domain, spec);
}

/// Moves, looking at the mesh after every sub-step.
Result<MotionReport> MoveOnly(Remesher& remesher, const MotionRequest& request) {
  int looked = 0;
  Result<MotionReport> report = MoveVertices(remesher, request, [&](const Mesh& mesh) {
    ++looked;
    ASSERT_EQ(Faults(mesh), "") << "after sub-step " << looked;
  });
  EXPECT_EQ(Faults(remesher.mesh()), "");
  if (report.ok()) {
    EXPECT_EQ(report->sub_step_count, looked);
  }
  return report;
}

void RunLoop(Remesher& remesher) {
  const auto progress = remesher.Step({});
  ASSERT_TRUE(progress.ok());
  EXPECT_EQ(progress->stop_reason, StopReason::kConverged);
  EXPECT_EQ(Faults(remesher.mesh()), "");
}

/// Moves and lets the loop run.
MotionReport Move(Remesher& remesher, const MotionRequest& request) {
  const Result<MotionReport> report = MoveOnly(remesher, request);
  EXPECT_TRUE(report.ok()) << report.error().message;
  if (!report.ok()) return {};
  EXPECT_EQ(report->fraction, 1);
  RunLoop(remesher);
  return *report;
}

MotionRequest ByTag(PathShape shape) {
  MotionRequest request;
  request.tags.push_back({{kBody}, std::move(shape)});
  return request;
}

/// Vertices of edges with a tag, ascending.
std::vector<VertexId> VerticesOf(const Mesh& mesh, std::int32_t tag) {
  std::set<VertexId> vertices;
  for (std::int32_t e = 0; e < mesh.edge_slots(); ++e) {
    const EdgeRecord& edge = mesh.edge(EdgeId(e));
    if (edge.live && edge.tag == tag) vertices.insert({edge.vertices[0], edge.vertices[1]});
  }
  return {vertices.begin(), vertices.end()};
}

double MeanQuality(const Remesher& remesher) {
  return MeasureQuality(remesher.mesh(), remesher.field()).q_mean;
}
/// A thin ellipse around (0.5, 0.5).
std::vector<Vec2> Flap() {
  std::vector<Vec2> points = Circle({0, 0}, 1, 48);
  for (Vec2& p : points) p = {0.5 + 0.25 * p.x, 0.5 + 0.05 * p.y};
  return points;
}

TEST(Move, AHoleByHalfItsDiameter) {
  const auto remesher = Start(SquareWithHole(Circle({0.4, 0.5}, 0.1, 32), {0.4, 0.5}), "0.02");
  const double area = Area(remesher->mesh());
  const MotionReport report = Move(*remesher, ByTag(Translation{{0.1, 0}}));
  // In one leap: what it runs over is removed and the rest triangulated at once.
  EXPECT_EQ(report.sub_step_count, 1);
  EXPECT_EQ(report.retriangulate_count, 1);
  EXPECT_NEAR(Area(remesher->mesh()), area, 1e-12);
  EXPECT_GT(MeanQuality(*remesher), 0.96);
}

TEST(Move, AHoleAcrossHalfTheDomainInOneUpdate) {
  const auto remesher = Start(SquareWithHole(Circle({0.2, 0.5}, 0.1, 32), {0.2, 0.5}), "0.02");
  const double area = Area(remesher->mesh());
  Move(*remesher, ByTag(Translation{{0.6, 0.05}}));
  EXPECT_NEAR(Area(remesher->mesh()), area, 1e-12);
  EXPECT_GT(MeanQuality(*remesher), 0.96);
  EXPECT_GT(LeastQuality(*remesher), 0.4);
}

// Goal: no drift: after 36 updates of 10 degrees the flap is where it was, and mesh and quality are
// as good as at the first step.
TEST(Move, AFlapThroughAFullTurn) {
  const auto remesher = Start(SquareWithHole(Flap(), {0.5, 0.5}), "0.02");
  const std::vector<VertexId> body = VerticesOf(remesher->mesh(), kBody);
  std::vector<std::pair<VertexId, Vec2>> given;
  for (const VertexId vertex : body) {
    if (remesher->mesh().vertex(vertex).fixed) {
      given.emplace_back(vertex, remesher->mesh().position(vertex));
    }
  }
  const double area = Area(remesher->mesh());
  const double nodes = remesher->mesh().vertex_count();
  double first = 0;
  double second_quarter = 0;
  double last_quarter = 0;
  for (int step = 0; step < 36; ++step) {
    SCOPED_TRACE(step);
    Move(*remesher, ByTag(Rotation{{0.5, 0.5}, std::numbers::pi / 18}));
    (void)remesher->Commit();
    EXPECT_NEAR(Area(remesher->mesh()), area, 1e-12);
    const double quality = MeanQuality(*remesher);
    if (step == 0) first = quality;
    EXPECT_GT(quality, first - 0.004);
    if (step / 9 == 1) second_quarter += quality / 9;
    if (step / 9 == 3) last_quarter += quality / 9;
    EXPECT_GT(LeastQuality(*remesher), 0.3);
    EXPECT_NEAR(remesher->mesh().vertex_count(), nodes, 0.05 * nodes);
  }
  EXPECT_GT(last_quarter, second_quarter - 0.002);
  for (const auto& [vertex, position] : given) {
    ASSERT_TRUE(remesher->mesh().IsLive(vertex));
    EXPECT_LT(Length(remesher->mesh().position(vertex) - position), 1e-13);
  }
}

TEST(Move, AFlapByAQuarterAndByAFullTurnAtOnce) {
  for (const double angle : {std::numbers::pi / 2, -2 * std::numbers::pi}) {
    SCOPED_TRACE(angle);
    const auto remesher = Start(SquareWithHole(Flap(), {0.5, 0.5}), "0.02");
    Move(*remesher, ByTag(Rotation{{0.5, 0.5}, angle}));
    EXPECT_GT(MeanQuality(*remesher), 0.95);
  }
}

// Goal: the tip passes the wall at a distance of 1/16 of the mesh size, both ways.
TEST(Move, ATipThroughAThinGap) {
  std::vector<Vec2> needle{{0.1, 0.49}, {0.49875, 0.5}, {0.1, 0.51}};
  Domain domain = SquareWithHole(needle, {0.2, 0.5});
  for (Vec2& p : domain.points) {
    if (p.x == 1) p.x = 0.9;
  }
  const auto remesher = Start(domain, "0.02");
  // The tip is 0.39875 away from the centre of its turn, the wall at y = 1 goes down to 0.9.
  MotionRequest lid;
  for (const VertexId vertex : VerticesOf(remesher->mesh(), 3)) {
    const Vec2 p = remesher->mesh().position(vertex);
    if (!remesher->mesh().vertex(vertex).fixed) continue;
    lid.vertices.push_back(vertex);
    lid.positions.push_back({p.x, 0.9});
  }
  ASSERT_EQ(lid.vertices.size(), 2U);
  Move(*remesher, lid);
  Move(*remesher, ByTag(Rotation{{0.1, 0.5}, std::numbers::pi / 2 - 0.1}));
  Move(*remesher, ByTag(Rotation{{0.1, 0.5}, 0.0999}));
  Move(*remesher, ByTag(Rotation{{0.1, 0.5}, -0.3}));
  EXPECT_GT(MeanQuality(*remesher), 0.94);
}

TEST(Move, AGapClosesToATwentiethOfTheMeshSizeAndOpensAgain) {
  const auto remesher = Start(SquareWithHole(Circle({0.5, 0.5}, 0.1, 32), {0.5, 0.5}), "0.02");
  const double area = Area(remesher->mesh());
  const double quality = MeanQuality(*remesher);
  Move(*remesher, ByTag(Translation{{0.399, 0}}));
  EXPECT_NEAR(Area(remesher->mesh()), area, 1e-12);
  EXPECT_GT(LeastQuality(*remesher), 0);
  Move(*remesher, ByTag(Translation{{-0.399, 0}}));
  EXPECT_NEAR(Area(remesher->mesh()), area, 1e-12);
  EXPECT_GT(MeanQuality(*remesher), quality - 0.02);
}

// A block that stands on the floor: its feet are points of the floor and slide along it.
TEST(Move, ABodySlidesAlongAWall) {
  Domain domain;
  domain.points = {{0, 0}, {0.2, 0}, {0.2, 0.2}, {0.4, 0.2}, {0.4, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (std::int32_t i = 0; i < 8; ++i) {
    domain.segments.push_back({i, (i + 1) % 8, i >= 1 && i <= 3 ? kBody : kWall});
  }
  const auto remesher = Start(domain, "0.02");
  const double area = Area(remesher->mesh());
  Move(*remesher, ByTag(Translation{{0.55, 0}}));
  EXPECT_EQ(remesher->mesh().position(VertexId(1)), (Vec2{0.2 + 0.55, 0}));
  EXPECT_NEAR(Area(remesher->mesh()), area, 1e-12);
  EXPECT_GT(MeanQuality(*remesher), 0.95);

  MotionRequest too_far = ByTag(Translation{{0.1, 0}});
  const auto refused = MoveOnly(*remesher, too_far);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kCrossingSegments);
  EXPECT_EQ(refused.error().field, "edges") << "which is what the index counts";
  EXPECT_GE(refused.error().index, 0);
}

TEST(Move, ABarIsBentByAHalfTurn) {
  Domain domain;
  const int count = 40;
  for (int i = 0; i <= count; ++i) domain.points.push_back({2.0 * i / count, 0});
  for (int i = count; i >= 0; --i) domain.points.push_back({2.0 * i / count, 0.1});
  const auto size = static_cast<std::int32_t>(domain.points.size());
  for (std::int32_t i = 0; i < size; ++i) domain.segments.push_back({i, (i + 1) % size, kBody});
  const auto remesher = Start(domain, "0.025");
  const std::vector<Vec2> straight = domain.points;
  const int steps = 6;
  for (int step = 1; step <= steps; ++step) {
    // The axis becomes an arc of the same length.
    const double curvature = std::numbers::pi / 2 * step / steps;
    MotionRequest request;
    for (std::int32_t i = 0; i < size; ++i) {
      const Vec2 p = straight[static_cast<std::size_t>(i)];
      const double angle = curvature * p.x;
      const double radius = 1 / curvature - (p.y - 0.05);
      request.vertices.emplace_back(i);
      request.positions.push_back(
          {radius * std::sin(angle), 1 / curvature - radius * std::cos(angle)});
    }
    SCOPED_TRACE(step);
    Move(*remesher, request);
    for (std::size_t i = 0; i < request.vertices.size(); ++i) {
      EXPECT_EQ(remesher->mesh().position(request.vertices[i]), request.positions[i]);
    }
  }
  EXPECT_GT(MeanQuality(*remesher), 0.93);
}

// Goal: an impossible motion is refused with the fraction of its contact, and leaves the mesh, the
// metric and what the revision had changed before as they were, to the bit.
TEST(Move, ThroughAWallIsRefusedAndChangesNothing) {
  const Domain domain = SquareWithHole(Circle({0.6, 0.5}, 0.1, 32), {0.6, 0.5});
  for (const bool staged : {false, true}) {
    SCOPED_TRACE(staged);
    const auto remesher = Start(domain, "0.03");
    const auto twin = Start(domain, "0.03");
    MetricSpec other;
    other.source = SizeMetric{"0.025"};
    for (Remesher* one : {remesher.get(), twin.get()}) {
      if (!staged) continue;
      ASSERT_TRUE(one->SetMetric(other).ok());
      ASSERT_TRUE(one->Step({.visits_max = 300}).ok());
    }
    const auto refused = MoveOnly(*remesher, ByTag(Translation{{0.4, 0}}));
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::kCrossingSegments);
    EXPECT_THAT(refused.error().message, ::testing::HasSubstr("0.75"));
    const auto tag_of = [&](std::int64_t edge) {
      return remesher->mesh().edge(EdgeId(static_cast<std::int32_t>(edge))).tag;
    };
    ASSERT_GE(refused.error().index, 0);
    ASSERT_GE(refused.error().other_index, 0);
    EXPECT_EQ(std::min(tag_of(refused.error().index), tag_of(refused.error().other_index)), 2);
    EXPECT_EQ(std::max(tag_of(refused.error().index), tag_of(refused.error().other_index)), kBody);
    EXPECT_EQ(testing::DifferenceOf(remesher->mesh(), twin->mesh()), "");
    RunLoop(*remesher);
    RunLoop(*twin);
    EXPECT_EQ(testing::DifferenceOf(remesher->mesh(), twin->mesh()), "");
    EXPECT_EQ(remesher->Commit().summary.state_hash, twin->Commit().summary.state_hash);
  }
}

TEST(Move, ThroughAWallStopsThereOnRequest) {
  const auto remesher = Start(SquareWithHole(Circle({0.6, 0.5}, 0.1, 32), {0.6, 0.5}), "0.03");
  MotionRequest request = ByTag(Translation{{0.4, 0}});
  request.on_impossible = ImpossibleMotion::kStop;
  const auto report = MoveOnly(*remesher, request);
  ASSERT_TRUE(report.ok());
  EXPECT_NEAR(report->fraction, 0.75, 0.001);
  EXPECT_LT(report->fraction, 0.75);
  EXPECT_TRUE(report->first_edge.valid() && report->second_edge.valid());
  RunLoop(*remesher);
}

// A small hole would end up inside a large one without any triangle in between at the end.
TEST(Move, OverAnotherHoleIsRefused) {
  Domain domain = SquareWithHole(Circle({0.2, 0.5}, 0.05, 12), {0.2, 0.5});
  const auto first = static_cast<std::int32_t>(domain.points.size());
  const std::vector<Vec2> other = Circle({0.5, 0.5}, 0.02, 8);
  domain.points.insert(domain.points.end(), other.begin(), other.end());
  for (std::int32_t i = 0; i < 8; ++i) {
    domain.segments.push_back({first + i, first + (i + 1) % 8, 9});
  }
  domain.holes.push_back({0.5, 0.5});
  const auto remesher = Start(domain, "0.05");
  const auto refused = MoveOnly(*remesher, ByTag(Translation{{0.6, 0}}));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kCrossingSegments);
  // Around it there is a way.
  Move(*remesher, ByTag(PolynomialPath{{{0.6, 1}, {0, -1}}}));
  EXPECT_LT(Length(remesher->mesh().position(VertexId(4)) - Vec2{0.85, 0.5}), 1e-14);
}

TEST(Move, EveryBoundaryVertexByIdArrivesBitForBit) {
  const auto remesher = Start(SquareWithHole(Circle({0.5, 0.5}, 0.2, 12), {0.5, 0.5}), "0.04");
  for (int round = 0; round < 3; ++round) {
    MotionRequest request;
    int slid = 0;
    for (const VertexId vertex : VerticesOf(remesher->mesh(), kBody)) {
      const Vec2 arm = remesher->mesh().position(vertex) - Vec2{0.5, 0.5};
      const double angle = std::atan2(arm.y, arm.x) + 0.1;
      const double radius = 0.2 + 0.04 * std::sin(3 * angle + round);
      request.vertices.push_back(vertex);
      request.positions.push_back(Vec2{0.5, 0.5} + radius * Vec2{std::cos(angle), std::sin(angle)});
      if (!remesher->mesh().vertex(vertex).fixed) ++slid;
    }
    EXPECT_TRUE(round > 0 || slid > 10);
    Move(*remesher, request);
    for (std::size_t i = 0; i < request.vertices.size(); ++i) {
      ASSERT_TRUE(remesher->mesh().IsLive(request.vertices[i]));
      EXPECT_EQ(remesher->mesh().position(request.vertices[i]), request.positions[i]);
    }
    (void)remesher->Commit();
  }
  // The cut segments can be rolled back too.
  const auto twin_hash = remesher->Commit().summary.state_hash;
  MotionRequest shift;
  for (const VertexId vertex : VerticesOf(remesher->mesh(), 2)) {
    shift.vertices.push_back(vertex);
    shift.positions.push_back(remesher->mesh().position(vertex) + Vec2{0.01, 0});
  }
  Move(*remesher, shift);
  remesher->Rollback();
  EXPECT_EQ(Faults(remesher->mesh()), "");
  EXPECT_EQ(remesher->Commit().summary.state_hash, twin_hash);
}

// Goal: a Lagrangian solver sends new positions of all nodes, some of which turn triangles over.
TEST(Move, AllNodesByIdArriveBitForBit) {
  const auto remesher = Start(testing::Rectangle({0, 0}, {1, 1}), "0.05");
  MotionRequest request;
  for (const VertexId vertex : testing::LiveVertices(remesher->mesh())) {
    const Vec2 p = remesher->mesh().position(vertex);
    // A vortex that leaves the boundary where it is.
    const double bump = 16 * p.x * (1 - p.x) * p.y * (1 - p.y);
    const double angle = 2.5 * bump * bump;
    const Vec2 arm = p - Vec2{0.5, 0.5};
    request.vertices.push_back(vertex);
    request.positions.push_back(Vec2{0.5, 0.5} +
                                Vec2{std::cos(angle) * arm.x - std::sin(angle) * arm.y,
                                     std::sin(angle) * arm.x + std::cos(angle) * arm.y});
  }
  const auto report = MoveOnly(*remesher, request);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report->removed_count, 0);
  for (std::size_t i = 0; i < request.vertices.size(); ++i) {
    ASSERT_TRUE(remesher->mesh().IsLive(request.vertices[i]));
    EXPECT_EQ(remesher->mesh().position(request.vertices[i]), request.positions[i]);
  }
  RunLoop(*remesher);
  EXPECT_GT(MeanQuality(*remesher), 0.95);
}

TEST(Move, VerticesFarFromTheMotionStayBitForBit) {
  const auto remesher = Start(SquareWithHole(Circle({0.3, 0.3}, 0.1, 32), {0.3, 0.3}), "0.015");
  std::vector<std::pair<VertexId, Vec2>> far;
  for (const VertexId vertex : testing::LiveVertices(remesher->mesh())) {
    const Vec2 p = remesher->mesh().position(vertex);
    if (p.x > 0.6 || p.y > 0.6) far.emplace_back(vertex, p);
  }
  ASSERT_GT(far.size(), 1000U);
  Move(*remesher, ByTag(Translation{{0.03, 0}}));
  for (const auto& [vertex, position] : far) {
    ASSERT_TRUE(remesher->mesh().IsLive(vertex));
    EXPECT_EQ(remesher->mesh().position(vertex), position);
  }
}

TEST(Move, ByNothingChangesNothing) {
  const auto remesher = Start(SquareWithHole(Circle({0.3, 0.3}, 0.1, 32), {0.3, 0.3}), "0.03");
  MotionRequest request;
  for (const VertexId vertex : VerticesOf(remesher->mesh(), kBody)) {
    request.vertices.push_back(vertex);
    request.positions.push_back(remesher->mesh().position(vertex));
  }
  for (const MotionRequest& still : {MotionRequest{}, request}) {
    Move(*remesher, still);
    const MeshDiff diff = remesher->Commit();
    EXPECT_TRUE(diff.empty());
  }
}

// Goal: with follow_length the layer at the body goes with it, nodes and sizes, and is not made
// anew.
TEST(Move, ALayerFollowsItsBody) {
  MetricSpec spec;
  spec.source = SizeMetric{"0.005+0.15*max(0,hypot(x-0.3,y-0.5)-0.1)"};
  const Domain domain = SquareWithHole(Circle({0.3, 0.5}, 0.1, 64), {0.3, 0.5});
  const auto remesher = StartWith(domain, spec);
  const auto near = [&](Vec2 center) {
    std::vector<VertexId> vertices;
    for (const VertexId vertex : testing::LiveVertices(remesher->mesh())) {
      if (Length(remesher->mesh().position(vertex) - center) < 0.12) vertices.push_back(vertex);
    }
    return vertices;
  };
  const std::vector<VertexId> before = near({0.3, 0.5});
  MotionRequest request = ByTag(Translation{{0.2, 0}});
  request.follow_length = 6;
  Move(*remesher, request);
  const std::vector<VertexId> after = near({0.5, 0.5});
  std::vector<VertexId> kept;
  std::set_intersection(before.begin(), before.end(), after.begin(), after.end(),
                        std::back_inserter(kept));
  EXPECT_GT(static_cast<double>(kept.size()), 0.9 * static_cast<double>(before.size()));
  EXPECT_NEAR(static_cast<double>(after.size()), static_cast<double>(before.size()),
              0.1 * static_cast<double>(before.size()));
  std::int32_t hint = MetricField::kNoHint;
  EXPECT_NEAR(1 / std::sqrt(remesher->field().At({0.605, 0.5}, hint).m11), 0.0058, 0.001);
  EXPECT_GT(MeanQuality(*remesher), 0.95);
}

TEST(Move, GivesTheSameBitsTwice) {
  std::vector<std::uint64_t> hashes;
  for (int run = 0; run < 2; ++run) {
    const auto remesher = Start(SquareWithHole(Flap(), {0.5, 0.5}), "0.03");
    Move(*remesher, ByTag(Rotation{{0.5, 0.5}, 1}));
    hashes.push_back(remesher->Commit().summary.state_hash);
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

TEST(Move, GivesDiffsThatAReplicaCanFollow) {
  const auto made = Remesher::Create(SquareWithHole(Flap(), {0.5, 0.5}),
                                     MetricSpec{.source = SizeMetric{"0.03"}}, {});
  ASSERT_TRUE(made.ok());
  Remesher& remesher = **made;
  testing::Replica replica;
  ASSERT_TRUE(remesher.Step({}).ok());
  EXPECT_EQ(replica.Apply(remesher.Commit()), "");
  for (int step = 0; step < 4; ++step) {
    Move(remesher, ByTag(Rotation{{0.5, 0.5}, 0.3}));
    EXPECT_EQ(replica.Apply(remesher.Commit()), "");
    EXPECT_EQ(replica.DifferenceTo(remesher.mesh()), "");
  }
}

}  // namespace
}  // namespace pliant
