#include "core/delaunay/triangulate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <set>
#include <utility>
#include <vector>

#include "core/base/rng.h"
#include "core/delaunay/check_domain.h"
#include "tests/core/delaunay/check_triangulation.h"

namespace pliant {
namespace {

using delaunay_test::AddLoop;
using delaunay_test::CheckTriangulation;
using delaunay_test::TwiceArea;

DomainTriangulation MustTriangulate(const Domain& domain) {
  auto result = TriangulateDomain(domain);
  EXPECT_TRUE(result.ok()) << result.error().message;
  return result.ok() ? *std::move(result) : DomainTriangulation{};
}

// A star-shaped loop around `center`, one radius for each corner.
std::vector<std::int32_t> AddStar(Domain& domain, Vec2 center, const std::vector<double>& radii) {
  std::vector<std::int32_t> loop;
  for (std::size_t i = 0; i < radii.size(); ++i) {
    const double angle =
        2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(radii.size());
    loop.push_back(static_cast<std::int32_t>(domain.points.size()));
    domain.points.push_back(center + radii[i] * Vec2{std::cos(angle), std::sin(angle)});
  }
  AddLoop(domain, loop);
  return loop;
}

TEST(TriangulateDomain, SplitsASquareInTwo) {
  const Domain domain = {.points = {{0, 0}, {2, 0}, {2, 1}, {0, 1}},
                         .segments = {{0, 1, 7}, {2, 1, 8}, {2, 3, 9}, {3, 0, 10}},
                         .holes = {},
                         .regions = {}};
  const DomainTriangulation result = MustTriangulate(domain);
  ASSERT_EQ(result.triangles.size(), 2U);
  CheckTriangulation(domain, result, 4);
}

// Goal: right for polygons with a hole, constraints across and free points, however they are
// numbered; where no four points are co-circular, the numbering does not show.
// Method: random stars; the hole is the outer loop shrunk to 0.4, with spokes between some corners
// of both; the area comes from the loops by the shoelace formula in rational numbers.
TEST(TriangulateDomain, MeshesRandomStarsWithAHole) {
  Rng rng(51);
  for (int trial = 0; trial < 60; ++trial) {
    SCOPED_TRACE(::testing::Message() << "seed 51, trial " << trial);
    Domain domain;
    std::vector<double> radii;
    for (int i = 0; i < 5 + trial; ++i) radii.push_back(rng.Uniform(0.2, 1));
    const auto outer = AddStar(domain, {0.3, -0.2}, radii);
    for (double& radius : radii) radius *= 0.4;
    const auto inner = AddStar(domain, {0.3, -0.2}, radii);
    domain.holes = {{0.3, -0.2}};
    for (std::size_t i = 0; i < outer.size(); ++i) {
      const Vec2 p = domain.points[AsIndex(outer[i])];
      const Vec2 q = domain.points[AsIndex(inner[i])];
      if (rng.Below(3) == 0) {
        domain.segments.push_back({outer[i], inner[i], 100});
      } else if (rng.Below(2) == 0) {
        domain.points.push_back(q + rng.Uniform(0.1, 0.9) * (p - q));
      }
    }
    const mpq_class area = TwiceArea(outer, domain.points) - TwiceArea(inner, domain.points);
    const DomainTriangulation result = MustTriangulate(domain);
    ASSERT_NO_FATAL_FAILURE(CheckTriangulation(domain, result, area));

    const Domain shuffled = delaunay_test::Shuffled(domain, rng);
    const DomainTriangulation other = MustTriangulate(shuffled);
    ASSERT_NO_FATAL_FAILURE(CheckTriangulation(shuffled, other, area));
    const auto corners = [](const Domain& d, const DomainTriangulation& triangulation) {
      std::set<std::set<std::pair<double, double>>> all;
      for (const auto& t : triangulation.triangles) {
        std::set<std::pair<double, double>> one;
        for (std::int32_t p : t.points)
          one.insert({d.points[AsIndex(p)].x, d.points[AsIndex(p)].y});
        all.insert(one);
      }
      return all;
    };
    ASSERT_EQ(corners(domain, result), corners(shuffled, other));
  }
}

// Goal: right where every decision is a tie, with long constraints, loose ends and all numberings.
TEST(TriangulateDomain, MeshesLatticesWithRandomConstraints) {
  Rng rng(52);
  for (int trial = 0; trial < 60; ++trial) {
    SCOPED_TRACE(::testing::Message() << "seed 52, trial " << trial);
    const std::int32_t n = 3 + trial / 4;
    Domain domain = delaunay_test::Lattice(n);
    ASSERT_GT(delaunay_test::AddRandomConstraints(domain, 20 * trial + 20, rng), 0);
    const Domain shuffled = delaunay_test::Shuffled(domain, rng);
    ASSERT_NO_FATAL_FAILURE(
        CheckTriangulation(shuffled, MustTriangulate(shuffled), 2 * (n - 1) * (n - 1)));
  }
}

// Goal: the answer does not depend on the unit of length, down to where products underflow and up
// to where they overflow.
TEST(TriangulateDomain, IsTheSameAtEveryScale) {
  Rng rng(53);
  Domain domain = delaunay_test::Lattice(9);
  delaunay_test::AddRandomConstraints(domain, 200, rng);
  const DomainTriangulation want = MustTriangulate(domain);
  for (int exponent : {-1070, -900, -300, 300, 1020}) {
    Domain scaled = domain;
    for (Vec2& p : scaled.points) p = {std::ldexp(p.x, exponent), std::ldexp(p.y, exponent)};
    const DomainTriangulation result = MustTriangulate(scaled);
    ASSERT_EQ(result.triangles.size(), want.triangles.size());
    for (std::size_t t = 0; t < want.triangles.size(); ++t) {
      ASSERT_EQ(result.triangles[t].points, want.triangles[t].points) << "2^" << exponent;
      ASSERT_EQ(result.triangles[t].segments, want.triangles[t].segments);
    }
  }
}

// Goal: corners of 1e-9, gaps of one ulp.
TEST(TriangulateDomain, TakesNeedlesAndThinGaps) {
  const Domain needle = {.points = {{0, 0}, {1, 0}, {1, 1e-9}, {0.5, 1e-10}},
                         .segments = {{0, 1}, {1, 2}, {2, 0}},
                         .holes = {},
                         .regions = {}};
  CheckTriangulation(needle, MustTriangulate(needle), TwiceArea({0, 1, 2}, needle.points));

  const double up = std::nextafter(1.0, 2.0);
  const Domain gap = {.points = {{0, 0}, {3, 0}, {3, 2}, {0, 2}, {1, 1}, {2, 1}, {1, up}, {2, up}},
                      .segments = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {6, 7}},
                      .holes = {},
                      .regions = {}};
  CheckTriangulation(gap, MustTriangulate(gap), 12);
}

TEST(TriangulateDomain, TakesLoopsThatTouchAndPartsThatDoNot) {
  Domain domain;
  domain.points = {{0, 0},  {4, 0},  {4, 4}, {0, 4},  // A square...
                   {8, 4},  {8, 8},  {4, 8},          // ...and one that touches it at (4, 4),
                   {1, 2},  {2, 1},  {2, 3},          // a hole that touches...
                   {20, 0}, {21, 0}, {20, 1}};        // ...and a part far away.
  AddLoop(domain, {0, 1, 2, 3});
  AddLoop(domain, {2, 4, 5, 6});
  AddLoop(domain, {0, 8, 9, 7});  // ...the outer loop at (0, 0),
  AddLoop(domain, {10, 11, 12});
  domain.holes = {{1.5, 2}};
  const mpq_class hole = TwiceArea({0, 8, 9, 7}, domain.points);
  CheckTriangulation(domain, MustTriangulate(domain), 32 + 32 + 1 - hole);
}

// Goal: a hub of many segments costs no quadratic time, and nothing recurses as deep as the input.
TEST(TriangulateDomain, TakesAHubOfManySegments) {
  Domain domain;
  const auto loop = AddStar(domain, {0, 0}, std::vector<double>(20000, 1.0));
  domain.points.push_back({0, 0});
  for (std::int32_t point : loop) domain.segments.push_back({20000, point, 1});
  const DomainTriangulation result = MustTriangulate(domain);
  EXPECT_EQ(result.triangles.size(), 20000U);
  CheckTriangulation(domain, result, TwiceArea(loop, domain.points));
}

struct BadDomain {
  const char* what;
  Domain domain;
  Error error;
};

// The square (0, 0) to (4, 4) with something wrong added.
Domain SquareWith(const std::vector<Vec2>& points, const std::vector<Segment>& segments) {
  Domain domain = {.points = {{0, 0}, {4, 0}, {4, 4}, {0, 4}},
                   .segments = {{0, 1}, {1, 2}, {2, 3}, {3, 0}},
                   .holes = {},
                   .regions = {}};
  domain.points.insert(domain.points.end(), points.begin(), points.end());
  domain.segments.insert(domain.segments.end(), segments.begin(), segments.end());
  return domain;
}

std::vector<BadDomain> BadDomains() {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto error = [](ErrorCode code, const char* field, int index, int other) {
    return Error{.code = code, .message = {}, .field = field, .index = index, .other_index = other};
  };
  const char* const points = "domain.points";
  const char* const segments = "domain.segments";
  return {
      {"nan", SquareWith({{1, kNan}}, {}), error(ErrorCode::kNotFinite, points, 4, -1)},
      {"index", SquareWith({}, {{0, 4}}), error(ErrorCode::kIndexOutOfRange, segments, 4, -1)},
      {"empty", {}, error(ErrorCode::kEmpty, points, -1, -1)},
      {"twin points", SquareWith({{4, 0}}, {}), error(ErrorCode::kDuplicatePoint, points, 1, 4)},
      {"no length", SquareWith({}, {{1, 1}}),
       error(ErrorCode::kZeroLengthSegment, segments, 4, -1)},
      {"twin segments", SquareWith({}, {{3, 2}}),
       error(ErrorCode::kDuplicateSegment, segments, 2, 4)},
      {"crossing diagonals", SquareWith({}, {{0, 2}, {3, 1}}),
       error(ErrorCode::kCrossingSegments, segments, 4, 5)},
      {"crosses the border", SquareWith({{1, 1}, {2, 9}}, {{4, 5}}),
       error(ErrorCode::kCrossingSegments, segments, 2, 4)},
      {"overlap", SquareWith({{1, 1}, {2, 1}, {3, 1}}, {{4, 6}, {4, 5}}),
       error(ErrorCode::kCrossingSegments, segments, 4, 5)},
      {"point on border", SquareWith({{1, 1}, {2, 4}}, {}),
       error(ErrorCode::kPointOnSegment, points, 5, 2)},
      {"T junction", SquareWith({{1, 1}, {2, 4}}, {{4, 5}}),
       error(ErrorCode::kPointOnSegment, points, 5, 2)},
      {"all on a line, overlapping",
       {.points = {{0, 0}, {1, 1}, {2, 2}},
        .segments = {{0, 2}, {1, 2}},
        .holes = {},
        .regions = {}},
       error(ErrorCode::kCrossingSegments, segments, 0, 1)},
      {"two points",
       {.points = {{0, 0}, {1, 1}}, .segments = {{0, 1}}, .holes = {}, .regions = {}},
       error(ErrorCode::kOpenLoop, points, 0, 0)},
      {"loose segment outside", SquareWith({{5, 1}, {6, 1}}, {{4, 5}}),
       error(ErrorCode::kOpenLoop, points, 4, 4)},
      {"point outside", SquareWith({{1, 1}, {5, 5}}, {}),
       error(ErrorCode::kPointOutsideDomain, points, 5, -1)},
  };
}

// Goal: the cause, the place in the caller's numbering and a message, for each way of being wrong.
TEST(TriangulateDomain, RefusesBadDomainsPrecisely) {
  for (const auto& [what, domain, want] : BadDomains()) {
    SCOPED_TRACE(what);
    const auto result = TriangulateDomain(domain);
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(ErrorCodeName(result.error().code), ErrorCodeName(want.code));
    EXPECT_EQ(result.error().field, want.field);
    EXPECT_EQ(result.error().index, want.index);
    EXPECT_EQ(result.error().other_index, want.other_index);
    EXPECT_GT(result.error().message.size(), 30U);
  }
}

// Goal: naming what is wrong costs no more than finding out. Method: 60,000 spokes, each with a
// bounding box that meets all the others; looking at all pairs would take minutes.
TEST(TriangulateDomain, NamesACrossingAmongManySegmentsThatAllMeet) {
  constexpr std::int32_t kSpokes = 60'000;
  Domain domain;
  domain.points.push_back({0, 0});
  for (std::int32_t k = 1; k <= kSpokes; ++k) {
    const double t = static_cast<double>(k) / (kSpokes + 1);
    domain.points.push_back({(1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)});
    domain.segments.push_back({0, k, 0});
  }
  domain.segments.push_back({kSpokes - 2, kSpokes, 0});
  const auto result = TriangulateDomain(domain);
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(ErrorCodeName(result.error().code), ErrorCodeName(ErrorCode::kCrossingSegments));
  EXPECT_EQ(result.error().index, kSpokes - 2);  // Spoke i ends at point i + 1.
  EXPECT_EQ(result.error().other_index, kSpokes);
}

// Five kinds of difficult points: lattices with exact and with rounded coordinates, a cluster a few
// ulps wide, points within rounding of a line, and a strip of 10^12 : 1.
Vec2 DifficultPoint(std::uint64_t kind, Rng& rng) {
  const double i = static_cast<double>(rng.Below(8));
  const double j = static_cast<double>(rng.Below(8));
  switch (kind) {
    case 0:
      return {i, j};
    case 1:
      return {0.1 * i, 0.3 * j};
    case 2:
      return {1 + 0x1p-52 * i, 1 + 0x1p-52 * j};
    case 3:
      return rng.Unit() * Vec2{7, 3};
    default:
      return {rng.Uniform(0, 8), rng.Uniform(0, 1e-12)};
  }
}

// Goal: on difficult input, every clash is noticed and nothing else is, and what is accepted is
// triangulated.
// Method: random segments, a third of the time with one more that may meet anything; whether
// anything clashes is found by CheckSegments, which knows nothing of triangulations.
TEST(TriangulateDomain, IsRightOnDifficultPoints) {
  Rng rng(54);
  int good_count = 0;
  int bad_count = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    SCOPED_TRACE(::testing::Message() << "seed 54, trial " << trial);
    Domain domain = {.points = {{-4, -4}, {12, -4}, {12, 12}, {-4, 12}},
                     .segments = {{0, 1}, {1, 2}, {2, 3}, {3, 0}},
                     .holes = {},
                     .regions = {}};
    const std::uint64_t kind = rng.Below(5);
    for (auto count = 4 + rng.Below(40); count > 0; --count) {
      const Vec2 p = DifficultPoint(kind, rng);
      if (std::ranges::find(domain.points, p) == domain.points.end()) domain.points.push_back(p);
    }
    delaunay_test::AddRandomConstraints(domain, static_cast<int>(rng.Below(60)), rng);
    const auto a = static_cast<std::int32_t>(rng.Below(domain.points.size()));
    const auto b = static_cast<std::int32_t>(rng.Below(domain.points.size()));
    if (trial % 3 == 0 && a != b) {
      const auto at = static_cast<std::ptrdiff_t>(rng.Below(domain.segments.size()));
      domain.segments.insert(domain.segments.begin() + at, {a, b, 0});
    }
    const bool is_good = CheckArrays(domain).ok() && CheckSegments(domain).ok();
    ++(is_good ? good_count : bad_count);
    const auto result = TriangulateDomain(domain);
    ASSERT_EQ(result.ok(), is_good);
    if (is_good) {
      ASSERT_NO_FATAL_FAILURE(CheckTriangulation(domain, *result, 2 * 16 * 16));
    }
  }
  EXPECT_GT(good_count, 600);
  EXPECT_GT(bad_count, 100);
}

}  // namespace
}  // namespace pliant
