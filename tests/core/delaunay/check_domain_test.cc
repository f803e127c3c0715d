#include "core/delaunay/check_domain.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/base/rng.h"
#include "tests/core/delaunay/check_triangulation.h"

namespace pliant {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Domain Square() {
  return {.points = {{0, 0}, {4, 0}, {4, 4}, {0, 4}},
          .segments = {{0, 1}, {1, 2}, {2, 3}, {3, 0}},
          .holes = {},
          .regions = {}};
}

void ExpectError(const Status& status, const Error& want) {
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(ErrorCodeName(status.error().code), ErrorCodeName(want.code));
  EXPECT_EQ(status.error().field, want.field);
  EXPECT_EQ(status.error().index, want.index);
  EXPECT_EQ(status.error().other_index, want.other_index);
  EXPECT_NE(status.error().message.find(want.message), std::string::npos) << status.error().message;
}

TEST(CheckArrays, AcceptsASquare) { EXPECT_TRUE(CheckArrays(Square()).ok()); }

TEST(CheckArrays, FindsTheFirstIndexOutOfRange) {
  for (std::int32_t bad : {-1, 4}) {
    Domain domain = Square();
    domain.segments[2].b = bad;
    domain.segments[3].a = bad;
    ExpectError(CheckArrays(domain), {.code = ErrorCode::kIndexOutOfRange,
                                      .message = "but there are 4 points",
                                      .field = "domain.segments",
                                      .index = 2});
  }
}

TEST(CheckArrays, FindsTheFirstNumberThatIsNotFinite) {
  Domain domain = Square();
  domain.regions = {{{1, 1}, 0}, {{1, kInfinity}, 0}};
  ExpectError(CheckArrays(domain), {.code = ErrorCode::kNotFinite,
                                    .message = "(1, inf)",
                                    .field = "domain.regions",
                                    .index = 1});
  domain.holes = {{kNan, 0}};
  ExpectError(
      CheckArrays(domain),
      {.code = ErrorCode::kNotFinite, .message = "(nan, 0)", .field = "domain.holes", .index = 0});
  domain.points[3].y = -kInfinity;
  ExpectError(CheckArrays(domain), {.code = ErrorCode::kNotFinite,
                                    .message = "(0, -inf)",
                                    .field = "domain.points",
                                    .index = 3});
}

TEST(CheckArrays, WantsPointsAndSegments) {
  ExpectError(CheckArrays({}),
              {.code = ErrorCode::kEmpty, .message = "no points", .field = "domain.points"});
  Domain domain = Square();
  domain.segments.clear();
  ExpectError(CheckArrays(domain),
              {.code = ErrorCode::kEmpty, .message = "no segments", .field = "domain.segments"});
}

TEST(CheckArrays, FindsTheLowestDuplicatePoint) {
  Domain domain = Square();
  domain.points.insert(domain.points.end(), {{9, 9}, {4, 4}, {-0.0, 0}, {9, 9}, {0, 0}});
  ExpectError(CheckArrays(domain), {.code = ErrorCode::kDuplicatePoint,
                                    .message = "Points 0 and 6 are both at (0, 0)",
                                    .field = "domain.points",
                                    .index = 0,
                                    .other_index = 6});
}

TEST(CheckArrays, FindsTheFirstSegmentWithoutLength) {
  Domain domain = Square();
  domain.segments.push_back({0, 1});  // A duplicate, which comes later in the list of causes.
  domain.segments.push_back({2, 2});
  ExpectError(CheckArrays(domain), {.code = ErrorCode::kZeroLengthSegment,
                                    .message = "point 2 at (4, 4) to itself",
                                    .field = "domain.segments",
                                    .index = 5});
}

TEST(CheckArrays, FindsTheLowestDuplicateSegment) {
  Domain domain = Square();
  domain.segments.push_back({3, 2});
  domain.segments.push_back({1, 0});
  domain.segments.push_back({0, 1});
  ExpectError(CheckArrays(domain), {.code = ErrorCode::kDuplicateSegment,
                                    .message = "Segments 0 and 5 both join",
                                    .field = "domain.segments",
                                    .index = 0,
                                    .other_index = 5});
}

// Goal: the lowest pair that crosses, and if none does the lowest point on a segment.
// Method: random segments on a small lattice, where both are frequent, against all pairs.
TEST(CheckSegments, FindsTheLowestClash) {
  Rng rng(17);
  int crossing_count = 0;
  int point_count = 0;
  int fine_count = 0;
  for (int trial = 0; trial < 500; ++trial) {
    SCOPED_TRACE(::testing::Message() << "seed 17, trial " << trial);
    Domain domain;
    domain.points = delaunay_test::Lattice(6).points;
    const auto count = static_cast<int>(1 + rng.Below(6));
    for (int k = 0; k < count; ++k) {
      const auto a = static_cast<std::int32_t>(rng.Below(36));
      const auto b = static_cast<std::int32_t>((a + 1 + static_cast<int>(rng.Below(9))) % 36);
      domain.segments.push_back({a, b});
    }
    if (!CheckArrays(domain).ok()) continue;
    Error want;
    const auto start = [&](std::size_t s) { return domain.points[AsIndex(domain.segments[s].a)]; };
    const auto end = [&](std::size_t s) { return domain.points[AsIndex(domain.segments[s].b)]; };
    for (std::size_t p = domain.points.size(); p-- > 0;) {
      for (std::size_t s = domain.segments.size(); s-- > 0;) {
        if (!IsInsideSegment(start(s), end(s), domain.points[p])) continue;
        want = {.code = ErrorCode::kPointOnSegment, .message = "Split", .field = "domain.points"};
        want.index = static_cast<std::int64_t>(p);
        want.other_index = static_cast<std::int64_t>(s);
      }
    }
    for (std::size_t s = domain.segments.size(); s-- > 0;) {
      for (std::size_t t = domain.segments.size(); t-- > s + 1;) {
        if (!CrossOrOverlap(start(s), end(s), start(t), end(t))) continue;
        want = {.code = ErrorCode::kCrossingSegments,
                .message = "Split both",
                .field = "domain.segments"};
        want.index = static_cast<std::int64_t>(s);
        want.other_index = static_cast<std::int64_t>(t);
      }
    }
    const Status status = CheckSegments(domain);
    if (want.index < 0) {
      ++fine_count;
      EXPECT_TRUE(status.ok());
    } else {
      ++(want.code == ErrorCode::kCrossingSegments ? crossing_count : point_count);
      ExpectError(status, want);
    }
  }
  EXPECT_GT(crossing_count, 50);
  EXPECT_GT(point_count, 50);
  EXPECT_GT(fine_count, 50);
}

TEST(Text, GivesTheShortestDigits) {
  EXPECT_EQ(Text({0.1, -2}), "(0.1, -2)");
  EXPECT_EQ(PointText(Square(), 1), "point 1 at (4, 0)");
  EXPECT_EQ(SegmentText(Square(), 1), "segment 1 from (4, 0) to (4, 4)");
}

}  // namespace
}  // namespace pliant
