#include "core/delaunay/constrain.h"

#include <algorithm>
#include <tuple>

#include "core/base/check.h"
#include "core/geometry/predicates.h"
#include "core/geometry/segments.h"

namespace pliant {

using Triangle = HullTriangulation::Triangle;

Constrainer::Outcome Constrainer::Insert(const Edge& edge) {
  const Departure departure = Depart(edge);
  switch (departure.way) {
    case Way::kEdge:
      MarkSegment(departure.side, edge.segment);
      return Outcome::kInserted;
    case Way::kOverPoint:
      return Outcome::kBlocked;
    case Way::kAcross:
      break;
  }
  if (Cross(edge, departure.side) == Outcome::kBlocked) return Outcome::kBlocked;
  Refill(edge);
  return Outcome::kInserted;
}

/// Turns around the first point, counter-clockwise, until the edge itself or the triangle that it
/// enters is found.
Constrainer::Departure Constrainer::Depart(const Edge& edge) const {
  const Vec2 a = Point(edge.from);
  const Vec2 b = Point(edge.to);
  const std::int32_t start = hull_.triangle_of_point[static_cast<std::size_t>(edge.from)];
  std::int32_t at = start;
  do {
    const Triangle& triangle = At(at);
    const std::size_t corner = HullTriangulation::CornerAt(triangle, edge.from);
    const std::size_t next = NextCorner(corner);
    const std::size_t last = LastCorner(corner);
    const std::int32_t u = triangle.points[next];
    const std::int32_t v = triangle.points[last];
    if (u == edge.to) return {Way::kEdge, {at, last}};
    if (v == edge.to) return {Way::kEdge, {at, next}};
    if (!HullTriangulation::IsGhost(triangle)) {
      const int side_u = Orient2d(a, b, Point(u));
      if (side_u == 0 && IsAhead(a, b, Point(u))) return {Way::kOverPoint, {at, corner}};
      if (side_u < 0 && Orient2d(a, b, Point(v)) > 0) return {Way::kAcross, {at, corner}};
    }
    at = triangle.neighbors[next];
  } while (at != start);
  // On the border of the hull, the last point of the turn is no triangle's u.
  return {Way::kOverPoint, {start, 0}};
}

void Constrainer::MarkSegment(Side side, std::int32_t segment) const {
  Triangle& triangle = At(side.triangle);
  triangle.segments[side.corner] = segment;
  Triangle& other = At(triangle.neighbors[side.corner]);
  other.segments[HullTriangulation::CornerOpposite(other, side.triangle)] = segment;
}

/// Gathers what lies on the way from the first triangle, left by `side`, to the end of the edge.
Constrainer::Outcome Constrainer::Cross(const Edge& edge, Side side) {
  const Vec2 a = Point(edge.from);
  const Vec2 b = Point(edge.to);
  crossed_.assign(1, side.triangle);
  right_.assign(1, At(side.triangle).points[NextCorner(side.corner)]);
  left_.assign(1, At(side.triangle).points[LastCorner(side.corner)]);
  for (;;) {
    const Triangle& triangle = At(side.triangle);
    if (triangle.segments[side.corner] >= 0) return Outcome::kBlocked;
    const std::int32_t beyond = triangle.neighbors[side.corner];
    const Triangle& other = At(beyond);
    PLIANT_CHECK(!HullTriangulation::IsGhost(other), "segment", edge.segment);
    const std::size_t apex = HullTriangulation::CornerOpposite(other, side.triangle);
    const std::int32_t point = other.points[apex];
    crossed_.push_back(beyond);
    if (point == edge.to) return Outcome::kInserted;
    const int where = Orient2d(a, b, Point(point));
    if (where == 0) return Outcome::kBlocked;
    (where > 0 ? left_ : right_).push_back(point);
    // The left end of the side just crossed follows the apex in `other`, the right one precedes it.
    side = {beyond, where > 0 ? NextCorner(apex) : LastCorner(apex)};
  }
}

/// Replaces the crossed triangles by those of the two pockets, which are as many.
void Constrainer::Refill(const Edge& edge) {
  for (std::int32_t t : crossed_) marks_[static_cast<std::size_t>(t)] = edge.segment;
  const auto [lower, upper] = std::minmax(edge.from, edge.to);
  records_.assign(1, {lower, upper, {-1, 0}, edge.segment});
  for (std::int32_t t : crossed_) RecordRim(t);
  std::ranges::reverse(right_);
  FillPocket({edge.from, edge.to, 0, left_.size()}, left_);
  FillPocket({edge.to, edge.from, 0, right_.size()}, right_);
  PLIANT_CHECK(crossed_.empty(), "segment", edge.segment, "left over", crossed_.size());
  LinkRecords();
}

/// Notes the triangles around the hole, and the segments at its rim or hanging into it.
void Constrainer::RecordRim(std::int32_t t) {
  const Triangle& triangle = At(t);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [lower, upper] =
        std::minmax(triangle.points[NextCorner(i)], triangle.points[LastCorner(i)]);
    const std::int32_t beyond = triangle.neighbors[i];
    const bool is_rim =
        marks_[static_cast<std::size_t>(beyond)] != marks_[static_cast<std::size_t>(t)];
    if (is_rim) {
      const Side side = {beyond, HullTriangulation::CornerOpposite(At(beyond), t)};
      records_.push_back({lower, upper, side, triangle.segments[i]});
    } else if (triangle.segments[i] >= 0) {
      records_.push_back({lower, upper, {-1, 0}, triangle.segments[i]});
    }
  }
}

