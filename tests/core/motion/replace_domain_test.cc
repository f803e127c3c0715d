#include "core/motion/replace_domain.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/validate.h"
#include "core/motion/move.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::Faults;

constexpr std::int32_t kWall = 7;

void AddSquare(Domain& domain, Vec2 low, Vec2 high) {
  const auto first = static_cast<std::int32_t>(domain.points.size());
  for (const Vec2 p : {low, Vec2{high.x, low.y}, high, Vec2{low.x, high.y}}) {
    domain.points.push_back(p);
  }
  for (std::int32_t i = 0; i < 4; ++i) {
    domain.segments.push_back({first + i, first + (i + 1) % 4, kWall});
  }
}

/// The unit square with a square hole.
Domain Holed(Vec2 low, Vec2 high) {
  Domain domain = testing::Rectangle({0, 0}, {1, 1});
  AddSquare(domain, low, high);
  domain.holes.push_back(0.5 * (low + high));
  return domain;
}

std::unique_ptr<Remesher> StartWith(const Domain& domain, const std::string& size) {
  MetricSpec spec;
  spec.source = SizeMetric{size};
  auto made = Remesher::Create(domain, spec, {});
  PLIANT_CHECK(made.ok(), "error", made.error().message);
  PLIANT_CHECK((*made)->Step({}).ok());
  (void)(*made)->Commit();
  return std::move(*made);
}

void Finish(Remesher& remesher) {
  ASSERT_TRUE(remesher.Step({}).ok());
  ASSERT_EQ(Faults(remesher.mesh()), "");
}

// Goal: what lies away from a hole that appears is not touched, in the mesh and in the diff.
TEST(ReplaceDomain, OpensAHoleWhereItIs) {
  const auto remesher = StartWith(testing::Rectangle({0, 0}, {1, 1}), "0.02");
  std::map<std::int32_t, Vec2> before;
  for (const VertexId id : testing::LiveVertices(remesher->mesh())) {
    before[id.value()] = remesher->mesh().position(id);
  }
  const auto report = ReplaceDomain(*remesher, Holed({0.4, 0.4}, {0.5, 0.5}));
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report->kept_segment_count, 4);
  ASSERT_EQ(Faults(remesher->mesh()), "");
  EXPECT_NEAR(Area(remesher->mesh()), 0.99, 1e-12);
  Finish(*remesher);
  const MeshDiff diff = remesher->Commit();
  EXPECT_LT(diff.vertex_ids.size(), before.size() / 8);
  for (std::size_t i = 0; i < diff.vertex_ids.size(); ++i) {
    const Vec2 way = diff.vertex_positions[i] - Vec2{0.45, 0.45};
    EXPECT_LT(std::max(std::fabs(way.x), std::fabs(way.y)), 0.25);
  }
  for (const VertexId id : diff.removed_vertices) EXPECT_TRUE(before.contains(id.value()));
}

// Goal: holes that move on, merge and vanish leave the mesh of the domain that was sent last; what
// was covered by a hole is meshed as finely as the metric asks.
TEST(ReplaceDomain, FollowsHolesThatMoveMergeAndVanish) {
  const auto remesher = StartWith(Holed({0.2, 0.2}, {0.4, 0.4}), "0.05");
  const std::int32_t count = remesher->mesh().vertex_count();
  Domain two = Holed({0.2, 0.2}, {0.4, 0.4});
  AddSquare(two, {0.5, 0.5}, {0.7, 0.7});
  two.holes.push_back({0.6, 0.6});
  Domain merged = Holed({0.2, 0.2}, {0.7, 0.7});
  Domain notch;  // The hole has reached the boundary.
  notch.points = {{0, 0}, {1, 0}, {1, 1}, {0.7, 1}, {0.7, 0.4}, {0.4, 0.4}, {0.4, 1}, {0, 1}};
  for (std::int32_t i = 0; i < 8; ++i) notch.segments.push_back({i, (i + 1) % 8, i});
  const std::vector<std::pair<Domain, double>> way = {
      {Holed({0.25, 0.2}, {0.45, 0.4}), 0.96},
      {two, 0.92},
      {merged, 0.75},
      {notch, 1 - 0.3 * 0.6},
      {testing::Rectangle({0, 0}, {1, 1}), 1},
      {Holed({0.2, 0.2}, {0.4, 0.4}), 0.96},
      {testing::Rectangle({-1, 0}, {1, 1}), 2},
      {testing::Rectangle({0, 0}, {1, 1}), 1},
  };
  testing::Replica replica;
  ASSERT_EQ(replica.Apply(remesher->Snapshot()), "");
  for (const auto& [domain, area] : way) {
    SCOPED_TRACE(area);
    const auto report = ReplaceDomain(*remesher, domain);
    ASSERT_TRUE(report.ok()) << report.error().message;
    Finish(*remesher);
    EXPECT_NEAR(Area(remesher->mesh()), area, 1e-12);
    ASSERT_EQ(replica.Apply(remesher->Commit()), "");
    ASSERT_EQ(replica.DifferenceTo(remesher->mesh()), "");
    EXPECT_NEAR(remesher->mesh().vertex_count(), count * area, 0.15 * count * area);
  }
}

