// Goal: a boundary whose nodes a solver moves by itself follows the metric when it is compressed
// again, moves by no more than the tolerance, and keeps what is to be kept: sharp corners, tags,
// regions, frozen things, and everything if no tolerance is given.
// Method: bodies that are stretched, bent and let go by sending the positions of all nodes, beside
// the same without a tolerance; areas, distances and counts are taken from the outside.

#include "core/motion/soften.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/validate.h"
#include "core/motion/move.h"
#include "core/pliant/quality.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::Faults;

constexpr double kSize = 0.1;
constexpr std::int32_t kRim = 5;
constexpr std::int32_t kBar = 7;

using Map = std::function<Vec2(Vec2)>;

std::unique_ptr<Remesher> StartWith(const Domain& domain, double tolerance,
                                    const std::string& size = "0.1") {
  auto made =
      Remesher::Create(domain, {.source = SizeMetric{size}}, {.boundary_tolerance = tolerance});
  PLIANT_CHECK(made.ok(), "error", made.error().message);
  PLIANT_CHECK((*made)->Step({}).ok());
  (void)(*made)->Commit();
  return std::move(*made);
}

/// Sends the positions of all nodes.
void MoveAll(Remesher& body, const Map& map) {
  MotionRequest request;
  for (const VertexId id : testing::LiveVertices(body.mesh())) {
    request.vertices.push_back(id);
    request.positions.push_back(map(body.mesh().position(id)));
  }
  const auto report = MoveVertices(body, request);
  ASSERT_TRUE(report.ok()) << report.error().message;
  ASSERT_EQ(Faults(body.mesh()), "");
}

std::int64_t Soften(Remesher& body) {
  const auto report = SoftenBoundary(body);
  EXPECT_TRUE(report.ok());
  EXPECT_EQ(Faults(body.mesh()), "");
  return report.ok() ? report->softened_count : -1;
}

void StepToTheEnd(Remesher& body) {
  ASSERT_TRUE(body.Step({}).ok());
  ASSERT_EQ(Faults(body.mesh()), "");
  (void)body.Commit();
}

double BoundaryLength(const Mesh& mesh) {
  double length = 0;
  for (const auto& [tag, of_tag] : testing::TagLengths(mesh)) length += of_tag;
  return length;
}

std::int32_t CornerCount(const Mesh& mesh) {
  std::int32_t count = 0;
  for (const VertexId id : testing::LiveVertices(mesh)) count += mesh.vertex(id).fixed ? 1 : 0;
  return count;
}

/// A bar of 2 by 0.5 whose waist gets thinner while it is stretched, like a specimen that necks:
/// the sides bend, so that each node of them becomes a corner.
class Bar {
 public:
  explicit Bar(double tolerance)
      : body_(StartWith(testing::Rectangle({-1, -0.25}, {1, 0.25}), tolerance)) {}

  [[nodiscard]] Remesher& body() { return *body_; }
  [[nodiscard]] const Mesh& mesh() const { return body_->mesh(); }

  /// One step of a solver. @param stretch  1 is the bar as it was made
  void GoTo(double stretch) {
    const double before = std::exchange(stretch_, stretch);
    ASSERT_NO_FATAL_FAILURE(MoveAll(*body_, [&](Vec2 p) {
      const double x = p.x / before;
      const double y = p.y / Width(x, before);
      return Vec2{stretch * x, Width(x, stretch) * y};
    }));
    const double area = Area(mesh());
    const double length = BoundaryLength(mesh());
    softened_ += Soften(*body_);
    const double tolerance = body_->options().boundary_tolerance;
    EXPECT_LE(std::fabs(Area(mesh()) - area), tolerance * length);
    ASSERT_NO_FATAL_FAILURE(StepToTheEnd(*body_));
  }

  /// To three times the length and back.
  void ThereAndBack(int steps) {
    for (int i = 1; i <= steps; ++i) {
      const double s = static_cast<double>(i) / steps;
      ASSERT_NO_FATAL_FAILURE(GoTo(s <= 0.5 ? 1 + 4 * s : 5 - 4 * s)) << "step " << i;
    }
  }

  [[nodiscard]] std::int64_t softened() const { return softened_; }
  [[nodiscard]] std::vector<Vec2> BoundaryPoints() const {
    std::vector<Vec2> points;
    for (const VertexRecord& vertex : mesh().vertex_records()) {
      if (vertex.live && vertex.edge.valid()) points.push_back(vertex.position);
    }
    return points;
  }

