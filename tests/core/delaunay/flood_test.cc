#include "core/delaunay/flood.h"

#include <gtest/gtest.h>

#include <string_view>

namespace pliant {
namespace {

// Two squares of 4 x 4 side by side, the right one with a square hole of 2 x 2 and, within it, an
// island of 1 x 1.
Domain TwoRooms() {
  return {.points = {{0, 0},
                     {4, 0},
                     {8, 0},
                     {8, 4},
                     {4, 4},
                     {0, 4},
                     {5, 1},
                     {7, 1},
                     {7, 3},
                     {5, 3},
                     {5.5, 1.5},
                     {6.5, 1.5},
                     {6.5, 2.5},
                     {5.5, 2.5}},
          .segments = {{0, 1},
                       {1, 2},
                       {2, 3},
                       {3, 4},
                       {4, 5},
                       {5, 0},
                       {1, 4},
                       {6, 7},
                       {7, 8},
                       {8, 9},
                       {9, 6},
                       {10, 11},
                       {11, 12},
                       {12, 13},
                       {13, 10}},
          .holes = {{5.25, 2}},
          .regions = {}};
}

double Area(const Domain& domain, const DomainTriangulation& triangulation, std::int32_t region) {
  double sum = 0;
  for (const auto& t : triangulation.triangles) {
    if (t.region != region) continue;
    const Vec2 a = domain.points[static_cast<std::size_t>(t.points[0])];
    const Vec2 b = domain.points[static_cast<std::size_t>(t.points[1])];
    const Vec2 c = domain.points[static_cast<std::size_t>(t.points[2])];
    sum += 0.5 * Cross(b - a, c - a);
  }
  return sum;
}

struct Refusal {
  ErrorCode code;
  std::string_view field;
  std::int64_t index = -1;
  std::int64_t other_index = -1;
};

void ExpectRefusal(const Domain& domain, const Refusal& want) {
  const auto result = TriangulateDomain(domain);
  ASSERT_FALSE(result.ok());
  const Error& error = result.error();
  EXPECT_EQ(ErrorCodeName(error.code), ErrorCodeName(want.code)) << error.message;
  EXPECT_EQ(error.field, want.field);
  EXPECT_EQ(error.index, want.index);
  EXPECT_EQ(error.other_index, want.other_index);
  EXPECT_FALSE(error.message.empty());
}

TEST(Flood, TagsEachRegionUpToTheNextSegments) {
  Domain domain = TwoRooms();
  domain.regions = {{{1, 1}, 5}, {{4.5, 0.5}, -7}, {{6, 2}, 9}, {{3, 3}, 5}};
  const auto result = TriangulateDomain(domain);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(Area(domain, *result, 5), 16);
  EXPECT_EQ(Area(domain, *result, -7), 12);
  EXPECT_EQ(Area(domain, *result, 9), 1);
  EXPECT_EQ(Area(domain, *result, 0), 0);
}

TEST(Flood, GivesRegionsWithoutASeedTheTagZero) {
  Domain domain = TwoRooms();
  domain.regions = {{{1, 1}, 5}};
  const auto result = TriangulateDomain(domain);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(Area(domain, *result, 5), 16);
  EXPECT_EQ(Area(domain, *result, 0), 13);
}

TEST(Flood, FillsAHoleFromSeveralSeeds) {
  Domain domain = TwoRooms();
  domain.holes.push_back({6, 1.25});
  EXPECT_TRUE(TriangulateDomain(domain).ok());
  domain.holes.push_back({6, 2});  // The island goes too: all its sides are then useless.
  ExpectRefusal(
      domain, {.code = ErrorCode::kSegmentOutsideDomain, .field = "domain.segments", .index = 11});
}

TEST(Flood, RefusesSeedsOnSegmentsAndOutside) {
  for (Vec2 bad : {Vec2{9, 1}, Vec2{4, 2}, Vec2{4, 4}, Vec2{2, 0}, Vec2{7, 1}}) {
    SCOPED_TRACE(::testing::Message() << bad.x << ", " << bad.y);
    Domain domain = TwoRooms();
    domain.holes.push_back(bad);
    ExpectRefusal(domain,
                  {.code = ErrorCode::kSeedOutsideDomain, .field = "domain.holes", .index = 1});
    domain.holes.pop_back();
    domain.regions = {{{1, 1}, 1}, {bad, 2}};
    ExpectRefusal(domain,
                  {.code = ErrorCode::kSeedOutsideDomain, .field = "domain.regions", .index = 1});
  }
  Domain domain = TwoRooms();
  domain.regions = {{{6, 1.25}, 1}};
  ExpectRefusal(domain, {.code = ErrorCode::kSeedOutsideDomain,  // In the hole.
                         .field = "domain.regions",
                         .index = 0});
}

// Goal: a seed on a free point or on an edge that is no segment is inside.
TEST(Flood, TakesSeedsOnEdgesAndFreePoints) {
  Domain domain = TwoRooms();
  domain.points.push_back({2, 2});
  for (Vec2 p : {Vec2{2, 2}, Vec2{1, 1}, Vec2{1, 2}}) {
    domain.regions = {{p, 3}};
    const auto result = TriangulateDomain(domain);
    ASSERT_TRUE(result.ok()) << result.error().message;
    EXPECT_EQ(Area(domain, *result, 3), 16);
  }
}

TEST(Flood, RefusesTwoTagsInOneRegion) {
  Domain domain = TwoRooms();
  domain.regions = {{{6, 2}, 1},   {{1, 1}, 2}, {{6, 0.5}, 3}, {{3, 3}, 2},
                    {{5, 0.5}, 4}, {{1, 3}, 5}, {{4.5, 3}, 3}};
  ExpectRefusal(domain, {.code = ErrorCode::kConflictingRegions,
                         .field = "domain.regions",
                         .index = 1,
                         .other_index = 5});
}

TEST(Flood, NamesTheLowestLooseEndOfAnOpenLoop) {
  Domain domain = TwoRooms();
  domain.segments.erase(domain.segments.begin() + 12);  // The island's 11-12.
  domain.holes.clear();
  EXPECT_TRUE(TriangulateDomain(domain).ok()) << "open, but with the domain all around";
  domain.holes = {{5.25, 2}};
  ExpectRefusal(
      domain,
      {.code = ErrorCode::kOpenLoop, .field = "domain.points", .index = 11, .other_index = 11});
  domain = TwoRooms();
  domain.segments.erase(domain.segments.begin() + 5);  // 5-0: the left room leaks.
  ExpectRefusal(
      domain,
      {.code = ErrorCode::kOpenLoop, .field = "domain.points", .index = 0, .other_index = 0});
}

TEST(Flood, RefusesALooseSegmentOutside) {
  Domain domain = TwoRooms();
  domain.points.push_back({10, 10});
  domain.segments.push_back({3, 14});
  ExpectRefusal(
      domain,
      {.code = ErrorCode::kOpenLoop, .field = "domain.points", .index = 14, .other_index = 15});
}

TEST(Flood, RefusesPointsOutside) {
  Domain domain = TwoRooms();
  domain.points.push_back({1, 1});
  domain.points.push_back({5.25, 2});  // In the hole.
  domain.points.push_back({-1, 0});
  ExpectRefusal(domain,
                {.code = ErrorCode::kPointOutsideDomain, .field = "domain.points", .index = 15});
}

TEST(Flood, KnowsWhenNothingIsInside) {
  Domain domain = {.points = {{0, 0}, {4, 0}, {0, 4}},
                   .segments = {{0, 1}, {1, 2}, {2, 0}},
                   .holes = {{1, 1}},
                   .regions = {}};
  ExpectRefusal(domain, {.code = ErrorCode::kNothingInside, .field = "domain.segments"});
  domain.segments.pop_back();
  ExpectRefusal(
      domain,
      {.code = ErrorCode::kOpenLoop, .field = "domain.points", .index = 0, .other_index = 0});
}

TEST(NothingInsideError, NamesTheLowestEndOnALine) {
  const Domain domain = {
      .points = {{2, 2}, {1, 1}, {3, 3}}, .segments = {{1, 0}, {0, 2}}, .holes = {}, .regions = {}};
  const Error error = NothingInsideError(domain);
  EXPECT_EQ(error.code, ErrorCode::kOpenLoop);
  EXPECT_EQ(error.index, 1);
  ExpectRefusal(
      domain,
      {.code = ErrorCode::kOpenLoop, .field = "domain.points", .index = 1, .other_index = 0});
}

}  // namespace
}  // namespace pliant
