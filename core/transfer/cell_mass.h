#pragma once

#include <cstdint>
#include <vector>

#include "core/transfer/components.h"
#include "core/transfer/field.h"
#include "core/transfer/overlap.h"

namespace pliant {

/// Conservative transfer of a per-triangle field: the mean of the old piecewise constant function
/// over each new triangle, by the areas of the overlaps. So it makes no new extrema.
///
/// What the rounding of areas leaves of the integral's difference in a piece of the region is given
/// to the triangles in which different old values meet, in proportion to the room between their
/// value and the bounds that those set.
///
/// Where the boundary moved, the part of a new triangle outside of the old domain takes the value
/// of the nearest old triangle. Then the integral of the piece is made what it was: as above as far
/// as there is room; else all values of one sign are scaled by one factor, and others shifted by
/// one difference. So what is squeezed gets denser and what expands gets thinner.
class CellMass {
 public:
  /// @param field, region  must outlive this. @pre the field lives on triangles
  CellMass(const Field& field, const TouchedRegion& region);

  /// @pre called for every triangle of region.after once
  void Add(std::int32_t after, const OverlapFinder& found);
  [[nodiscard]] FieldRows Finish(const OverlapComponents& components);

 private:
  struct Entry {
    double value = 0;
    double low = 0;
    double high = 0;
  };

  [[nodiscard]] double OldValue(std::int32_t before, std::size_t column) const;
  void Correct(const OverlapComponents& components, std::size_t column);

  const Field& field_;
  const TouchedRegion& region_;
  std::vector<double> old_areas_;
  std::vector<double> new_areas_;
  std::vector<Entry> entries_;  // Per new triangle and column.
};

/// A difference of integrals below this share of the integral of the absolute value is rounding
/// and not a domain that grew or shrank: thin triangles' areas are known to about 1e-12 only.
inline constexpr double kRoundingShare = 0x1p-36;

}  // namespace pliant
