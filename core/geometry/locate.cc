#include "core/geometry/locate.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/as_index.h"
#include "core/base/check.h"
#include "core/geometry/predicates.h"
#include "core/geometry/triangle_point.h"

namespace pliant {
namespace {

/// A walk that has not arrived after this many triangles is slower than the tree, or in a cycle.
constexpr std::int64_t kWalkStepsMax = 64;

/// So many walks wait for the memory together, which makes longer ones worth their while.
constexpr std::size_t kSideBySide = 16;
constexpr std::int64_t kSideBySideStepsMax = 512;

/// A way from one end of a triangulation to the other takes at most so many times the root of the
/// number of its triangles, unless they are very unequal.
constexpr std::int64_t kRowsToCross = 4;

/// A tree costs some 50 steps of a walk for each triangle, a far walk one or two rows.
constexpr std::int64_t kFarWalksPerRow = 16;

/// A side of a triangle, seen from its lower end.
struct LowSide {
  std::int32_t upper;
  std::int32_t triangle;
  std::int8_t corner;
  bool ascends;  ///< It runs from the lower to the upper end, its triangle on the left.
};

/// Sorts sides by their upper ends; those that are equal stay in their order. Nearly always they
/// are few, and std::stable_sort gets memory for each of its calls.
void SortByUpper(std::span<LowSide> sides) {
  constexpr std::size_t kFew = 16;
  if (sides.size() > kFew) {
    std::ranges::stable_sort(sides, {}, &LowSide::upper);
    return;
  }
  for (std::size_t i = 1; i < sides.size(); ++i) {
    const LowSide side = sides[i];
    std::size_t place = i;
    for (; place > 0 && side.upper < sides[place - 1].upper; --place) {
      sides[place] = sides[place - 1];
    }
    sides[place] = side;
  }
}

/// Without triangles if the search for neighbours was stopped.
LinkedTriangles Link(std::span<const Vec2> points,
                     std::span<const std::array<std::int32_t, 3>> triangles,
                     std::span<const std::array<std::int32_t, 3>> neighbors) {
  LinkedTriangles linked{.points = {points.begin(), points.end()}, .triangles = {}};
  linked.triangles.reserve(neighbors.size());
  for (std::size_t t = 0; t < neighbors.size(); ++t) {
    linked.triangles.push_back({triangles[t], neighbors[t]});
  }
  return linked;
}

/// Makes neighbours of the triangles whose sides have both ends in common, of all sides with one
/// lower end.
void PairSides(std::span<LowSide> sides, Neighborhood& result) {
  SortByUpper(sides);
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    const LowSide& a = sides[i];
    const LowSide& b = sides[i + 1];
    if (a.upper != b.upper) continue;
    result.across[AsIndex(a.triangle)][AsIndex(a.corner)] = b.triangle;
    result.across[AsIndex(b.triangle)][AsIndex(b.corner)] = a.triangle;
    ++i;  // Both are paired.
    const bool is_third = i + 1 < sides.size() && sides[i + 1].upper == a.upper;
    result.overlaps = result.overlaps || a.ascends == b.ascends || is_third;
  }
}

}  // namespace

TriangleLocator::TriangleLocator(const std::vector<Vec2>& points,
                                 const std::vector<std::array<std::int32_t, 3>>& triangles,
                                 const StopSignal* stop)
    : TriangleLocator(
          points, triangles,
          FindNeighbors(triangles, static_cast<std::int32_t>(points.size()), stop).across) {}

TriangleLocator::TriangleLocator(std::span<const Vec2> points,
                                 std::span<const std::array<std::int32_t, 3>> triangles,
                                 std::span<const std::array<std::int32_t, 3>> neighbors)
    : TriangleLocator(Link(points, triangles, neighbors)) {
  PLIANT_CHECK(!triangles.empty());
}

TriangleLocator::TriangleLocator(LinkedTriangles linked)
    : points_(std::move(linked.points)),
      box_(points_.empty() ? BoundingBox{} : BoxOf(points_)),
      links_(std::move(linked.triangles)),
      row_(static_cast<std::int64_t>(std::sqrt(static_cast<double>(links_.size())))),
      lazy_(std::make_unique<LazyParts>()) {}

Location TriangleLocator::Locate(Vec2 p, std::int32_t hint) const {
  Location end = WalkStraight(p, IsTriangle(hint) ? hint : 0, kWalkStepsMax);
  if (end.inside) return end;
  if (MayWalkFar()) {
    end = WalkStraight(p, end.triangle, kRowsToCross * row_);
    if (end.inside) return end;
  }
  const std::int32_t triangle = Walk(p, end.triangle);
  return triangle >= 0 ? Canonical(p, triangle) : Search(p);
}

