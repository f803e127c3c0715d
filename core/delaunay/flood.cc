#include "core/delaunay/flood.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/as_index.h"
#include "core/delaunay/check_domain.h"
#include "core/geometry/locate.h"
#include "core/geometry/predicates.h"

namespace pliant {
namespace {

using Triangle = DomainTriangulation::Triangle;

enum class Place : std::uint8_t { kInside, kOutside, kHole };

/// How many segments end at each point.
std::vector<std::int32_t> CountEnds(const Domain& domain) {
  std::vector<std::int32_t> end_count(domain.points.size(), 0);
  for (const Segment& s : domain.segments) {
    ++end_count[AsIndex(s.a)];
    ++end_count[AsIndex(s.b)];
  }
  return end_count;
}

/// The lowest point at which one segment ends, one of those for which is_stray(segment) holds.
template <class Predicate>
std::optional<Error> FindLooseEnd(const Domain& domain, Predicate is_stray) {
  const std::vector<std::int32_t> end_count = CountEnds(domain);
  std::int32_t point = -1;
  std::int32_t segment = -1;
  for (std::size_t i = 0; i < domain.segments.size(); ++i) {
    if (!is_stray(i)) continue;
    for (std::int32_t end : {domain.segments[i].a, domain.segments[i].b}) {
      if (end_count[AsIndex(end)] == 1 && (point < 0 || end < point)) {
        point = end;
        segment = static_cast<std::int32_t>(i);
      }
    }
  }
  if (point < 0) return std::nullopt;
  return Error{.code = ErrorCode::kOpenLoop,
               .message = "The boundary does not close: only " + SegmentText(domain, segment) +
                          " ends at " + PointText(domain, point) +
                          ", and outside reaches both of its sides. Add the segment that is " +
                          "missing there, or remove this one.",
               .field = "domain.points",
               .index = point,
               .other_index = segment};
}

Error EmptyDomainError() {
  return Error{.code = ErrorCode::kNothingInside,
               .message =
                   "Nothing is inside the domain: its loops enclose no area, or its hole seeds "
                   "empty them all. Close a loop around the domain, or remove a hole seed.",
               .field = "domain.segments"};
}

/// Floods the triangles of a hull from outside and from seeds.
class Flood {
 public:
  Flood(const Domain& domain, HullTriangulation hull)
      : domain_(domain),
        triangles_(std::move(hull.triangles)),
        places_(triangles_.size(), Place::kInside) {}

  void Outside();
  void LocateSeeds();
  void Holes();
  [[nodiscard]] Status CheckSegmentsAndPoints() const;
  [[nodiscard]] Status CheckSeeds() const;
  [[nodiscard]] Status TagRegions();
  [[nodiscard]] DomainTriangulation Inside() &&;

 private:
  /// Visits the triangles that can be reached from those on the stack without crossing a segment.
  /// enter(t) says whether a triangle is to be visited, and marks it so that it is not again.
  template <class Enter>
  void Spread(Enter enter);
  [[nodiscard]] bool IsOnSegment(Vec2 p, const Location& at,
                                 const std::vector<std::int32_t>& end_count) const;

  const Domain& domain_;
  std::vector<Triangle> triangles_;
  std::vector<Place> places_;
  std::vector<std::int32_t> stack_;
  /// The triangle around each seed; -1 for one that lies on a segment or out of the hull.
  std::vector<std::int32_t> hole_triangles_;
  std::vector<std::int32_t> region_triangles_;
};

template <class Enter>
void Flood::Spread(Enter enter) {
  while (!stack_.empty()) {
    const Triangle& triangle = triangles_[AsIndex(stack_.back())];
    stack_.pop_back();
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int32_t beyond = triangle.neighbors[i];
      if (triangle.segments[i] < 0 && enter(beyond)) stack_.push_back(beyond);
    }
  }
}

void Flood::Outside() {
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    if (!HullTriangulation::IsGhost(triangles_[t])) continue;
    places_[t] = Place::kOutside;
    stack_.push_back(static_cast<std::int32_t>(t));
  }
  Spread([this](std::int32_t t) {
    return std::exchange(places_[AsIndex(t)], Place::kOutside) != Place::kOutside;
  });
}

