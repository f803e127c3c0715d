#include "core/delaunay/check_domain.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/as_index.h"
#include "core/base/stoppable_sort.h"
#include "core/geometry/box_tree.h"
#include "core/geometry/segments.h"

namespace pliant {
namespace {

/// Triangles, ghosts included, are at most twice the points and are counted in 32 bits.
constexpr std::size_t kPointCountMax = std::size_t{1} << 29;
constexpr std::size_t kSegmentCountMax = std::size_t{1} << 30;

std::string Digits(double x) {
  std::array<char, 32> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), x).ptr;
  return {digits.data(), end};
}

Vec2 StartOf(const Domain& domain, const Segment& s) { return domain.points[AsIndex(s.a)]; }
Vec2 EndOf(const Domain& domain, const Segment& s) { return domain.points[AsIndex(s.b)]; }

Status CheckIndices(const Domain& domain) {
  const auto count = static_cast<std::int64_t>(domain.points.size());
  for (std::size_t i = 0; i < domain.segments.size(); ++i) {
    for (std::int32_t end : {domain.segments[i].a, domain.segments[i].b}) {
      if (end >= 0 && end < count) continue;
      return Error{.code = ErrorCode::kIndexOutOfRange,
                   .message = "Segment " + std::to_string(i) + " ends at point " +
                              std::to_string(end) + ", but there are " + std::to_string(count) +
                              " points, numbered from 0. Correct the segment or add the point.",
                   .field = "domain.segments",
                   .index = static_cast<std::int64_t>(i)};
    }
  }
  return {};
}

template <class Range, class Position>
Status CheckFinite(const Range& range, Position position, const char* field) {
  for (std::size_t i = 0; i < range.size(); ++i) {
    const Vec2 p = position(range[i]);
    if (IsFinite(p)) continue;
    return Error{.code = ErrorCode::kNotFinite,
                 .message = "Element " + std::to_string(i) + " of " + field +
                            " has the coordinates " + Text(p) + ". Give finite numbers.",
                 .field = field,
                 .index = static_cast<std::int64_t>(i)};
  }
  return {};
}

Status CheckSizes(const Domain& domain) {
  const auto error = [](ErrorCode code, const char* field, const std::string& message) {
    return Error{.code = code, .message = message, .field = field};
  };
  if (domain.points.empty()) {
    return error(ErrorCode::kEmpty, "domain.points",
                 "The domain has no points. Give the corners of its boundary.");
  }
  if (domain.segments.empty()) {
    return error(ErrorCode::kEmpty, "domain.segments",
                 "The domain has no segments. Give the segments of its boundary.");
  }
  if (domain.points.size() > kPointCountMax) {
    return error(ErrorCode::kTooLarge, "domain.points",
                 "The domain has more than 2^29 points. Give fewer.");
  }
  if (domain.segments.size() > kSegmentCountMax) {
    return error(ErrorCode::kTooLarge, "domain.segments",
                 "The domain has more than 2^30 segments. Give fewer.");
  }
  return {};
}

/// Elements of equal key: the lowest one that has a twin, and the next one equal to it.
struct Twins {
  std::int32_t lowest = std::numeric_limits<std::int32_t>::max();
  std::int32_t other = -1;

  [[nodiscard]] bool exist() const { return other >= 0; }
};

/// @param keyed  pairs of a key and an index, in any order. @param stop  as for CheckArrays
template <class Key>
Twins FindTwins(std::vector<std::pair<Key, std::int32_t>> keyed, const StopSignal* stop) {
  SortUnlessStopped(keyed.begin(), keyed.end(), stop);
  Twins twins;
  for (std::size_t k = 0; k + 1 < keyed.size(); ++k) {
    if (keyed[k].first == keyed[k + 1].first && keyed[k].second < twins.lowest) {
      twins = {.lowest = keyed[k].second, .other = keyed[k + 1].second};
    }
  }
  return twins;
}