 private:
  static double Width(double x, double stretch) {
    return 1 - 0.15 * (stretch - 1) * std::cos(x * std::numbers::pi / 2);
  }

  std::unique_ptr<Remesher> body_;
  double stretch_ = 1;
  std::int64_t softened_ = 0;
};

TEST(Soften, ABarThatWasStretchedHasTheNodesOfAFreshOne) {
  Bar bar(0.05 * kSize);
  const std::int32_t fresh = bar.mesh().edge_count();
  ASSERT_NO_FATAL_FAILURE(bar.ThereAndBack(30));
  EXPECT_GT(bar.softened(), 0);
  EXPECT_NEAR(bar.mesh().edge_count(), fresh, 0.1 * fresh);
  EXPECT_NEAR(Area(bar.mesh()), 1, 0.01);
  double off_sides = 0;
  for (const Vec2 p : bar.BoundaryPoints()) {
    off_sides = std::max(off_sides,
                         std::min(std::fabs(std::fabs(p.x) - 1), std::fabs(std::fabs(p.y) - 0.25)));
  }
  EXPECT_LT(off_sides, 0.5 * 0.05 * kSize);
  const Quality quality = MeasureQuality(bar.mesh(), bar.body().field());
  EXPECT_GT(quality.q_mean, 0.95);

  Bar without(0);
  ASSERT_NO_FATAL_FAILURE(without.ThereAndBack(30));
  EXPECT_EQ(without.softened(), 0);
  EXPECT_GT(without.mesh().edge_count(), 1.5 * fresh);
}

TEST(Soften, OneStepIsEnough) {
  Bar bar(0.1 * kSize);
  const std::int32_t fresh = bar.mesh().edge_count();
  ASSERT_NO_FATAL_FAILURE(bar.GoTo(3));
  ASSERT_GT(bar.mesh().edge_count(), 2 * fresh);
  ASSERT_NO_FATAL_FAILURE(bar.GoTo(2.9));  // Every node of a side is a corner now.
  ASSERT_NO_FATAL_FAILURE(bar.GoTo(1));
  EXPECT_NEAR(bar.mesh().edge_count(), fresh, 0.2 * fresh);
}

// What is straight needs no tolerance worth mentioning.
TEST(Soften, CornersInALineGoWithAnyTolerance) {
  Domain domain;
  for (int i = 0; i < 30; ++i) domain.points.push_back({i / 30.0, i / 10.0});
  domain.points.push_back({1, 3});
  domain.points.push_back({-3, 3});
  const auto count = static_cast<std::int32_t>(domain.points.size());
  for (std::int32_t i = 0; i < count; ++i) domain.segments.push_back({i, (i + 1) % count, kRim});
  const auto body = StartWith(domain, 1e-300, "0.4");
  ASSERT_EQ(CornerCount(body->mesh()), count);
  ASSERT_NO_FATAL_FAILURE(MoveAll(*body, [](Vec2 p) { return p + Vec2{0.25, 0.5}; }));
  const double area = Area(body->mesh());
  EXPECT_GT(Soften(*body), 20);
  EXPECT_NEAR(Area(body->mesh()), area, 1e-12);
  ASSERT_NO_FATAL_FAILURE(StepToTheEnd(*body));
  EXPECT_LT(CornerCount(body->mesh()), 8);
}

Domain Disc(Vec2 center, double radius, int count, std::int32_t tag) {
  Domain domain;
  for (int i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * i / count;
    domain.points.push_back(center + radius * Vec2{std::cos(angle), std::sin(angle)});
    domain.segments.push_back({i, (i + 1) % count, tag});
  }
  return domain;
}

void Append(const Domain& part, Domain& whole) {
  const auto first = static_cast<std::int32_t>(whole.points.size());
  whole.points.insert(whole.points.end(), part.points.begin(), part.points.end());
  for (const Segment& s : part.segments) {
    whole.segments.push_back({first + s.a, first + s.b, s.tag});
  }
}

double DistanceToSegment(Vec2 p, Vec2 a, Vec2 b) {
  const Vec2 along = b - a;
  const double t = std::clamp(Dot(p - a, along) / Dot(along, along), 0.0, 1.0);
  return Length(p - (a + t * along));
}

/// How far points are from the edges of a tag, the farthest of them.
double DistanceToEdges(const std::vector<Vec2>& points, const Mesh& mesh, std::int32_t tag) {
  double farthest = 0;
  for (const Vec2 p : points) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const EdgeRecord& edge : mesh.edge_records()) {
      if (!edge.live || edge.tag != tag) continue;
      nearest = std::min(nearest, DistanceToSegment(p, mesh.position(edge.vertices[0]),
                                                    mesh.position(edge.vertices[1])));
    }
    farthest = std::max(farthest, nearest);
  }
  return farthest;
}