void Flood::LocateSeeds() {
  if (domain_.holes.empty() && domain_.regions.empty()) return;
  std::vector<std::array<std::int32_t, 3>> corners;
  std::vector<std::int32_t> slots;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    if (HullTriangulation::IsGhost(triangles_[t])) continue;
    corners.push_back(triangles_[t].points);
    slots.push_back(static_cast<std::int32_t>(t));
  }
  const TriangleLocator locator(domain_.points, corners);
  const std::vector<std::int32_t> end_count = CountEnds(domain_);
  const auto locate = [&](Vec2 p) {
    Location at = locator.Locate(p, -1);
    at.triangle = slots[AsIndex(at.triangle)];
    return at.inside && !IsOnSegment(p, at, end_count) ? at.triangle : -1;
  };
  for (Vec2 hole : domain_.holes) hole_triangles_.push_back(locate(hole));
  for (const RegionSeed& seed : domain_.regions) region_triangles_.push_back(locate(seed.point));
}

bool Flood::IsOnSegment(Vec2 p, const Location& at,
                        const std::vector<std::int32_t>& end_count) const {
  const Triangle& triangle = triangles_[AsIndex(at.triangle)];
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec2 a = domain_.points[AsIndex(triangle.points[NextCorner(i)])];
    const Vec2 b = domain_.points[AsIndex(triangle.points[LastCorner(i)])];
    if (p == a && end_count[AsIndex(triangle.points[NextCorner(i)])] > 0) return true;
    if (triangle.segments[i] >= 0 && Orient2d(a, b, p) == 0) return true;
  }
  return false;
}

void Flood::Holes() {
  const auto enter = [this](std::int32_t t) {
    if (places_[AsIndex(t)] != Place::kInside) return false;
    places_[AsIndex(t)] = Place::kHole;
    return true;
  };
  for (std::int32_t t : hole_triangles_) {
    if (t < 0 || !enter(t)) continue;
    stack_.push_back(t);
    Spread(enter);
  }
}

Status Flood::CheckSegmentsAndPoints() const {
  std::vector<bool> segment_is_seen(domain_.segments.size(), false);
  std::vector<bool> point_is_seen(domain_.points.size(), false);
  bool is_empty = true;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    if (places_[t] != Place::kInside) continue;
    is_empty = false;
    for (std::size_t i = 0; i < 3; ++i) {
      point_is_seen[AsIndex(triangles_[t].points[i])] = true;
      if (triangles_[t].segments[i] >= 0)
        segment_is_seen[AsIndex(triangles_[t].segments[i])] = true;
    }
  }
  const auto loose_end = FindLooseEnd(domain_, [&](std::size_t i) { return !segment_is_seen[i]; });
  if (loose_end) return *loose_end;
  if (is_empty) return EmptyDomainError();
  const auto segment = std::ranges::find(segment_is_seen, false);
  if (segment != segment_is_seen.end()) {
    const auto index = static_cast<std::int32_t>(segment - segment_is_seen.begin());
    return Error{.code = ErrorCode::kSegmentOutsideDomain,
                 .message = "The " + SegmentText(domain_, index) +
                            " has outside or a hole on both sides. Remove it, or correct the loops "
                            "or hole seeds that leave it out.",
                 .field = "domain.segments",
                 .index = index};
  }
  const auto point = std::ranges::find(point_is_seen, false);
  if (point != point_is_seen.end()) {
    const auto index = static_cast<std::int32_t>(point - point_is_seen.begin());
    return Error{.code = ErrorCode::kPointOutsideDomain,
                 .message = "The " + PointText(domain_, index) +
                            " lies outside the domain or in a hole. Remove it or move it inside.",
                 .field = "domain.points",
                 .index = index};
  }
  return {};
}

