#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "core/base/rng.h"
#include "core/geometry/domain.h"

namespace pliant::testing {

/// A domain that is made of the cells of a grid: what two of them have in common can be told cell
/// by cell. Its loops touch, its parts need not hang together, and holes come and go with cells.
class CellDomain {
 public:
  static constexpr std::int32_t kOutside = -1;

  /// A grid of n x n cells in the unit square (or a little beyond), at least one of them inside.
  /// Corners of cells lie on a lattice or are shaken; in a lattice straight runs may be one
  /// segment.
  CellDomain(std::int32_t n, Rng& rng);

  /// Lets some cells be something else; the corners stay.
  void Change(Rng& rng);

  [[nodiscard]] const Domain& domain() const { return domain_; }
  [[nodiscard]] double area() const { return area_; }
  [[nodiscard]] const std::map<std::int32_t, double>& region_areas() const { return regions_; }
  [[nodiscard]] const std::map<std::int32_t, double>& tag_lengths() const { return tags_; }

  /// True if p lies inside a cell of the domain or on the border of two of one region, not on a
  /// segment. Exact.
  [[nodiscard]] bool HoldsInside(Vec2 p) const;
  /// True if p lies on a segment of the domain. Exact.
  [[nodiscard]] bool HoldsOnSegment(Vec2 p) const;

 private:
  [[nodiscard]] std::int32_t At(std::int32_t column, std::int32_t row) const;
  [[nodiscard]] Vec2 Corner(std::int32_t column, std::int32_t row) const;
  [[nodiscard]] std::vector<Vec2> CellCorners(std::int32_t column, std::int32_t row) const;
  void Make();
  void AddSides(bool vertical, std::vector<std::int32_t>& point_of_corner);
  void AddSeeds();
  void Measure();

  std::int32_t n_;
  bool shaken_ = false;
  bool joins_ = false;  // Straight runs become one segment.
  std::vector<Vec2> corners_;
  std::vector<std::int32_t> cells_;  // Region tags, or kOutside.
  Domain domain_;
  double area_ = 0;
  std::map<std::int32_t, double> regions_;
  std::map<std::int32_t, double> tags_;
};

}  // namespace pliant::testing