// Goal: the same domain again costs nothing and changes nothing, also with its points in another
// order; a tag alone changes tags alone.
TEST(ReplaceDomain, ByTheSameChangesNothing) {
  Domain domain = Holed({0.2, 0.2}, {0.4, 0.4});
  domain.points.push_back({0.8, 0.8});  // On no segment.
  domain.regions.push_back({{0.6, 0.6}, 5});
  const auto remesher = StartWith(domain, "0.06");
  ASSERT_TRUE(ReplaceDomain(*remesher, domain).ok());
  Domain renamed = domain;
  std::reverse(renamed.points.begin(), renamed.points.end());
  const auto last = static_cast<std::int32_t>(domain.points.size()) - 1;
  for (Segment& segment : renamed.segments) {
    segment = {last - segment.b, last - segment.a, segment.tag};
  }
  const auto report = ReplaceDomain(*remesher, renamed);
  ASSERT_TRUE(report.ok());
  EXPECT_EQ(report->vertex_of_point.front(), VertexId(last));
  const auto progress = remesher->Step({});
  EXPECT_EQ(progress->counts.visits, 0);
  EXPECT_TRUE(remesher->Commit().empty());

  domain.segments[0].tag = 99;
  ASSERT_TRUE(ReplaceDomain(*remesher, domain).ok());
  const MeshDiff diff = remesher->Commit();
  EXPECT_TRUE(diff.vertex_ids.empty() && diff.triangle_ids.empty());
  EXPECT_FALSE(diff.edge_ids.empty());
  for (const std::int32_t tag : diff.edge_tags) EXPECT_EQ(tag, 99);
}

// Goal: a point that is given no longer is free, and one given anew at a vertex is that vertex.
TEST(ReplaceDomain, TakesPointsFromTheNewDomain) {
  Domain domain = testing::Rectangle({0, 0}, {1, 1});
  domain.points.push_back({0.3, 0.3});
  const auto remesher = StartWith(domain, "0.2");
  const Mesh& mesh = remesher->mesh();
  ASSERT_TRUE(mesh.vertex(VertexId(4)).fixed);
  VertexId free;
  for (const VertexId id : testing::LiveVertices(mesh)) {
    if (!mesh.vertex(id).edge.valid() && !mesh.vertex(id).fixed) free = id;
  }
  domain.points[4] = mesh.position(free);
  const auto report = ReplaceDomain(*remesher, domain);
  ASSERT_TRUE(report.ok()) << report.error().message;
  EXPECT_EQ(report->vertex_of_point[4], free);
  EXPECT_TRUE(mesh.vertex(free).fixed);
  EXPECT_FALSE(mesh.vertex(VertexId(4)).fixed);
  ASSERT_EQ(Faults(mesh), "");
}

// Goal: what cannot be is refused with the words of creation, and leaves no trace.
TEST(ReplaceDomain, RefusesBadDomainsAndLeavesTheSessionAlone) {
  const auto remesher = StartWith(testing::Rectangle({0, 0}, {1, 1}), "0.1");
  const Bytes before = *remesher->Save();
  Domain crossing = Holed({0.5, 0.5}, {1.5, 0.7});
  Domain open = testing::Rectangle({0, 0}, {1, 1});
  open.segments.pop_back();
  Domain outside = testing::Rectangle({0, 0}, {1, 1});
  outside.points.push_back({3, 3});
  const std::vector<std::pair<Domain, ErrorCode>> bad = {
      {crossing, ErrorCode::kCrossingSegments},
      {open, ErrorCode::kOpenLoop},
      {outside, ErrorCode::kPointOutsideDomain},
      {Domain(), ErrorCode::kEmpty},
  };
  for (const auto& [domain, code] : bad) {
    const auto report = ReplaceDomain(*remesher, domain);
    const auto at_creation = Remesher::Create(domain, MetricSpec(), {});
    ASSERT_FALSE(report.ok());
    ASSERT_FALSE(at_creation.ok());
    EXPECT_EQ(report.error().code, code);
    EXPECT_EQ(report.error().message, at_creation.error().message);
    EXPECT_EQ(report.error().index, at_creation.error().index);
  }
  EXPECT_EQ(*remesher->Save(), before);
}