Status Flood::CheckSeeds() const {
  const auto error = [](const char* kind, const char* field, std::size_t index, Vec2 p) {
    return Error{.code = ErrorCode::kSeedOutsideDomain,
                 .message = std::string("The ") + kind + " seed " + std::to_string(index) + " at " +
                            Text(p) +
                            " lies on a segment or outside the domain. Put it strictly inside the "
                            "area that it means, or remove it.",
                 .field = field,
                 .index = static_cast<std::int64_t>(index)};
  };
  for (std::size_t i = 0; i < hole_triangles_.size(); ++i) {
    const std::int32_t t = hole_triangles_[i];
    if (t < 0 || places_[AsIndex(t)] == Place::kOutside) {
      return error("hole", "domain.holes", i, domain_.holes[i]);
    }
  }
  for (std::size_t i = 0; i < region_triangles_.size(); ++i) {
    const std::int32_t t = region_triangles_[i];
    if (t < 0 || places_[AsIndex(t)] != Place::kInside) {
      return error("region", "domain.regions", i, domain_.regions[i].point);
    }
  }
  return {};
}

Status Flood::TagRegions() {
  std::vector<std::int32_t> seed_of(triangles_.size(), -1);
  std::int32_t lowest = -1;
  std::int32_t other = -1;
  for (std::size_t i = 0; i < domain_.regions.size(); ++i) {
    const auto seed = static_cast<std::int32_t>(i);
    const std::int32_t start = region_triangles_[i];
    const std::int32_t first = seed_of[AsIndex(start)];
    if (first >= 0) {
      const bool clashes = domain_.regions[AsIndex(first)].tag != domain_.regions[i].tag;
      if (clashes && (lowest < 0 || first < lowest)) {
        lowest = first;
        other = seed;
      }
      continue;
    }
    const auto enter = [&](std::int32_t t) {
      if (seed_of[AsIndex(t)] >= 0) return false;
      seed_of[AsIndex(t)] = seed;
      triangles_[AsIndex(t)].region = domain_.regions[i].tag;
      return true;
    };
    enter(start);
    stack_.push_back(start);
    Spread(enter);
  }
  if (lowest < 0) return {};
  const RegionSeed& a = domain_.regions[AsIndex(lowest)];
  const RegionSeed& b = domain_.regions[AsIndex(other)];
  return Error{.code = ErrorCode::kConflictingRegions,
               .message = "Region seeds " + std::to_string(lowest) + " at " + Text(a.point) +
                          " with tag " + std::to_string(a.tag) + " and " + std::to_string(other) +
                          " at " + Text(b.point) + " with tag " + std::to_string(b.tag) +
                          " lie in one region. Remove one, or separate them by segments.",
               .field = "domain.regions",
               .index = lowest,
               .other_index = other};
}

DomainTriangulation Flood::Inside() && {
  std::vector<std::int32_t> new_slots(triangles_.size(), -1);
  std::int32_t count = 0;
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    if (places_[t] == Place::kInside) new_slots[t] = count++;
  }
  DomainTriangulation result;
  result.triangles.reserve(AsIndex(count));
  for (std::size_t t = 0; t < triangles_.size(); ++t) {
    if (new_slots[t] < 0) continue;
    result.triangles.push_back(triangles_[t]);
    for (std::int32_t& neighbor : result.triangles.back().neighbors) {
      neighbor = new_slots[AsIndex(neighbor)];
    }
  }
  return result;
}

}  // namespace

Result<DomainTriangulation> KeepInside(const Domain& domain, HullTriangulation hull,
                                       const StopSignal* stop) {
  const auto asked = [&] { return stop != nullptr && stop->asked(); };
  Flood flood(domain, std::move(hull));
  flood.Outside();
  flood.LocateSeeds();
  flood.Holes();
  if (asked()) return Stopped();
  PLIANT_RETURN_IF_ERROR(flood.CheckSegmentsAndPoints());
  PLIANT_RETURN_IF_ERROR(flood.CheckSeeds());
  PLIANT_RETURN_IF_ERROR(flood.TagRegions());
  if (asked()) return Stopped();
  return std::move(flood).Inside();
}

Error NothingInsideError(const Domain& domain) {
  const auto loose_end = FindLooseEnd(domain, [](std::size_t) { return true; });
  return loose_end ? *loose_end : EmptyDomainError();
}

}  // namespace pliant