std::vector<Vec2> PointsOf(const Mesh& mesh, std::int32_t tag) {
  std::vector<Vec2> points;
  for (const EdgeRecord& edge : mesh.edge_records()) {
    if (!edge.live || edge.tag != tag) continue;
    for (const VertexId end : edge.vertices) points.push_back(mesh.position(end));
  }
  return points;
}

// The Hausdorff distance between the curve before and after each softening.
TEST(Soften, ADiscThatIsSqueezedKeepsItsShape) {
  const double tolerance = 0.1 * kSize;
  const auto body = StartWith(Disc({0, 0}, 1, 64, kRim), tolerance);
  const std::int32_t fresh = body->mesh().edge_count();
  std::int64_t softened = 0;
  for (int i = 0; i < 24; ++i) {
    const double s = i < 12 ? 1.06 : 1 / 1.06;
    ASSERT_NO_FATAL_FAILURE(MoveAll(*body, [&](Vec2 p) {
      return Vec2{s * p.x, p.y / s * (1 + 0.02 * p.x)};
    }));
    const Mesh& mesh = body->mesh();
    const std::vector<Vec2> sent = PointsOf(mesh, kRim);
    softened += Soften(*body);
    // Its nodes are still there: the loop has not run.
    ASSERT_EQ(PointsOf(mesh, kRim).size(), sent.size());
    EXPECT_LE(DistanceToEdges(sent, mesh, kRim), tolerance * (1 + 1e-9));
    ASSERT_NO_FATAL_FAILURE(StepToTheEnd(*body));
  }
  EXPECT_GT(softened, 0);
  EXPECT_LT(body->mesh().edge_count(), 1.2 * fresh);
}

TEST(Soften, AnInternalConstraintKeepsItsRegionsAndATagItsEnds) {
  Domain domain = testing::Rectangle({-1, -1}, {1, 1});
  Domain disc = Disc({0, 0}, 0.5, 80, kBar);
  for (int i = 0; i < 40; ++i) disc.segments[static_cast<std::size_t>(i)].tag = kRim;
  Append(disc, domain);
  domain.regions.push_back({{0, 0}, 3});
  domain.regions.push_back({{0.9, 0.9}, 4});
  const double tolerance = 0.05 * kSize;
  const auto body = StartWith(domain, tolerance, "0.2");
  const auto regions = testing::RegionAreas(body->mesh());
  const auto lengths = testing::TagLengths(body->mesh());
  const VertexId between_tags(4);  // Where the tags change: the point (0.5, 0).
  ASSERT_EQ(body->mesh().position(between_tags), (Vec2{0.5, 0}));
  const VertexId also_between(44);
  // Nothing moves by more than what makes everybody look.
  ASSERT_NO_FATAL_FAILURE(MoveAll(*body, [](Vec2 p) { return p + Vec2{1e-9, 0}; }));
  EXPECT_GT(Soften(*body), 20);
  const auto regions_after = testing::RegionAreas(body->mesh());
  ASSERT_EQ(regions_after.size(), regions.size());
  for (const auto& [region, area] : regions) {
    EXPECT_NEAR(regions_after.at(region), area, tolerance * std::numbers::pi);
  }
  for (const auto& [tag, length] : testing::TagLengths(body->mesh())) {
    EXPECT_NEAR(length, lengths.at(tag), 0.05 * length) << tag;
  }
  EXPECT_EQ(body->mesh().position(between_tags), (Vec2{0.5 + 1e-9, 0}));
  EXPECT_TRUE(body->mesh().vertex(between_tags).fixed);
  EXPECT_TRUE(body->mesh().vertex(also_between).fixed);
  ASSERT_NO_FATAL_FAILURE(StepToTheEnd(*body));
  EXPECT_LT(body->mesh().edge_count(), 90);
}

// A star with more corners than the metric asks for: each is sharper than the tolerance.
TEST(Soften, SharpCornersStayBitForBit) {
  Domain star = Disc({0, 0}, 1, 200, kRim);
  for (std::size_t i = 0; i < star.points.size(); i += 2) star.points[i] = 0.98 * star.points[i];
  const auto body = StartWith(star, 0.005, "0.2");
  ASSERT_NO_FATAL_FAILURE(MoveAll(*body, [](Vec2 p) { return Vec2{p.x + 0.01, p.y}; }));
  EXPECT_EQ(Soften(*body), 0);
  ASSERT_NO_FATAL_FAILURE(StepToTheEnd(*body));
  for (std::int32_t i = 0; i < 200; ++i) {
    EXPECT_EQ(body->mesh().position(VertexId(i)),
              star.points[static_cast<std::size_t>(i)] + (Vec2{0.01, 0}));
  }
}