/// Cuts off triangle after triangle, each with a base and the apex that is Delaunay for it.
///
/// Every point of the chain was joined across the base by an edge that was removed. These edges
/// show that all points of a pocket lie strictly left of its base, that the chosen apex sees the
/// base, and that a point that occurs twice in a chain (where an edge hangs into the hole) is never
/// chosen while its other occurrence is in the pocket: so the triangles fit together.
void Constrainer::FillPocket(const Pocket& whole, std::span<const std::int32_t> chain) {
  pockets_.assign(1, whole);
  while (!pockets_.empty()) {
    const Pocket pocket = pockets_.back();
    pockets_.pop_back();
    if (pocket.count == 0) continue;
    const std::size_t k = ChooseApex(pocket, chain);
    const std::int32_t apex = chain[k];
    PLIANT_CHECK(!crossed_.empty(), "apex", apex);
    const std::int32_t slot = crossed_.back();
    crossed_.pop_back();
    At(slot) = {.points = {pocket.start, pocket.end, apex},
                .neighbors = {-1, -1, -1},
                .segments = {-1, -1, -1}};
    for (std::size_t i = 0; i < 3; ++i) {
      const std::array<std::int32_t, 3>& corners = At(slot).points;
      const auto [lower, upper] = std::minmax(corners[NextCorner(i)], corners[LastCorner(i)]);
      records_.push_back({lower, upper, {slot, i}, -1});
      hull_.triangle_of_point[static_cast<std::size_t>(corners[i])] = slot;
    }
    const std::size_t count = k - pocket.first;
    pockets_.push_back({pocket.start, apex, pocket.first, count});
    pockets_.push_back({apex, pocket.end, k + 1, pocket.count - count - 1});
  }
}

/// The point of the chain whose circle through the base holds no other. The search starts in the
/// middle: among co-circular points that keeps the two rests of equal size.
std::size_t Constrainer::ChooseApex(const Pocket& pocket,
                                    std::span<const std::int32_t> chain) const {
  const Vec2 a = Point(pocket.start);
  const Vec2 b = Point(pocket.end);
  std::size_t apex = pocket.first + pocket.count / 2;
  for (std::size_t k = pocket.first; k < pocket.first + pocket.count; ++k) {
    if (InCircle(a, b, Point(chain[apex]), Point(chain[k])) > 0) apex = k;
  }
  return apex;
}

/// Joins the two triangles at each edge, and gives both sides the segment of the edge.
void Constrainer::LinkRecords() {
  const auto key = [](const EdgeRecord& r) { return std::tuple(r.lower, r.upper); };
  std::ranges::sort(records_, {}, [](const EdgeRecord& r) {
    return std::tuple(r.lower, r.upper, r.side.triangle, r.side.corner);
  });
  for (std::size_t first = 0; first < records_.size();) {
    std::size_t last = first;
    std::int32_t segment = -1;
    while (last < records_.size() && key(records_[last]) == key(records_[first])) {
      segment = std::max(segment, records_[last].segment);
      ++last;
    }
    // Records without a triangle come first.
    PLIANT_CHECK(last - first >= 2 && records_[last - 2].side.triangle >= 0 &&
                     (last - first == 2 || records_[last - 3].side.triangle < 0),
                 "lower", records_[first].lower, "upper", records_[first].upper);
    const Side a = records_[last - 2].side;
    const Side b = records_[last - 1].side;
    At(a.triangle).neighbors[a.corner] = b.triangle;
    At(b.triangle).neighbors[b.corner] = a.triangle;
    At(a.triangle).segments[a.corner] = segment;
    At(b.triangle).segments[b.corner] = segment;
    first = last;
  }
}

}  // namespace pliant