/// As long as there is no tree, some ways across the whole triangulation cost less than to make it.
bool TriangleLocator::MayWalkFar() const {
  if (lazy_->tree.made()) return false;
  return lazy_->far_walks.fetch_add(1, std::memory_order_relaxed) < kFarWalksPerRow * row_;
}

void TriangleLocator::LocateEach(std::span<const Vec2> points, std::span<Location> found) const {
  PLIANT_CHECK(points.size() == found.size());
  struct Walk {
    std::size_t index;
    std::int64_t steps_left;
  };
  std::array<Walk, kSideBySide> walks;
  std::size_t next = 0;
  const auto begin_next = [&] {
    found[next] = {.triangle = IsTriangle(found[next].triangle) ? found[next].triangle : 0};
    Prefetch(found[next].triangle);
    return Walk{next++, kSideBySideStepsMax};
  };
  std::size_t count = 0;
  while (count < kSideBySide && next < points.size()) walks[count++] = begin_next();
  // When one has arrived another begins, so that nobody waits alone.
  while (count > 0) {
    for (std::size_t k = 0; k < count; ++k) {
      Walk& walk = walks[k];
      Location& at = found[walk.index];
      if (walk.steps_left-- > 0 && StepStraight(points[walk.index], at)) {
        Prefetch(at.triangle);
      } else {
        walk = next < points.size() ? begin_next() : walks[--count];
      }
    }
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!found[i].inside) found[i] = Locate(points[i], found[i].triangle);
  }
}

/// The usual case without exact arithmetic: leaves each triangle by the side that p is farthest
/// beyond, and answers if p ends up inside a triangle and clear of its sides. Otherwise the answer
/// is not `inside` and has only the triangle where the walk ended.
Location TriangleLocator::WalkStraight(Vec2 p, std::int32_t start, std::int64_t steps_max) const {
  Location at{.triangle = start};
  for (std::int64_t step = 0; step < steps_max && StepStraight(p, at); ++step) {
  }
  return at;
}

/// One step of that walk. @return true if it goes on
inline bool TriangleLocator::StepStraight(Vec2 p, Location& at) const {
  const std::array<Vec2, 3> corners = Corners(at.triangle);
  const std::array<Vec2, 3> to = {corners[0] - p, corners[1] - p, corners[2] - p};
  const std::array<double, 3> areas = {Cross(to[1], to[2]), Cross(to[2], to[0]),
                                       Cross(to[0], to[1])};
  std::size_t side = areas[1] < areas[0] ? 1 : 0;
  if (areas[2] < areas[side]) side = 2;
  if (areas[side] < 0) {
    const std::int32_t next = neighbors(at.triangle)[side];
    if (next < 0) return false;
    at.triangle = next;
    return true;
  }
  if (internal::MarginOfOrient2d(corners[1], corners[2], p) > 0 &&
      internal::MarginOfOrient2d(corners[2], corners[0], p) > 0 &&
      internal::MarginOfOrient2d(corners[0], corners[1], p) > 0) {
    at.weights = WeightsFromAreas(corners, p, areas);
    at.inside = true;
  }
  return false;
}

/// A visibility walk: leaves each triangle by a side that has p beyond it. The first side to be
/// tried changes from step to step, which leaves most of the cycles that a mesh that is not
/// Delaunay can have. [Devillers2002]
std::int32_t TriangleLocator::Walk(Vec2 p, std::int32_t start) const {
  std::int32_t from = -1;
  std::int32_t at = start;
  for (int step = 0; step < kWalkStepsMax; ++step) {
    const std::array<Vec2, 3> corners = Corners(at);
    const std::array<std::int32_t, 3>& across = neighbors(at);
    bool is_outside = false;
    std::int32_t next = -1;
    for (int k = 0; k < 3 && next < 0; ++k) {
      const auto side = static_cast<std::size_t>((step + k) % 3);
      if (from >= 0 && across[side] == from) continue;
      if (Orient2d(corners[(side + 1) % 3], corners[(side + 2) % 3], p) >= 0) continue;
      is_outside = true;
      next = across[side];
    }
    if (next < 0) return is_outside ? -1 : at;
    from = at;
    at = next;
  }
  return -1;
}