TEST(Soften, NothingFrozenGoes) {
  const auto body = StartWith(Disc({0, 0}, 1, 200, kRim), 0.05, "0.2");
  Constraints constraints;
  for (std::int32_t i = 0; i < 100; ++i) constraints.vertices.push_back(VertexId(i));
  const Map half = [](Vec2 p) { return p.y < -1e-6 ? Vec2{p.x, 1.05 * p.y} : p; };
  ASSERT_NO_FATAL_FAILURE(MoveAll(*body, half));
  ASSERT_TRUE(body->SetConstraints(constraints).ok());
  EXPECT_GT(Soften(*body), 20);
  ASSERT_NO_FATAL_FAILURE(StepToTheEnd(*body));
  for (const VertexId id : constraints.vertices) EXPECT_TRUE(body->mesh().vertex(id).fixed);
}

TEST(Soften, AFirstBuildAMissingPermissionOrNoToleranceKeepAllPoints) {
  const Domain disc = Disc({0, 0}, 1, 200, kRim);
  auto made = Remesher::Create(disc, {.source = SizeMetric{"0.2"}}, {.boundary_tolerance = 0.05});
  ASSERT_TRUE(made.ok());
  EXPECT_EQ(Soften(**made), 0);
  ASSERT_TRUE((*made)->Step({}).ok());
  (void)(*made)->Commit();
  EXPECT_EQ((*made)->mesh().edge_count(), 200);
  EXPECT_EQ(Soften(**made), 0) << "nothing has changed";
  Options options = (*made)->options();
  options.permissions.surface = false;
  ASSERT_TRUE((*made)->SetOptions(options).ok());
  ASSERT_NO_FATAL_FAILURE(MoveAll(**made, [](Vec2 p) { return Vec2{p.x + 0.01, p.y}; }));
  EXPECT_EQ(Soften(**made), 0);
  ASSERT_TRUE((*made)->SetOptions({}).ok());
  EXPECT_EQ(Soften(**made), 0);
  ASSERT_TRUE((*made)->SetOptions({.boundary_tolerance = 0.05}).ok());
  EXPECT_GT(Soften(**made), 100);
}

// A coarser metric alone is a reason, too.
TEST(Soften, AMetricThatBecomesCoarserThinsAHoleOut) {
  Domain domain = testing::Rectangle({-1, -1}, {1, 1});
  Append(Disc({0, 0}, 0.5, 60, kBar), domain);
  domain.holes.push_back({0, 0});
  const auto body = StartWith(domain, 0.02, "0.05");
  ASSERT_TRUE(body->SetMetric({.source = SizeMetric{"0.2"}}).ok());
  const std::vector<Vec2> before = PointsOf(body->mesh(), kBar);
  EXPECT_GT(Soften(*body), 30);
  EXPECT_LE(DistanceToEdges(before, body->mesh(), kBar), 0.02);
  ASSERT_NO_FATAL_FAILURE(StepToTheEnd(*body));
  EXPECT_LT(PointsOf(body->mesh(), kBar).size(), 2 * 24);
  EXPECT_GT(PointsOf(body->mesh(), kBar).size(), 2 * 12);
}

// A hole that is smaller than the tolerance keeps an inside, and two walls that are nearer to each
// other than the tolerance do not meet.
TEST(Soften, WhatWouldTouchStays) {
  Domain domain = testing::Rectangle({-1, -1}, {1, 1});
  Append(Disc({-0.5, 0}, 0.01, 40, kBar), domain);
  domain.holes.push_back({-0.5, 0});
  // Two combs with their teeth in each other's gaps, across a slot that is no part of the domain.
  Domain slot;
  for (int i = 0; i <= 20; ++i) slot.points.push_back({0.02 * i, i % 2 == 0 ? 0.0 : 0.01});
  for (int i = 20; i >= 0; --i) slot.points.push_back({0.02 * i, i % 2 == 0 ? 0.002 : 0.012});
  const auto count = static_cast<std::int32_t>(slot.points.size());
  for (std::int32_t i = 0; i < count; ++i) slot.segments.push_back({i, (i + 1) % count, kRim});
  Append(slot, domain);
  domain.holes.push_back({0.03, 0.006});
  const auto body = StartWith(domain, 0.02, "0.2");
  ASSERT_NO_FATAL_FAILURE(MoveAll(*body, [](Vec2 p) { return Vec2{p.x + 1e-6, p.y}; }));
  (void)Soften(*body);
  ASSERT_NO_FATAL_FAILURE(StepToTheEnd(*body));
  EXPECT_LT(Area(body->mesh()), 4);
}