TEST(ReplaceDomain, NeedsARevision) {
  auto made = Remesher::Create(testing::Rectangle({0, 0}, {1, 1}), MetricSpec(), {});
  const auto report = ReplaceDomain(**made, testing::Rectangle({0, 0}, {2, 1}));
  ASSERT_FALSE(report.ok());
  EXPECT_EQ(report.error().code, ErrorCode::kRevisionNotFound);
}

// Goal: what is frozen stays, or the domain is refused; beside it the domain may change.
TEST(ReplaceDomain, RespectsWhatIsFrozen) {
  Domain domain = testing::Rectangle({0, 0}, {1, 1});
  AddSquare(domain, {0.1, 0.1}, {0.4, 0.4});
  domain.regions.push_back({{0.2, 0.2}, 3});
  const auto remesher = StartWith(domain, "0.05");
  Constraints constraints;
  constraints.regions = {3};
  ASSERT_TRUE(remesher->SetConstraints(constraints).ok());
  ASSERT_TRUE(remesher->Step({}).ok());
  (void)remesher->Commit();
  const Bytes before = *remesher->Save();
  for (const Vec2 at : {Vec2{0.2, 0.2}, Vec2{0.35, 0.2}}) {
    Domain through = domain;
    through.segments.resize(4);
    through.points.resize(4);
    through.regions.clear();
    AddSquare(through, at, at + Vec2{0.11, 0.13});
    through.holes.push_back(at + Vec2{0.05, 0.05});
    const auto refused = ReplaceDomain(*remesher, through);
    ASSERT_FALSE(refused.ok());
    EXPECT_EQ(refused.error().code, ErrorCode::kFrozen) << refused.error().message;
    EXPECT_EQ(*remesher->Save(), before);
  }
  Domain beside = domain;
  AddSquare(beside, {0.6, 0.6}, {0.8, 0.8});
  beside.holes.push_back({0.7, 0.7});
  const auto report = ReplaceDomain(*remesher, beside);
  ASSERT_TRUE(report.ok()) << report.error().message;
  Finish(*remesher);
}

// Goal: fields go on as the nearest old value where there was nothing, and are linear where there
// was something; conservative ones have no meaning and are refused, whenever they are set.
TEST(ReplaceDomain, CarriesFields) {
  const auto remesher = StartWith(Holed({0.2, 0.2}, {0.4, 0.4}), "0.05");
  const auto values = [&](const std::string& name) {
    FieldValues field;
    field.name = name;
    for (const VertexId id : testing::LiveVertices(remesher->mesh())) {
      field.values.push_back(remesher->mesh().position(id).x);
    }
    return field;
  };
  ASSERT_TRUE(remesher->SetFields({.values = {values("x")}}).ok());
  ASSERT_TRUE(ReplaceDomain(*remesher, testing::Rectangle({0, 0}, {2, 1})).ok());
  FieldUpdate mass{.values = {values("mass")}, .transfer = TransferKind::kConservative};
  EXPECT_EQ(remesher->SetFields(mass).error().code, ErrorCode::kUnimplemented);
  Finish(*remesher);
  (void)remesher->CommitAndTransfer();
  const Field* field = remesher->fields().Find("x");
  for (const VertexId id : testing::LiveVertices(remesher->mesh())) {
    const Vec2 p = remesher->mesh().position(id);
    const double value = field->row(id.index())[0];
    const bool in_hole = p.x > 0.2 && p.x < 0.4 && p.y > 0.2 && p.y < 0.4;
    if (p.x > 1) {
      EXPECT_NEAR(value, 1, 1e-12) << p.x << " " << p.y;
    } else if (!in_hole) {
      EXPECT_NEAR(value, p.x, 1e-12) << p.x << " " << p.y;
    } else {
      EXPECT_TRUE(value >= 0.2 - 1e-12 && value <= 0.4 + 1e-12) << value;
    }
  }
  ASSERT_TRUE(
      remesher->SetFields({.values = {values("mass")}, .transfer = TransferKind::kConservative})
          .ok());
  const auto refused = ReplaceDomain(*remesher, testing::Rectangle({0, 0}, {1, 1}));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kUnimplemented);
}

