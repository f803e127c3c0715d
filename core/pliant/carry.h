#pragma once

#include <optional>
#include <vector>

#include "core/base/stop_signal.h"
#include "core/mesh/mesh_edit.h"
#include "core/metric/metric_field.h"
#include "core/pliant/followed_metric.h"
#include "core/pliant/recalled_field.h"

namespace pliant {

/// What an update is left with after vertices were carried along.
struct CarriedUpdate {
  WantedTensors wanted;             ///< Of live vertices, where they are now, that may change.
  std::vector<VertexId> disturbed;  ///< Whose triangles have changed shape, ascending.
  std::int64_t carried_count = 0;   ///< Vertices that moved.
  std::int64_t removed_count = 0;   ///< Vertices that they ran over.
};

struct CarryOptions {
  double tolerance = 0;               ///< Options::metric_tolerance
  const StopSignal* stop = nullptr;   ///< Asked until vertices begin to move; null: nobody.
  RecalledField* recalled = nullptr;  ///< The field, if it can learn of a shift; else null.
};

/// Moves the vertices of a zone whose metric changes along with the metric, where that has moved as
/// a whole: afterwards most of them have the tensor again that they had, and their triangles the
/// shape, so that the loop has little to do there. What they run over is removed, and the cavity
/// that this leaves triangulated.
///
/// Vertices on constrained edges stay, and so does whoever's tensor is not found again at the other
/// end of the shift. If the metric changes at few vertices, has not moved as a whole, or its way is
/// blocked, nothing happens; every triangle stays positive in any case.
/// @param field      the metric to be followed from now on
/// @param wanted     its tensors at the vertices
/// @return nothing if it was stopped: then nobody has moved
/// @par Cost O(k log k) for k vertices that change
[[nodiscard]] std::optional<CarriedUpdate> CarryAlong(MeshEdit& edit, const MetricField& field,
                                                      WantedTensors wanted,
                                                      const CarryOptions& options);

}  // namespace pliant