/// Two sessions from one.
TEST(Soften, ASessionThatIsSavedRolledBackOrRepeatedGivesTheSameBits) {
  Bar bar(0.05 * kSize);
  ASSERT_NO_FATAL_FAILURE(bar.ThereAndBack(6));
  Remesher& body = bar.body();
  const auto bytes = body.Save();
  ASSERT_TRUE(bytes.ok());
  auto twin = Remesher::Load(*bytes);
  ASSERT_TRUE(twin.ok());
  const Map map = [](Vec2 p) { return Vec2{0.7 * p.x, p.y * (1 + 0.1 * p.x * p.x)}; };
  testing::Replica replica;
  ASSERT_EQ(replica.Apply(body.Snapshot()), "");
  const auto advance = [&](Remesher& session) {
    MoveAll(session, map);
    EXPECT_GT(Soften(session), 0);
    EXPECT_TRUE(session.Step({}).ok());
  };
  advance(body);
  body.Rollback();
  ASSERT_TRUE(*body.Save() == *bytes);
  advance(body);
  ASSERT_EQ(replica.Apply(body.Commit()), "");
  ASSERT_EQ(replica.DifferenceTo(body.mesh()), "");
  advance(**twin);
  (void)(*twin)->Commit();
  ASSERT_TRUE(*body.Save() == *(*twin)->Save());
  const auto undo = body.TakeUndo();
  ASSERT_TRUE(undo.has_value());
  ASSERT_TRUE(body.Apply(*undo, undo->revision).ok());
  ASSERT_TRUE(*body.Save() == *bytes);
}

double IntegralOf(const Remesher& body) {
  const Field* const field = body.fields().Find("u");
  double integral = 0;
  for (const TriangleRecord& triangle : body.mesh().triangle_records()) {
    if (!triangle.live) continue;
    const auto& v = triangle.vertices;
    const Vec2 a = body.mesh().position(v[0]);
    const double area = Cross(body.mesh().position(v[1]) - a, body.mesh().position(v[2]) - a) / 2;
    for (const VertexId corner : v) integral += field->row(corner.index())[0] * area / 3;
  }
  return integral;
}

TEST(Soften, AConservativeFieldKeepsItsIntegral) {
  const auto body = StartWith(Disc({0, 0}, 1, 200, kRim), 0.02, "0.15");
  FieldUpdate update;
  FieldValues values{.name = "u", .values = {}};
  for (const VertexId id : testing::LiveVertices(body->mesh())) {
    values.values.push_back(2 + body->mesh().position(id).x);
  }
  update.values.push_back(std::move(values));
  update.transfer = TransferKind::kConservative;
  ASSERT_TRUE(body->SetFields(update).ok());
  ASSERT_NO_FATAL_FAILURE(StepToTheEnd(*body));
  const double before = IntegralOf(*body);
  EXPECT_NEAR(before, 2 * std::numbers::pi, 0.01);
  // Nothing but the softening moves the boundary.
  ASSERT_TRUE(body->SetMetric({.source = SizeMetric{"0.2"}}).ok());
  const double area = Area(body->mesh());
  EXPECT_GT(Soften(*body), 50);
  EXPECT_LT(Area(body->mesh()), area - 1e-4);
  ASSERT_NO_FATAL_FAILURE(StepToTheEnd(*body));
  EXPECT_NEAR(IntegralOf(*body), before, 1e-12 * before);
}

// Places of segments are used again: a week of steps does not fill the memory with empty ones.
TEST(Soften, PlacesOfSegmentsAreUsedAgain) {
  Bar bar(0.05 * kSize);
  std::size_t most = 0;
  for (int i = 0; i < 6; ++i) {
    ASSERT_NO_FATAL_FAILURE(bar.GoTo(2));
    ASSERT_NO_FATAL_FAILURE(bar.GoTo(2.1));
    ASSERT_NO_FATAL_FAILURE(bar.GoTo(1));
    if (i == 2) most = bar.mesh().segments().size();
  }
  EXPECT_LE(bar.mesh().segments().size(), 1.2 * static_cast<double>(most));
}

}  // namespace
}  // namespace pliant