Status CheckDuplicatePoints(const Domain& domain, const StopSignal* stop) {
  std::vector<std::pair<std::pair<double, double>, std::int32_t>> keyed;
  keyed.reserve(domain.points.size());
  for (std::size_t i = 0; i < domain.points.size(); ++i) {
    // Adding 0 makes +0 of -0.
    keyed.push_back(
        {{domain.points[i].x + 0.0, domain.points[i].y + 0.0}, static_cast<std::int32_t>(i)});
  }
  const Twins twins = FindTwins(std::move(keyed), stop);
  if (!twins.exist()) return {};
  return Error{.code = ErrorCode::kDuplicatePoint,
               .message = "Points " + std::to_string(twins.lowest) + " and " +
                          std::to_string(twins.other) + " are both at " +
                          Text(domain.points[AsIndex(twins.lowest)]) +
                          ". Remove one and let its segments end at the other.",
               .field = "domain.points",
               .index = twins.lowest,
               .other_index = twins.other};
}

Status CheckSegmentEnds(const Domain& domain, const StopSignal* stop) {
  std::vector<std::pair<std::pair<std::int32_t, std::int32_t>, std::int32_t>> keyed;
  keyed.reserve(domain.segments.size());
  for (std::size_t i = 0; i < domain.segments.size(); ++i) {
    const auto [a, b, tag] = domain.segments[i];
    if (a == b) {
      return Error{.code = ErrorCode::kZeroLengthSegment,
                   .message = "Segment " + std::to_string(i) + " joins " + PointText(domain, a) +
                              " to itself. Remove it or correct one of its ends.",
                   .field = "domain.segments",
                   .index = static_cast<std::int64_t>(i)};
    }
    keyed.push_back({{std::min(a, b), std::max(a, b)}, static_cast<std::int32_t>(i)});
  }
  const Twins twins = FindTwins(std::move(keyed), stop);
  if (!twins.exist()) return {};
  const Segment& segment = domain.segments[AsIndex(twins.lowest)];
  return Error{.code = ErrorCode::kDuplicateSegment,
               .message = "Segments " + std::to_string(twins.lowest) + " and " +
                          std::to_string(twins.other) + " both join " +
                          PointText(domain, segment.a) + " and " + PointText(domain, segment.b) +
                          ". Remove one of them.",
               .field = "domain.segments",
               .index = twins.lowest,
               .other_index = twins.other};
}

BoundingBox BoxOfSegment(const Domain& domain, const Segment& s) {
  return BoxOf(std::array{StartOf(domain, s), EndOf(domain, s)});
}

Error CrossingError(const Domain& domain, std::int32_t segment, std::int32_t other) {
  return {.code = ErrorCode::kCrossingSegments,
          .message = "A point inside " + SegmentText(domain, segment) + " lies also inside " +
                     SegmentText(domain, other) +
                     ". Split both where they cross, or remove what overlaps.",
          .field = "domain.segments",
          .index = segment,
          .other_index = other};
}

Error PointOnSegmentError(const Domain& domain, std::int32_t point, std::int32_t segment) {
  return {.code = ErrorCode::kPointOnSegment,
          .message = "The " + PointText(domain, point) + " lies inside " +
                     SegmentText(domain, segment) +
                     ". Split the segment at the point, or move the point.",
          .field = "domain.points",
          .index = point,
          .other_index = segment};
}

Status CheckCrossings(const Domain& domain, const BoxTree& tree) {
  for (std::size_t i = 0; i < domain.segments.size(); ++i) {
    const Segment& s = domain.segments[i];
    std::int32_t other = std::numeric_limits<std::int32_t>::max();
    tree.ForEachMeeting(BoxOfSegment(domain, s), [&](std::int32_t k) {
      const Segment& t = domain.segments[AsIndex(k)];
      if (AsIndex(k) != i && k < other &&
          CrossOrOverlap(StartOf(domain, s), EndOf(domain, s), StartOf(domain, t),
                         EndOf(domain, t))) {
        other = k;
      }
      return true;
    });
    if (other == std::numeric_limits<std::int32_t>::max()) continue;
    return CrossingError(domain, static_cast<std::int32_t>(i), other);
  }
  return {};
}

