#include "core/geometry/locate.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/base/rng.h"
#include "core/geometry/predicates.h"

namespace pliant {
namespace {

using Corners = std::array<std::int32_t, 3>;

struct PlainMesh {
  std::vector<Vec2> points;
  std::vector<Corners> triangles;
};

// A grid of 20 x 20 cells cut at random along one diagonal or the other, with the cells around its
// middle and a slot to its right border missing, triangles in random order and rotation, mapped by
// `map`, which must keep the orientation.
template <class Map>
PlainMesh HoledGrid(Map map, Rng& rng) {
  constexpr std::int32_t kCells = 20;
  PlainMesh mesh;
  for (std::int32_t y = 0; y <= kCells; ++y) {
    for (std::int32_t x = 0; x <= kCells; ++x) mesh.points.push_back(map(1.0 * x, 1.0 * y));
  }
  for (std::int32_t y = 0; y < kCells; ++y) {
    for (std::int32_t x = 0; x < kCells; ++x) {
      const bool in_hole = 6 <= x && x < 11 && 5 <= y && y < 12;
      const bool in_slot = x > 14 && y == 15;
      if (in_hole || in_slot) continue;
      const std::int32_t a = y * (kCells + 1) + x;
      const std::int32_t b = a + 1;
      const std::int32_t c = b + kCells + 1;
      const std::int32_t d = c - 1;
      if (rng.Below(2) == 0) {
        mesh.triangles.insert(mesh.triangles.end(), {Corners{a, b, c}, Corners{a, c, d}});
      } else {
        mesh.triangles.insert(mesh.triangles.end(), {Corners{a, b, d}, Corners{b, c, d}});
      }
    }
  }
  for (std::size_t i = mesh.triangles.size(); i > 1; --i) {
    std::swap(mesh.triangles[i - 1], mesh.triangles[rng.Below(i)]);
    std::rotate(mesh.triangles[i - 1].begin(), mesh.triangles[i - 1].begin() + rng.Below(3),
                mesh.triangles[i - 1].end());
  }
  return mesh;
}

Vec2 Identity(double x, double y) { return {x, y}; }
// Triangles of 10^4 : 1, oblique.
Vec2 Stretched(double x, double y) { return {0.8 * 1e4 * x - 0.6 * y, 0.6 * 1e4 * x + 0.8 * y}; }
Vec2 Curved(double x, double y) { return {x + 0.02 * y * y, y + 0.3 * std::sin(x)}; }

bool Holds(const PlainMesh& mesh, std::size_t t, Vec2 p) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec2 a = mesh.points[static_cast<std::size_t>(mesh.triangles[t][i])];
    const Vec2 b = mesh.points[static_cast<std::size_t>(mesh.triangles[t][(i + 1) % 3])];
    if (Orient2d(a, b, p) < 0) return false;
  }
  return true;
}

std::int32_t LowestAround(const PlainMesh& mesh, Vec2 p) {
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (Holds(mesh, t, p)) return static_cast<std::int32_t>(t);
  }
  return -1;
}

// Distance from p to the nearest side of any triangle, in long double and by another formula.
double DistanceToSides(const PlainMesh& mesh, Vec2 p) {
  long double nearest = std::numeric_limits<double>::infinity();
  for (const Corners& triangle : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec2 a = mesh.points[static_cast<std::size_t>(triangle[i])];
      const Vec2 b = mesh.points[static_cast<std::size_t>(triangle[(i + 1) % 3])];
      const long double ux = static_cast<long double>(b.x) - a.x;
      const long double uy = static_cast<long double>(b.y) - a.y;
      const long double vx = static_cast<long double>(p.x) - a.x;
      const long double vy = static_cast<long double>(p.y) - a.y;
      const long double wx = static_cast<long double>(p.x) - b.x;
      const long double wy = static_cast<long double>(p.y) - b.y;
      long double distance = std::min(std::hypot(vx, vy), std::hypot(wx, wy));
      if (ux * vx + uy * vy > 0 && ux * wx + uy * wy < 0) {
        distance = std::fabs(ux * vy - uy * vx) / std::hypot(ux, uy);
      }
      nearest = std::min(nearest, distance);
    }
  }
  return static_cast<double>(nearest);
}