// Goal: what vertices carried along earlier in the revision becomes the metric, and wakes nodes by
// way of limits, for an update that is taken and not for one that is refused.
TEST(ReplaceDomain, RefusedAfterAMotionLeavesWhatTheMotionLeft) {
  MetricSpec spec;
  spec.source = SizeMetric{"0.01+0.3*hypot(x-0.3,y-0.3)"};
  spec.gradation.gradation = 1.3;
  const auto remesher = *Remesher::Create(Holed({0.2, 0.2}, {0.4, 0.4}), spec, {});
  ASSERT_TRUE(remesher->Step({}).ok());
  (void)remesher->Commit();
  MotionRequest motion;
  motion.tags = {{{kWall}, Translation{{0.2, 0.1}}}};
  motion.follow_length = 3;
  ASSERT_TRUE(MoveVertices(*remesher, motion).ok());
  const auto before = std::vector<VertexRecord>(remesher->mesh().vertex_records().begin(),
                                                remesher->mesh().vertex_records().end());
  Domain crossing = testing::Rectangle({0, 0}, {1, 1});
  crossing.segments.push_back({0, 2, 1});
  crossing.segments.push_back({1, 3, 1});
  ASSERT_FALSE(ReplaceDomain(*remesher, crossing).ok());
  const auto after = remesher->mesh().vertex_records();
  ASSERT_EQ(after.size(), before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    ASSERT_EQ(after[i].metric, before[i].metric) << i;
    ASSERT_EQ(after[i].visit, before[i].visit) << i;
  }
}

// Goal: a hole seed alone makes a hole of a region, and taking it away fills it; both without a
// vertex on a segment that moves.
TEST(ReplaceDomain, FillsAndEmptiesALoopThatStays) {
  Domain loop = testing::Rectangle({0, 0}, {1, 1});
  AddSquare(loop, {0.3, 0.3}, {0.6, 0.6});
  Domain hole = loop;
  hole.holes.push_back({0.4, 0.4});
  const auto remesher = StartWith(loop, "0.05");
  for (const Domain* domain : {&hole, &loop, &hole}) {
    const auto report = ReplaceDomain(*remesher, *domain);
    ASSERT_TRUE(report.ok()) << report.error().message;
    EXPECT_EQ(report->kept_segment_count, 8);
    ASSERT_EQ(Faults(remesher->mesh()), "");
    EXPECT_NEAR(Area(remesher->mesh()), domain->holes.empty() ? 1 : 0.91, 1e-12);
    (void)remesher->CommitAndTransfer();
  }
}

// Goal: undo and redo over a replaced domain give the records of before, bit for bit, segments
// included, and the session goes on with motions of the new boundary.
TEST(ReplaceDomain, CanBeUndoneAndGoesOnMoving) {
  const auto remesher = StartWith(Holed({0.2, 0.2}, {0.4, 0.4}), "0.05");
  const Bytes before = *remesher->Save();
  ASSERT_TRUE(ReplaceDomain(*remesher, Holed({0.5, 0.5}, {0.7, 0.6})).ok());
  Finish(*remesher);
  (void)remesher->Commit();
  const Bytes after = *remesher->Save();
  const auto undo = remesher->TakeUndo();
  ASSERT_TRUE(undo.has_value());
  const RevisionDelta redo = remesher->InverseOf(*undo);
  ASSERT_TRUE(remesher->Apply(*undo, undo->revision).ok());
  EXPECT_EQ(*remesher->Save(), before);
  ASSERT_TRUE(remesher->Apply(redo, redo.revision).ok());
  EXPECT_EQ(*remesher->Save(), after);

  MotionRequest motion;
  motion.tags = {{{kWall}, Translation{{-0.3, 0.1}}}};
  const auto moved = MoveVertices(*remesher, motion);
  ASSERT_TRUE(moved.ok()) << moved.error().message;
  Finish(*remesher);
  EXPECT_NEAR(Area(remesher->mesh()), 0.98, 1e-12);
}

}  // namespace
}  // namespace pliant
