#pragma once

#include <gmpxx.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "core/base/as_index.h"
#include "core/base/rng.h"
#include "core/delaunay/triangulate.h"
#include "core/geometry/domain.h"
#include "core/geometry/predicates.h"
#include "core/geometry/segments.h"

namespace pliant::delaunay_test {

using Triangle = DomainTriangulation::Triangle;

inline Vec2 CornerPoint(const Triangle& t, std::size_t i, std::span<const Vec2> points) {
  return points[AsIndex(t.points[i % 3])];
}

/// Checks one triangle without a ghost: its orientation, that its neighbours know it by the same
/// side with the same segment, and that every side that is no segment is locally Delaunay.
inline void CheckTriangle(std::int32_t t, std::span<const Triangle> triangles,
                          std::span<const Vec2> points) {
  const Triangle& triangle = triangles[AsIndex(t)];
  const auto corner = [&](std::size_t i) { return CornerPoint(triangle, i, points); };
  ASSERT_GT(Orient2d(corner(0), corner(1), corner(2)), 0) << "triangle " << t;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::int32_t across = triangle.neighbors[i];
    if (across < 0) {
      ASSERT_GE(triangle.segments[i], 0) << "triangle " << t << " has an open side";
      continue;
    }
    const Triangle& other = triangles[AsIndex(across)];
    const auto j =
        static_cast<std::size_t>(std::ranges::find(other.neighbors, t) - other.neighbors.begin());
    ASSERT_LT(j, 3U) << "triangle " << t << " is not a neighbour of its neighbour " << across;
    ASSERT_EQ(other.points[(j + 1) % 3], triangle.points[(i + 2) % 3]);
    ASSERT_EQ(other.points[(j + 2) % 3], triangle.points[(i + 1) % 3]);
    ASSERT_EQ(other.segments[j], triangle.segments[i]);
    if (triangle.segments[i] >= 0 || other.points[j] < 0) continue;
    ASSERT_LE(InCircle(corner(0), corner(1), corner(2), CornerPoint(other, j, points)), 0)
        << "the side between triangles " << t << " and " << across << " is not Delaunay";
  }
}

/// Twice the area of the triangles, exactly.
inline mpq_class TwiceArea(std::span<const Triangle> triangles, std::span<const Vec2> points) {
  mpq_class sum = 0;
  for (const Triangle& t : triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vec2 a = CornerPoint(t, i, points);
      const Vec2 b = CornerPoint(t, i + 1, points);
      sum += mpq_class(a.x) * b.y - mpq_class(a.y) * b.x;
    }
  }
  return sum;
}

/// Twice the area of a closed polygon of point numbers, exactly; negative if it runs clockwise.
inline mpq_class TwiceArea(const std::vector<std::int32_t>& loop, std::span<const Vec2> points) {
  mpq_class sum = 0;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const Vec2 a = points[AsIndex(loop[i])];
    const Vec2 b = points[AsIndex(loop[(i + 1) % loop.size()])];
    sum += mpq_class(a.x) * b.y - mpq_class(a.y) * b.x;
  }
  return sum;
}

/// Checks all that must hold of a domain's triangulation whatever the domain: with positive
/// triangles that are all joined across their sides and cover the area, nothing can overlap.
inline void CheckTriangulation(const Domain& domain, const DomainTriangulation& result,
                               const mpq_class& twice_area) {
  std::vector<int> side_count(domain.segments.size(), 0);
  std::vector<bool> point_is_used(domain.points.size(), false);
  for (std::size_t t = 0; t < result.triangles.size(); ++t) {
    const Triangle& triangle = result.triangles[t];
    ASSERT_NO_FATAL_FAILURE(
        CheckTriangle(static_cast<std::int32_t>(t), result.triangles, domain.points));
    for (std::size_t i = 0; i < 3; ++i) {
      point_is_used[AsIndex(triangle.points[i])] = true;
      if (triangle.segments[i] < 0) continue;
      ++side_count[AsIndex(triangle.segments[i])];
      const Segment& s = domain.segments[AsIndex(triangle.segments[i])];
      const std::pair side =
          std::minmax(triangle.points[(i + 1) % 3], triangle.points[(i + 2) % 3]);
      ASSERT_EQ(side, std::minmax(s.a, s.b)) << "segment " << triangle.segments[i];
    }
  }
  for (std::size_t i = 0; i < side_count.size(); ++i)
    ASSERT_GE(side_count[i], 1) << "segment " << i;
  for (std::size_t i = 0; i < point_is_used.size(); ++i) ASSERT_TRUE(point_is_used[i]) << i;
  ASSERT_EQ(TwiceArea(result.triangles, domain.points), twice_area);
}

