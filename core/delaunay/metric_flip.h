#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/ids.h"
#include "core/geometry/vec2.h"
#include "core/mesh/mesh.h"
#include "core/mesh/mesh_edit.h"
#include "core/mesh/star.h"
#include "core/metric/metric.h"

namespace pliant {

/// True if edge xz of the counter-clockwise triangles xyz and zwx should become yw: the angles at
/// y and w, measured in `metric`, add up to more than 180 degrees. [BossenHeckbert1996, eq. 6]
///
/// Rounding must not make both diagonals look worse than the other: the sum has to be clearly
/// negative, by a share of its terms. @par Cost a dozen multiplications; half of them are skipped
/// where both angles are acute.
[[nodiscard]] bool WantsSwap(Vec2 x, Vec2 y, Vec2 z, Vec2 w, const Metric& metric);

/// Restores the anisotropic Delaunay criterion by edge swaps after a local change.
///
/// The paper's choice of metric for the test: the mean over the four corners after a move or an
/// insertion, the metric of the deleted node after a deletion. A swap needs both new triangles
/// positive, by exact predicates, and never touches a constrained edge or a frozen
/// triangle. Where the metric varies,
/// the criterion has no potential and could go round for ever: every run has a limit of swaps.
class MetricFlipper {
 public:
  explicit MetricFlipper(MeshEdit& edit) : edit_(edit), mesh_(edit.mesh()) {}

  /// After the center of a star moved: its spokes and its link, and on from there.
  /// @return swaps made
  std::int32_t AroundMoved(const Star& star);

  /// After a vertex was inserted: edges opposite to it only, so that each swap raises its degree
  /// and the number of swaps is finite by itself.
  std::int32_t AroundInserted(VertexId vertex);

  /// After a deletion: edges between two of `triangles`, measured in one metric.
  std::int32_t Within(std::span<const TriangleId> triangles, const Metric& metric);

 private:
  /// An edge by a triangle and the corner opposite. It may be out of date when its turn comes:
  /// a swap that changes one of its triangles enters it again.
  struct Entry {
    TriangleId triangle;
    VertexId apex;
  };
  enum class Spread { kAllSides, kOppositeApex };

  std::int32_t Run(Spread spread, std::int32_t swaps_max);
  /// The corner of the entry's apex if its edge may be swapped and wants to, else -1.
  [[nodiscard]] int SwappableCorner(const Entry& entry) const;

  MeshEdit& edit_;
  const Mesh& mesh_;
  std::vector<Entry> stack_;
  std::span<const TriangleId> inside_;  // Of Within: both triangles must be here.
  const Metric* metric_ = nullptr;      // Of Within, and null elsewhere.
};

}  // namespace pliant