Vec2 Interpolated(const PlainMesh& mesh, const Location& at) {
  Vec2 sum;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto corner =
        static_cast<std::size_t>(mesh.triangles[static_cast<std::size_t>(at.triangle)][i]);
    sum += at.weights[i] * mesh.points[corner];
  }
  return sum;
}

std::vector<Vec2> Questions(const PlainMesh& mesh, Rng& rng) {
  std::vector<Vec2> questions = mesh.points;
  const auto corner = [&mesh](const Corners& triangle, std::size_t i) {
    return mesh.points[static_cast<std::size_t>(triangle[i])];
  };
  for (const Corners& triangle : mesh.triangles) {
    const Vec2 a = corner(triangle, 0);
    const Vec2 b = corner(triangle, 1);
    const Vec2 c = corner(triangle, 2);
    questions.push_back(0.5 * (a + b));
    const double s = rng.Unit();
    const double t = rng.Unit();
    questions.push_back(a + s * ((1 - t) * (b - a) + t * (c - a)));
    // Far out: may land in another triangle, in the hole or outside.
    questions.push_back(a + 6 * (s - 0.5) * (b - a) + 8 * (t - 0.5) * (c - a));
  }
  return questions;
}

void CheckAgainstBruteForce(const PlainMesh& mesh, Rng& rng) {
  const TriangleLocator locator(mesh.points, mesh.triangles);
  const auto [low, high] = std::ranges::minmax(mesh.points, {}, &Vec2::x);
  const double extent = high.x - low.x;
  int inside_count = 0;
  int outside_count = 0;
  for (Vec2 p : Questions(mesh, rng)) {
    SCOPED_TRACE(::testing::Message() << std::hexfloat << "p = " << p.x << ", " << p.y);
    const Location at = locator.Locate(p, -1);
    ASSERT_GE(at.triangle, 0);
    const std::int32_t want = LowestAround(mesh, p);
    ASSERT_EQ(at.inside, want >= 0);
    ASSERT_NEAR(at.weights[0] + at.weights[1] + at.weights[2], 1, 1e-15);
    for (double weight : at.weights) ASSERT_TRUE(weight >= 0 && weight <= 1) << weight;
    const double distance = Length(Interpolated(mesh, at) - p);
    if (at.inside) {
      ++inside_count;
      ASSERT_EQ(at.triangle, want);
      ASSERT_LT(distance, 1e-13 * extent);
    } else {
      ++outside_count;
      ASSERT_NEAR(distance, DistanceToSides(mesh, p), 1e-13 * extent);
    }
    // Any hint, the same bits.
    for (int trial = 0; trial < 5; ++trial) {
      const auto hint = static_cast<std::int32_t>(rng.Below(mesh.triangles.size() + 4)) - 2;
      const Location again = locator.Locate(p, hint);
      ASSERT_EQ(again.triangle, at.triangle) << "hint " << hint;
      ASSERT_EQ(again.weights, at.weights) << "hint " << hint;
      ASSERT_EQ(again.inside, at.inside) << "hint " << hint;
    }
  }
  EXPECT_GT(inside_count, 1000);
  EXPECT_GT(outside_count, 50);

  // All at once, from any hints, the same bits.
  const std::vector<Vec2> points = Questions(mesh, rng);
  std::vector<Location> found(points.size());
  for (Location& one : found) {
    one.triangle = static_cast<std::int32_t>(rng.Below(mesh.triangles.size() + 4)) - 2;
  }
  locator.LocateEach(points, found);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Location at = locator.Locate(points[i], -1);
    ASSERT_EQ(found[i].triangle, at.triangle) << i;
    ASSERT_EQ(found[i].weights, at.weights) << i;
    ASSERT_EQ(found[i].inside, at.inside) << i;
  }
}

// Goal: the lowest triangle that holds the point, weights that give the point back, the nearest
// point of the mesh for points outside, whatever the hint.
// Method: every triangle and every side asked, on grids with a hole and a slot.
TEST(TriangleLocator, AgreesWithBruteForceOnAGrid) {
  Rng rng(20);
  CheckAgainstBruteForce(HoledGrid(Identity, rng), rng);
}

