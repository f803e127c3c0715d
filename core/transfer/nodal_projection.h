#pragma once

#include <cstdint>
#include <vector>

#include "core/transfer/cell_mass.h"
#include "core/transfer/components.h"
#include "core/transfer/field.h"
#include "core/transfer/mass_matrix.h"
#include "core/transfer/overlap.h"
#include "core/transfer/transfer_rows.h"

namespace pliant {

/// The part of conservative nodal transfer that is the same for all fields: the unknowns, which are
/// the vertices of region.after, and their mass matrix. Its triangles are those of the region and
/// those around it that share a vertex with it, because a value at the rim counts there too.
struct NodalSystem {
  MassMatrix matrix;
  std::vector<double> spread;  ///< Solution of matrix x = lumped: about 1, falls off at the rim.
  /// Joined where triangles share an unknown.
  OverlapComponents components;
};
/// `components` still waits for the overlaps and for Finish.
[[nodiscard]] NodalSystem MakeNodalSystem(const Mesh& mesh, const TouchedRegion& region);

/// Conservative transfer of a nodal field: of all functions that are linear on the new triangles
/// and keep their values at vertices none of whose triangles changed, the one that is nearest to
/// the old function in L2 and has its integral. [FarrellMaddison2011]
///
/// The right hand side is integrated exactly over the overlaps of old and new triangles. The
/// solution is sought as a correction of linear interpolation: so constants stay to the bit, and
/// linear functions up to rounding. It can go beyond the old extrema near jumps, as every
/// projection in L2 does. The integral is kept in each piece of the region, by a multiplier.
///
/// Where the boundary moved, the part of a new triangle outside of the old domain takes the
/// interpolated values, and the multiplier then spreads the difference of the integrals evenly
/// over the vertices of the piece.
class NodalProjection {
 public:
  /// @param field, region, rows  must outlive this. @pre the field lives on vertices
  NodalProjection(const Field& field, const TouchedRegion& region, const TransferRows& rows);

  /// @pre called for every triangle of region.after once
  void Add(std::int32_t after, const OverlapFinder& found);
  [[nodiscard]] FieldRows Finish(const NodalSystem& system);

 private:
  [[nodiscard]] double OldValue(std::int32_t before, std::size_t corner, std::size_t column) const;
  [[nodiscard]] double Interpolated(std::int32_t vertex, std::size_t column) const {
    return interpolated_[static_cast<std::size_t>(vertex) * field_.column_count + column];
  }
  void AddResidual(std::int32_t after, const Overlap& overlap);
  [[nodiscard]] std::vector<double> Multipliers(const NodalSystem& system, std::size_t column,
                                                std::span<const double> correction) const;

  const Field& field_;
  const TouchedRegion& region_;
  std::vector<double> interpolated_;            // Per vertex of region.after and column.
  std::vector<std::vector<double>> residuals_;  // Per column and vertex.
};

}  // namespace pliant
