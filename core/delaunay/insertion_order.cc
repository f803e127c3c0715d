#include "core/delaunay/insertion_order.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/rng.h"
#include "core/base/stoppable_sort.h"

namespace pliant {
namespace {

/// Below this many points a round is not worth its own sort.
constexpr std::size_t kFirstRoundSize = 64;

/// Distance along the Hilbert curve through a grid of 2^31 x 2^31 cells.
std::uint64_t HilbertKey(std::uint32_t x, std::uint32_t y) {
  std::uint64_t key = 0;
  for (std::uint32_t bit = 1U << 30; bit != 0; bit >>= 1) {
    const bool right = (x & bit) != 0;
    const bool upper = (y & bit) != 0;
    key = 4 * key + (right ? (upper ? 2 : 3) : (upper ? 1 : 0));
    if (!upper) {  // The lower quadrants hold the curve mirrored at a diagonal.
      if (right) {
        x = ~x;
        y = ~y;
      }
      std::swap(x, y);
    }
  }
  return key;
}

/// Maps [low, high] to [0, 2^31). Halves keep the largest doubles from overflowing.
class GridAxis {
 public:
  GridAxis(double low, double high) : half_low_(0.5 * low), half_extent_(0.5 * high - 0.5 * low) {}

  [[nodiscard]] std::uint32_t Cell(double x) const {
    if (!(half_extent_ > 0)) return 0;
    const double share = (0.5 * x - half_low_) / half_extent_;
    return static_cast<std::uint32_t>(std::clamp(share, 0.0, 1.0) * 0x7fffffff);
  }

 private:
  double half_low_;
  double half_extent_;
};

/// Points with their distances along the curve through their bounding box.
std::vector<std::pair<std::uint64_t, std::int32_t>> KeyedPoints(std::span<const Vec2> points) {
  if (points.empty()) return {};
  const auto [low_x, high_x] = std::ranges::minmax(points, {}, &Vec2::x);
  const auto [low_y, high_y] = std::ranges::minmax(points, {}, &Vec2::y);
  const GridAxis axis_x(low_x.x, high_x.x);
  const GridAxis axis_y(low_y.y, high_y.y);
  std::vector<std::pair<std::uint64_t, std::int32_t>> keyed;
  keyed.reserve(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    keyed.emplace_back(HilbertKey(axis_x.Cell(points[i].x), axis_y.Cell(points[i].y)),
                       static_cast<std::int32_t>(i));
  }
  return keyed;
}

std::vector<std::int32_t> PointsOf(
    const std::vector<std::pair<std::uint64_t, std::int32_t>>& keyed) {
  std::vector<std::int32_t> order;
  order.reserve(keyed.size());
  for (const auto& [key, point] : keyed) order.push_back(point);
  return order;
}

}  // namespace

std::vector<std::int32_t> InsertionOrder(std::span<const Vec2> points, const StopSignal* stop) {
  std::vector<std::pair<std::uint64_t, std::int32_t>> keyed = KeyedPoints(points);
  Rng rng(points.size());
  for (std::size_t i = keyed.size(); i > 1; --i) std::swap(keyed[i - 1], keyed[rng.Below(i)]);
  std::size_t first = 0;
  std::size_t size = kFirstRoundSize;
  while (first < keyed.size()) {
    const std::size_t last = std::min(first + size, keyed.size());
    SortUnlessStopped(keyed.begin() + static_cast<std::ptrdiff_t>(first),
                      keyed.begin() + static_cast<std::ptrdiff_t>(last), stop);
    first = last;
    size = first;
  }
  return PointsOf(keyed);
}

std::vector<std::int32_t> HilbertOrder(std::span<const Vec2> points) {
  std::vector<std::pair<std::uint64_t, std::int32_t>> keyed = KeyedPoints(points);
  std::sort(keyed.begin(), keyed.end());
  return PointsOf(keyed);
}

}  // namespace pliant