/// The answer for a point of `triangle`: the same from whichever of the triangles around p.
Location TriangleLocator::Canonical(Vec2 p, std::int32_t triangle) const {
  std::array<int, 3> signs = SideSigns(Corners(triangle), p);
  std::int32_t lowest = triangle;
  for (std::size_t i = 0; i < 3; ++i) {
    if (signs[i] != 0) continue;
    const std::int32_t across = neighbors(triangle)[i];
    if (across >= 0) lowest = std::min(lowest, across);
    const std::size_t j = (i + 1) % 3;
    if (signs[j] == 0) {  // On both sides: at the corner where they meet.
      lowest = LowestAt(corners(triangle)[(i + 2) % 3]);
      break;
    }
  }
  if (lowest != triangle) signs = SideSigns(Corners(lowest), p);
  return {
      .triangle = lowest, .weights = InteriorWeights(Corners(lowest), p, signs), .inside = true};
}

/// The lowest triangle at a point.
std::int32_t TriangleLocator::LowestAt(std::int32_t point) const {
  const std::vector<std::int32_t>& lowest = lazy_->lowest.Get([this] {
    std::vector<std::int32_t> made(points_.size(), -1);
    for (std::int32_t t = triangle_count(); t-- > 0;) {
      for (const std::int32_t corner : corners(t)) made[AsIndex(corner)] = t;
    }
    return made;
  });
  return lowest[AsIndex(point)];
}

/// Asks the tree for a triangle around p, and failing that for the nearest one.
Location TriangleLocator::Search(Vec2 p) const {
  const BoxTree& tree = Tree();
  std::int32_t around = -1;
  tree.ForEachMeeting({p, p}, [&](std::int32_t t) {
    if (Contains(Corners(t), p)) around = t;
    return around < 0;
  });
  if (around >= 0) return Canonical(p, around);

  Location nearest;
  double squared_distance = std::numeric_limits<double>::infinity();
  tree.ForEachNear(p, [&](std::int32_t t) {
    const BoundaryPoint candidate = NearestOnBoundary(Corners(t), p);
    const bool is_nearer = candidate.squared_distance < squared_distance;
    const bool is_tie = candidate.squared_distance == squared_distance;
    if (is_nearer || nearest.triangle < 0 || (is_tie && t < nearest.triangle)) {
      squared_distance = candidate.squared_distance;
      nearest = {.triangle = t, .weights = candidate.weights, .inside = false};
    }
    return squared_distance;
  });
  return nearest;
}

const BoxTree& TriangleLocator::Tree() const {
  return lazy_->tree.Get([this] {
    std::vector<BoundingBox> boxes;
    boxes.reserve(links_.size());
    for (std::int32_t t = 0; t < triangle_count(); ++t) boxes.push_back(BoxOf(Corners(t)));
    return BoxTree(boxes);
  });
}

Neighborhood FindNeighbors(std::span<const std::array<std::int32_t, 3>> triangles,
                           std::int32_t point_count, const StopSignal* stop) {
  // Sides are put in buckets by their lower end and sorted by the upper end inside each, so that
  // the two sides of an edge become neighbours in the list.
  const auto from = [](const std::array<std::int32_t, 3>& triangle, std::size_t corner) {
    return triangle[(corner + 1) % 3];
  };
  const auto to = [](const std::array<std::int32_t, 3>& triangle, std::size_t corner) {
    return triangle[(corner + 2) % 3];
  };
  StopPoll stopped(stop);
  std::vector<std::size_t> first(AsIndex(point_count) + 1, 0);
  for (const auto& triangle : triangles) {
    if (stopped()) return {};
    for (std::size_t i = 0; i < 3; ++i) {
      PLIANT_CHECK(triangle[i] >= 0 && triangle[i] < point_count, "corner", triangle[i]);
    }
    for (std::size_t i = 0; i < 3; ++i) {
      ++first[AsIndex(std::min(from(triangle, i), to(triangle, i))) + 1];
    }
  }
  for (std::size_t i = 1; i < first.size(); ++i) first[i] += first[i - 1];
  std::vector<LowSide> sides(3 * triangles.size());
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    if (stopped()) return {};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [lower, upper] = std::minmax({from(triangles[t], i), to(triangles[t], i)});
      sides[next[AsIndex(lower)]++] = {upper, static_cast<std::int32_t>(t),
                                       static_cast<std::int8_t>(i), lower == from(triangles[t], i)};
    }
  }
  Neighborhood result;
  result.across.assign(triangles.size(), {-1, -1, -1});
  for (std::size_t v = 0; v + 1 < first.size(); ++v) {
    if (stopped()) return {};
    PairSides(std::span(sides.data() + first[v], first[v + 1] - first[v]), result);
  }
  return result;
}

}  // namespace pliant