Status CheckPointsOnSegments(const Domain& domain, const BoxTree& tree) {
  for (std::size_t i = 0; i < domain.points.size(); ++i) {
    const Vec2 p = domain.points[i];
    std::int32_t on = std::numeric_limits<std::int32_t>::max();
    tree.ForEachMeeting({p, p}, [&](std::int32_t k) {
      const Segment& s = domain.segments[AsIndex(k)];
      if (IsInsideSegment(StartOf(domain, s), EndOf(domain, s), p)) on = std::min(on, k);
      return true;
    });
    if (on == std::numeric_limits<std::int32_t>::max()) continue;
    return PointOnSegmentError(domain, static_cast<std::int32_t>(i), on);
  }
  return {};
}

}  // namespace

Status CheckArrays(const Domain& domain, const StopSignal* stop) {
  const auto itself = [](Vec2 p) { return p; };
  const auto seed_point = [](const RegionSeed& seed) { return seed.point; };
  PLIANT_RETURN_IF_ERROR(CheckIndices(domain));
  PLIANT_RETURN_IF_ERROR(CheckFinite(domain.points, itself, "domain.points"));
  PLIANT_RETURN_IF_ERROR(CheckFinite(domain.holes, itself, "domain.holes"));
  PLIANT_RETURN_IF_ERROR(CheckFinite(domain.regions, seed_point, "domain.regions"));
  PLIANT_RETURN_IF_ERROR(CheckSizes(domain));
  PLIANT_RETURN_IF_ERROR(CheckDuplicatePoints(domain, stop));
  return CheckSegmentEnds(domain, stop);
}

Status CheckSegment(const Domain& domain, std::int32_t segment) {
  const Segment& s = domain.segments[AsIndex(segment)];
  for (std::size_t i = 0; i < domain.segments.size(); ++i) {
    const auto k = static_cast<std::int32_t>(i);
    const Segment& t = domain.segments[i];
    if (k != segment && CrossOrOverlap(StartOf(domain, t), EndOf(domain, t), StartOf(domain, s),
                                       EndOf(domain, s))) {
      return CrossingError(domain, std::min(k, segment), std::max(k, segment));
    }
  }
  for (std::size_t i = 0; i < domain.points.size(); ++i) {
    if (IsInsideSegment(StartOf(domain, s), EndOf(domain, s), domain.points[i])) {
      return PointOnSegmentError(domain, static_cast<std::int32_t>(i), segment);
    }
  }
  return {};
}

Status CheckSegments(const Domain& domain) {
  std::vector<BoundingBox> boxes;
  boxes.reserve(domain.segments.size());
  for (const Segment& s : domain.segments) boxes.push_back(BoxOfSegment(domain, s));
  const BoxTree tree(boxes);
  PLIANT_RETURN_IF_ERROR(CheckCrossings(domain, tree));
  return CheckPointsOnSegments(domain, tree);
}

std::string Text(Vec2 p) {
  std::string text = "(";
  text.append(Digits(p.x)).append(", ").append(Digits(p.y)).append(")");
  return text;
}

std::string PointText(const Domain& domain, std::int32_t point) {
  return "point " + std::to_string(point) + " at " + Text(domain.points[AsIndex(point)]);
}

std::string SegmentText(const Domain& domain, std::int32_t segment) {
  const Segment& s = domain.segments[AsIndex(segment)];
  return "segment " + std::to_string(segment) + " from " + Text(StartOf(domain, s)) + " to " +
         Text(EndOf(domain, s));
}

}  // namespace pliant
