#include "tests/support/cell_domain.h"

#include <array>
#include <cstddef>
#include <utility>

#include "core/base/as_index.h"
#include "core/geometry/predicates.h"

namespace pliant::testing {
CellDomain::CellDomain(std::int32_t n, Rng& rng)
    : n_(n), shaken_(rng.Below(3) == 0), joins_(!shaken_ && rng.Below(2) == 0) {
  const double shake = shaken_ ? 0.3 / n : 0;
  for (std::int32_t row = 0; row <= n; ++row) {
    for (std::int32_t column = 0; column <= n; ++column) {
      corners_.push_back({(column + 0.0) / n + shake * rng.Uniform(-1, 1),
                          (row + 0.0) / n + shake * rng.Uniform(-1, 1)});
    }
  }
  for (std::int32_t i = 0; i < n * n; ++i) {
    cells_.push_back(rng.Below(4) == 0 ? kOutside : static_cast<std::int32_t>(rng.Below(3)));
  }
  Make();
}

void CellDomain::Change(Rng& rng) {
  if (!shaken_) joins_ = rng.Below(2) == 0;
  const std::uint64_t count = rng.Below(4) == 0 ? AsIndex(n_ * n_) : 1 + rng.Below(3);
  for (std::uint64_t i = 0; i < count; ++i) {
    cells_[rng.Below(cells_.size())] =
        rng.Below(3) == 0 ? kOutside : static_cast<std::int32_t>(rng.Below(3));
  }
  Make();
}

std::int32_t CellDomain::At(std::int32_t column, std::int32_t row) const {
  const bool in_grid = column >= 0 && column < n_ && row >= 0 && row < n_;
  return in_grid ? cells_[AsIndex(row * n_ + column)] : kOutside;
}

Vec2 CellDomain::Corner(std::int32_t column, std::int32_t row) const {
  return corners_[AsIndex(row * (n_ + 1) + column)];
}

std::vector<Vec2> CellDomain::CellCorners(std::int32_t column, std::int32_t row) const {
  return {Corner(column, row), Corner(column + 1, row), Corner(column + 1, row + 1),
          Corner(column, row + 1)};
}

bool CellDomain::HoldsOnSegment(Vec2 p) const {
  for (const Segment& segment : domain_.segments) {
    const Vec2 a = domain_.points[AsIndex(segment.a)];
    const Vec2 b = domain_.points[AsIndex(segment.b)];
    const bool beside = (p.x < a.x && p.x < b.x) || (p.x > a.x && p.x > b.x) ||
                        (p.y < a.y && p.y < b.y) || (p.y > a.y && p.y > b.y);
    if (!beside && Orient2d(a, b, p) == 0) return true;
  }
  return false;
}

bool CellDomain::HoldsInside(Vec2 p) const {
  if (HoldsOnSegment(p)) return false;
  for (std::int32_t i = 0; i < n_ * n_; ++i) {
    if (cells_[AsIndex(i)] == kOutside) continue;
    const std::vector<Vec2> corners = CellCorners(i % n_, i / n_);
    bool inside = true;
    for (std::size_t k = 0; k < 4; ++k) {
      inside = inside && Orient2d(corners[k], corners[(k + 1) % 4], p) >= 0;
    }
    if (inside) return true;
  }
  return false;
}

void CellDomain::Make() {
  bool empty = true;
  for (const std::int32_t cell : cells_) empty = empty && cell == kOutside;
  if (empty) cells_.front() = 0;
  domain_ = {};
  std::vector<std::int32_t> point_of_corner(corners_.size(), -1);
  AddSides(true, point_of_corner);
  AddSides(false, point_of_corner);
  AddSeeds();
  Measure();
}

/// The sides between cells that differ, along columns or along rows. A segment's tag says what lies
/// beside it, so that a tag changes where a cell does.
void CellDomain::AddSides(bool vertical, std::vector<std::int32_t>& point_of_corner) {
  const auto point = [&](std::int32_t along, std::int32_t across) {
    const std::int32_t corner = vertical ? along * (n_ + 1) + across : across * (n_ + 1) + along;
    std::int32_t& known = point_of_corner[AsIndex(corner)];
    if (known < 0) {
      known = static_cast<std::int32_t>(domain_.points.size());
      domain_.points.push_back(corners_[AsIndex(corner)]);
    }
    return known;
  };
  const auto beside = [&](std::int32_t along, std::int32_t across) {
    return vertical ? std::pair(At(across - 1, along), At(across, along))
                    : std::pair(At(along, across), At(along, across - 1));
  };
  const auto is_crossed = [&](std::int32_t along, std::int32_t across) {
    const std::array around{beside(along - 1, across), beside(along, across)};
    const bool through = around[0].first != around[1].first || around[0].second != around[1].second;
    return through || around[0].first == around[0].second;
  };
  for (std::int32_t across = 0; across <= n_; ++across) {
    for (std::int32_t along = 0; along < n_; ++along) {
      const auto [left, right] = beside(along, across);
      if (left == right) continue;
      std::int32_t end = along + 1;
      while (joins_ && end < n_ && !is_crossed(end, across)) ++end;
      domain_.segments.push_back(
          {point(along, across), point(end, across), 100 + 10 * (left + 1) + right + 1});
      along = end - 1;
    }
  }
}

/// A seed in every part: regions, and holes that outside does not reach.
void CellDomain::AddSeeds() {
  // One more ring of cells around the grid is outside for certain.
  const std::int32_t wide = n_ + 2;
  std::vector<bool> seen(AsIndex(wide * wide), false);
  for (std::int32_t start = 0; start < wide * wide; ++start) {
    if (seen[AsIndex(start)]) continue;
    const std::int32_t column = start % wide - 1;
    const std::int32_t row = start / wide - 1;
    const std::int32_t state = At(column, row);
    std::vector<std::int32_t> stack{start};
    seen[AsIndex(start)] = true;
    while (!stack.empty()) {
      const std::int32_t at = stack.back();
      stack.pop_back();
      for (const auto& [dx, dy] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
        const std::int32_t x = at % wide + dx;
        const std::int32_t y = at / wide + dy;
        if (x < 0 || x >= wide || y < 0 || y >= wide || seen[AsIndex(y * wide + x)]) continue;
        if (At(x - 1, y - 1) != state) continue;
        seen[AsIndex(y * wide + x)] = true;
        stack.push_back(y * wide + x);
      }
    }
    if (start == 0 || state == 0) continue;
    const std::vector<Vec2> corners = CellCorners(column, row);
    const Vec2 center = 0.25 * (corners[0] + corners[1] + corners[2] + corners[3]);
    if (state == kOutside) {
      domain_.holes.push_back(center);
    } else {
      domain_.regions.push_back({center, state});
    }
  }
}

void CellDomain::Measure() {
  area_ = 0;
  regions_.clear();
  tags_.clear();
  for (std::int32_t i = 0; i < n_ * n_; ++i) {
    if (cells_[AsIndex(i)] == kOutside) continue;
    const std::vector<Vec2> corners = CellCorners(i % n_, i / n_);
    double doubled = 0;
    for (std::size_t k = 0; k < 4; ++k) doubled += Cross(corners[k], corners[(k + 1) % 4]);
    area_ += 0.5 * doubled;
    regions_[cells_[AsIndex(i)]] += 0.5 * doubled;
  }
  for (const Segment& segment : domain_.segments) {
    tags_[segment.tag] +=
        Length(domain_.points[AsIndex(segment.b)] - domain_.points[AsIndex(segment.a)]);
  }
}

}  // namespace pliant::testing
