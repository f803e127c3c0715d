#include "core/pliant/boundary_gaps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "tests/support/mesh_testing.h"
#include "tests/support/random_domain.h"
#include "tests/support/seed.h"

namespace pliant {
namespace {

constexpr double kFar = 20;

Domain Loop(const std::vector<Vec2>& points) {
  Domain domain;
  domain.points = points;
  const auto count = static_cast<std::int32_t>(points.size());
  for (std::int32_t i = 0; i < count; ++i) domain.segments.push_back({i, (i + 1) % count, 1});
  return domain;
}

VertexId VertexAt(const Mesh& mesh, Vec2 p) {
  for (const VertexId v : testing::LiveVertices(mesh)) {
    if (mesh.position(v) == p) return v;
  }
  return {};
}

double WidthAt(const Domain& domain, Vec2 p, double reach = kFar) {
  const auto made = testing::DomainMesh(domain);
  return BoundaryGaps(made->mesh).WidthAt(made->mesh, VertexAt(made->mesh, p), reach);
}

TEST(BoundaryGaps, AreMeasuredAcrossTheDomain) {
  // Across a channel; its short ends have an end in common with what they look along.
  const Domain channel = Loop({{0, 0}, {4, 0}, {4, 0.25}, {0, 0.25}});
  EXPECT_EQ(WidthAt(channel, {0, 0}, 10), 0.25) << "4 along the channel is wider";
  EXPECT_EQ(WidthAt(channel, {0, 0}, 0.25), BoundaryGaps::kNone) << "reach is not below itself";
  EXPECT_EQ(WidthAt(channel, {0, 0}, 50), 0.5) << "a hundredth of the reach";
}

TEST(BoundaryGaps, DoNotLieOutsideTheDomain) {
  // A thin slit from above is outside: the gap between its walls is not one of the domain.
  const Domain slit = Loop({{0, 0}, {2, 0}, {2, 1}, {1.01, 1}, {1, 0.5}, {0.99, 1}, {0, 1}});
  EXPECT_NEAR(WidthAt(slit, {1.01, 1}), 0.99, 0.03) << "to the wall at the side";
  EXPECT_NEAR(WidthAt(slit, {2, 0}), 1, 1e-12);
}

TEST(BoundaryGaps, ASharpCornerIsNone) {
  const Domain needle = Loop({{0, 0}, {1, -0.01}, {1, 0.01}});
  for (const Vec2 p : needle.points) EXPECT_EQ(WidthAt(needle, p), BoundaryGaps::kNone);
}

TEST(BoundaryGaps, ACircleSeesItsOtherSide) {
  std::vector<Vec2> points;
  for (int i = 0; i < 60; ++i) {
    const double angle = 2 * std::numbers::pi * i / 60;
    points.push_back({std::cos(angle), std::sin(angle)});
  }
  const Domain circle = Loop(points);
  for (const Vec2 p : points) EXPECT_NEAR(WidthAt(circle, p), 2, 0.01);
}

TEST(BoundaryGaps, LinesInsideTheDomainHaveTwoSides) {
  Domain domain = Loop({{0, 0}, {1, 0}, {1, 1}, {0, 1}});
  domain.points.push_back({0.25, 0.3});
  domain.points.push_back({0.75, 0.3});
  domain.segments.push_back({4, 5, 2});
  EXPECT_NEAR(WidthAt(domain, {0.25, 0.3}), 0.3, 1e-15) << "down; up it is 0.7";
  EXPECT_EQ(WidthAt(domain, {0, 0}), 1) << "along neither normal is the line";
}

// Goal: the tree of boxes leaves out nothing. Method: random domains with holes, gaps and clusters;
// each ray is cut with every segment, in long double.
TEST(BoundaryGaps, AreThoseOfASearchThroughAllSegments) {
  std::int64_t gap_count = 0;
  for (const std::uint64_t seed : test::Seeds{.count = 60, .long_count = 3000}.OfPart(0)) {
    SCOPED_TRACE(test::Replay(seed, "core_tests", "BoundaryGaps.*"));
    const testing::RandomCase random = testing::MakeRandomCase(seed);
    const auto made = testing::DomainMesh(random.domain);
    const Mesh& mesh = made->mesh;
    const BoundaryGaps gaps(mesh);
    EXPECT_EQ(gaps.DifferenceTo(mesh), std::nullopt);
    for (const VertexId v : testing::LiveVertices(mesh)) {
      const double reach = random.extent * 0.3;
      long double width = reach;
      for (std::int32_t e = 0; e < mesh.edge_slots(); ++e) {
        const EdgeRecord& edge = mesh.edge(EdgeId(e));
        if (!edge.live || (edge.vertices[0] != v && edge.vertices[1] != v)) continue;
        const SegmentRecord own = mesh.segments()[static_cast<std::size_t>(edge.segment)];
        const Vec2 from = mesh.position(own.a);
        const Vec2 along = mesh.position(own.b) - from;
        const long double length = std::hypot(static_cast<long double>(along.x), along.y);
        for (std::int32_t t = 0; t < mesh.triangle_slots(); ++t) {
          const TriangleRecord& triangle = mesh.triangle(TriangleId(t));
          const auto has = [&](VertexId corner) {
            return std::ranges::find(triangle.vertices, corner) != triangle.vertices.end();
          };
          if (!triangle.live || !has(edge.vertices[0]) || !has(edge.vertices[1])) continue;
          const VertexId apex = *std::ranges::find_if(triangle.vertices, [&](VertexId corner) {
            return corner != edge.vertices[0] && corner != edge.vertices[1];
          });
          const bool is_left =
              Cross(mesh.position(edge.vertices[1]) - mesh.position(edge.vertices[0]),
                    mesh.position(apex) - mesh.position(edge.vertices[0])) > 0;
          const long double sign = is_left ? 1 : -1;
          const long double dx = -sign * along.y / length;
          const long double dy = sign * along.x / length;
          long double hit = reach;
          for (const SegmentRecord& other : mesh.segments()) {
            if (!other.is_line() || other.a == own.a || other.a == own.b || other.b == own.a ||
                other.b == own.b) {
              continue;
            }
            const Vec2 c = mesh.position(other.a) - mesh.position(v);
            const Vec2 d = mesh.position(other.b) - mesh.position(other.a);
            const long double slope = dx * d.y - dy * d.x;
            if (slope == 0) continue;
            const long double distance =
                (static_cast<long double>(c.x) * d.y - static_cast<long double>(c.y) * d.x) / slope;
            const long double share = (c.x * dy - c.y * dx) / slope;
            if (distance > 0 && share >= -1e-9L && share <= 1 + 1e-9L)
              hit = std::min(hit, distance);
          }
          if (hit < reach)
            width = std::min(width, std::max<long double>(hit, BoundaryGaps::kFloor * reach));
        }
      }
      const double found = gaps.WidthAt(mesh, v, reach);
      if (width < reach) {
        ++gap_count;
        ASSERT_NEAR(found, static_cast<double>(width), 1e-9 * random.extent) << "vertex " << v;
      } else {
        ASSERT_EQ(found, BoundaryGaps::kNone) << "vertex " << v;
      }
    }
  }
  EXPECT_GT(gap_count, 0);
}

TEST(BoundaryGaps, TellWhereSegmentsAreOthers) {
  const auto made = testing::DomainMesh(Loop({{0, 0}, {1, 0}, {1, 1}, {0, 1}}));
  const Mesh& mesh = made->mesh;
  const BoundaryGaps gaps(mesh);
  EXPECT_EQ(gaps.DifferenceTo(mesh), std::nullopt);
  const VertexId corner = VertexAt(mesh, {1, 1});
  made->edit.MoveVertex(corner, {0.9, 0.5});
  for (std::int32_t i = 0; i < 4; ++i) {
    const SegmentRecord& segment = mesh.segments()[static_cast<std::size_t>(i)];
    EXPECT_EQ(gaps.Differs(mesh, i), segment.a == corner || segment.b == corner) << i;
  }
  // From the corner as it was to (1, 0) and (0, 1).
  EXPECT_EQ(gaps.DifferenceTo(mesh), (BoundingBox{{0, 0}, {1, 1}}));
  EXPECT_EQ(BoundaryGaps(mesh).DifferenceTo(mesh), std::nullopt);
}

}  // namespace
}  // namespace pliant