TEST(TriangleLocator, AgreesWithBruteForceOnStretchedTriangles) {
  Rng rng(21);
  CheckAgainstBruteForce(HoledGrid(Stretched, rng), rng);
}

TEST(TriangleLocator, AgreesWithBruteForceOnACurvedMesh) {
  Rng rng(22);
  CheckAgainstBruteForce(HoledGrid(Curved, rng), rng);
}

// Goal: the answers stay the same when far walks give way to the tree.
// Method: more questions than there are far walks, with hints at the other end of the mesh; the
// answer must hold the point, and be the one that the best of all hints leads to.
TEST(TriangleLocator, FindsPointsFarFromTheHint) {
  constexpr std::int32_t kCells = 100;
  PlainMesh mesh;
  for (std::int32_t y = 0; y <= kCells; ++y) {
    for (std::int32_t x = 0; x <= kCells; ++x) mesh.points.push_back({1.0 * x, 1.0 * y});
  }
  for (std::int32_t y = 0; y < kCells; ++y) {
    for (std::int32_t x = 0; x < kCells; ++x) {
      const std::int32_t a = y * (kCells + 1) + x;
      mesh.triangles.push_back({a, a + 1, a + kCells + 2});
      mesh.triangles.push_back({a, a + kCells + 2, a + kCells + 1});
    }
  }
  const TriangleLocator locator(mesh.points, mesh.triangles);
  Rng rng(23);
  for (int i = 0; i < 10'000; ++i) {
    const Vec2 p{kCells * rng.Unit(), kCells * rng.Unit()};
    const std::int32_t far = p.x + p.y < kCells ? locator.triangle_count() - 1 : 0;
    const Location found = locator.Locate(p, far);
    ASSERT_TRUE(found.inside) << i;
    ASSERT_TRUE(Holds(mesh, static_cast<std::size_t>(found.triangle), p)) << i;
    const Location near = locator.Locate(p, found.triangle);
    ASSERT_EQ(found.triangle, near.triangle) << i;
    ASSERT_EQ(found.weights, near.weights) << i;
  }
}

// Goal: the weights along a side are exactly 0 off it, so that a field that is continuous across
// the side has one value there.
TEST(TriangleLocator, GivesNoWeightToCornersOffTheSide) {
  const TriangleLocator locator({{0, 0}, {4, 0}, {4, 4}, {0, 4}}, {{0, 1, 2}, {0, 2, 3}});
  for (std::int32_t hint : {-1, 0, 1}) {
    const Location on_diagonal = locator.Locate({1, 1}, hint);
    EXPECT_EQ(on_diagonal.triangle, 0);
    EXPECT_EQ(on_diagonal.weights, (std::array<double, 3>{0.75, 0, 0.25}));
    const Location at_vertex = locator.Locate({4, 4}, hint);
    EXPECT_EQ(at_vertex.triangle, 0);
    EXPECT_EQ(at_vertex.weights, (std::array<double, 3>{0, 0, 1}));
    const Location outside = locator.Locate({-3, 1}, hint);
    EXPECT_FALSE(outside.inside);
    EXPECT_EQ(outside.triangle, 1);
    EXPECT_EQ(outside.weights, (std::array<double, 3>{0.75, 0, 0.25}));
    const Location beyond_vertex = locator.Locate({-3, -3}, hint);
    EXPECT_EQ(beyond_vertex.triangle, 0) << "both are as near; the lowest wins";
    EXPECT_EQ(beyond_vertex.weights, (std::array<double, 3>{1, 0, 0}));
  }
}

// Goal: a vertex where two parts touch belongs to the lowest triangle of both.
TEST(TriangleLocator, FindsTheLowestTriangleAcrossAPinchedVertex) {
  const TriangleLocator locator({{0, 0}, {1, 0}, {1, 1}, {2, 1}, {2, 2}}, {{2, 3, 4}, {0, 1, 2}});
  for (std::int32_t hint : {-1, 0, 1}) {
    EXPECT_EQ(locator.Locate({1, 1}, hint).triangle, 0);
    EXPECT_EQ(locator.Locate({1, 0.5}, hint).triangle, 1);
  }
}