/// Adds segments around a loop of points.
inline void AddLoop(Domain& domain, const std::vector<std::int32_t>& loop) {
  for (std::size_t i = 0; i < loop.size(); ++i) {
    domain.segments.push_back({loop[i], loop[(i + 1) % loop.size()], static_cast<int>(i)});
  }
}

/// Adds random segments between points that neither meet others nor run through points, longest
/// tries included: brute force. @return how many
inline int AddRandomConstraints(Domain& domain, int try_count, Rng& rng) {
  int added = 0;
  for (int k = 0; k < try_count; ++k) {
    const auto a = static_cast<std::int32_t>(rng.Below(domain.points.size()));
    const auto b = static_cast<std::int32_t>(rng.Below(domain.points.size()));
    if (a == b) continue;
    const Vec2 p = domain.points[AsIndex(a)];
    const Vec2 q = domain.points[AsIndex(b)];
    const bool meets_segment = std::ranges::any_of(domain.segments, [&](const Segment& s) {
      return CrossOrOverlap(p, q, domain.points[AsIndex(s.a)], domain.points[AsIndex(s.b)]);
    });
    const bool meets_point =
        std::ranges::any_of(domain.points, [&](Vec2 r) { return IsInsideSegment(p, q, r); });
    if (meets_segment || meets_point) continue;
    domain.segments.push_back({a, b, 1000 + k});
    ++added;
  }
  return added;
}

/// The points of a lattice of n x n and the square around them.
inline Domain Lattice(std::int32_t n) {
  Domain domain;
  for (std::int32_t y = 0; y < n; ++y) {
    for (std::int32_t x = 0; x < n; ++x) domain.points.push_back({1.0 * x, 1.0 * y});
  }
  std::vector<std::int32_t> loop;
  for (std::int32_t i = 0; i < n - 1; ++i) loop.push_back(i);
  for (std::int32_t i = 0; i < n - 1; ++i) loop.push_back((i + 1) * n - 1);
  for (std::int32_t i = 0; i < n - 1; ++i) loop.push_back(n * n - 1 - i);
  for (std::int32_t i = 0; i < n - 1; ++i) loop.push_back((n - 1 - i) * n);
  AddLoop(domain, loop);
  return domain;
}

/// Renumbers points and segments, and reverses some segments, at random.
inline Domain Shuffled(const Domain& domain, Rng& rng) {
  std::vector<std::int32_t> order(domain.points.size());
  std::iota(order.begin(), order.end(), 0);
  for (std::size_t i = order.size(); i > 1; --i) std::swap(order[i - 1], order[rng.Below(i)]);
  Domain result = domain;
  for (std::size_t i = 0; i < order.size(); ++i)
    result.points[AsIndex(order[i])] = domain.points[i];
  for (Segment& s : result.segments) {
    s = {order[AsIndex(s.a)], order[AsIndex(s.b)], s.tag};
    if (rng.Below(2) == 0) std::swap(s.a, s.b);
  }
  for (std::size_t i = result.segments.size(); i > 1; --i) {
    std::swap(result.segments[i - 1], result.segments[rng.Below(i)]);
  }
  return result;
}

}  // namespace pliant::delaunay_test
