#include "core/pliant/plane_partition.h"

#include <algorithm>
#include <cstddef>

#include "core/base/check.h"

namespace pliant {

PlanePartition::PlanePartition(std::vector<Vec2> points, std::int32_t part_count, double low_share)
    : low_share_(low_share) {
  PLIANT_CHECK(part_count >= 1 && !points.empty(), "part_count", part_count);
  Cut(points, 0, part_count);
}

void PlanePartition::Cut(std::span<Vec2> points, std::int32_t first_part, std::int32_t part_count) {
  const std::size_t self = nodes_.size();
  nodes_.emplace_back();
  if (part_count == 1 || points.empty()) {
    nodes_[self].part = first_part;
    return;
  }
  const auto by_x = [](Vec2 a, Vec2 b) { return a.x < b.x; };
  const auto by_y = [](Vec2 a, Vec2 b) { return a.y < b.y; };
  const auto [left, right] = std::minmax_element(points.begin(), points.end(), by_x);
  const auto [low, high] = std::minmax_element(points.begin(), points.end(), by_y);
  const bool cut_x = right->x - left->x >= high->y - low->y;
  const std::int32_t low_count =
      std::clamp(static_cast<std::int32_t>(low_share_ * part_count), 1, part_count - 1);
  const auto middle = static_cast<std::ptrdiff_t>(points.size()) * low_count / part_count;
  std::nth_element(points.begin(), points.begin() + middle, points.end(),
                   [&](Vec2 a, Vec2 b) { return cut_x ? by_x(a, b) : by_y(a, b); });
  const Vec2 at = points[static_cast<std::size_t>(middle)];
  // By value, because where nth_element leaves equal points is not the same everywhere.
  const auto rest = std::partition(points.begin(), points.end(),
                                   [&](Vec2 p) { return cut_x ? by_x(p, at) : by_y(p, at); });
  const auto below = static_cast<std::size_t>(rest - points.begin());
  nodes_[self].by_x = cut_x;
  nodes_[self].at = cut_x ? at.x : at.y;
  Cut(points.first(below), first_part, low_count);
  nodes_[self].high = static_cast<std::int32_t>(nodes_.size());
  Cut(points.subspan(below), first_part + low_count, part_count - low_count);
}

}  // namespace pliant