// Goal: useful weights where the area is all rounding: a triangle one ulp high.
TEST(TriangleLocator, InterpolatesAlongASliver) {
  const double high = std::nextafter(1.0, 2.0);
  const TriangleLocator locator({{0, 1}, {4, 1}, {2, high}}, {{0, 1, 2}});
  const Location at = locator.Locate({1, 1}, 0);
  EXPECT_TRUE(at.inside);
  EXPECT_EQ(at.weights, (std::array<double, 3>{0.75, 0.25, 0}));
}

TEST(TriangleLocator, SurvivesCoordinatesWhoseSquaresOverflowOrVanish) {
  for (double scale : {1e200, 1e-200}) {
    const TriangleLocator locator({{0, 0}, {scale, 0}, {0, scale}}, {{0, 1, 2}});
    for (Vec2 p : {Vec2{0.25, 0.25}, Vec2{2, 2}}) {
      const Location at = locator.Locate(scale * p, -1);
      EXPECT_EQ(at.triangle, 0);
      EXPECT_EQ(at.inside, p.x < 1);
      EXPECT_EQ(at.weights[0] + at.weights[1] + at.weights[2], 1);
    }
  }
}

TEST(FindNeighbors, AreSymmetricAndShareTheSide) {
  Rng rng(23);
  const PlainMesh mesh = HoledGrid(Identity, rng);
  const auto [neighbors, overlaps] =
      FindNeighbors(mesh.triangles, static_cast<std::int32_t>(mesh.points.size()));
  EXPECT_FALSE(overlaps);
  int border_count = 0;
  for (std::size_t t = 0; t < neighbors.size(); ++t) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int32_t across = neighbors[t][i];
      if (across < 0) {
        ++border_count;
        continue;
      }
      const Corners& other = mesh.triangles[static_cast<std::size_t>(across)];
      const std::int32_t a = mesh.triangles[t][(i + 1) % 3];
      const std::int32_t b = mesh.triangles[t][(i + 2) % 3];
      bool is_mutual = false;
      for (std::size_t j = 0; j < 3; ++j) {
        is_mutual |= neighbors[static_cast<std::size_t>(across)][j] == static_cast<int>(t) &&
                     other[(j + 1) % 3] == b && other[(j + 2) % 3] == a;
      }
      EXPECT_TRUE(is_mutual) << "triangle " << t << ", side " << i;
    }
  }
  // 4 x 20 around the grid less one for the mouth of the slot, 2 x (5 + 7) around the hole, 2 x 5
  // along the slot and 1 at its end.
  EXPECT_EQ(border_count, 79 + 24 + 11);
}

// Goal: two triangles on the same side of an edge are noticed, whichever they are.
// Method: to a grid, one of its triangles again; one that reaches over its neighbours; and one that
// is the third at an edge from either end.
TEST(FindNeighbors, NoticeTwoOnTheSameSide) {
  Rng rng(24);
  const PlainMesh mesh = HoledGrid(Identity, rng);
  const auto count = static_cast<std::int32_t>(mesh.points.size());
  EXPECT_FALSE(FindNeighbors(mesh.triangles, count).overlaps);
  const Corners some = mesh.triangles[17];
  std::vector<Corners> more = mesh.triangles;
  more.push_back(some);
  EXPECT_TRUE(FindNeighbors(more, count).overlaps);
  for (std::size_t corner = 0; corner < 3; ++corner) {
    for (const bool turned : {false, true}) {
      more.back() = some;
      more.back()[corner] = count - 1 - some[corner];
      if (turned) std::swap(more.back()[(corner + 1) % 3], more.back()[(corner + 2) % 3]);
      EXPECT_TRUE(FindNeighbors(more, count).overlaps) << "corner " << corner;
    }
  }
  // Two triangles alone, on the same side of the edge from 0 to 1, in either direction.
  EXPECT_TRUE(FindNeighbors(std::vector<Corners>{{0, 1, 2}, {0, 1, 3}}, 4).overlaps);
  EXPECT_TRUE(FindNeighbors(std::vector<Corners>{{1, 0, 2}, {3, 1, 0}}, 4).overlaps);
  EXPECT_FALSE(FindNeighbors(std::vector<Corners>{{0, 1, 2}, {1, 0, 3}}, 4).overlaps);
}

}  // namespace
}  // namespace pliant
