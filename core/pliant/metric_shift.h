#pragma once

#include <optional>
#include <span>

#include "core/base/stop_signal.h"
#include "core/geometry/vec2.h"
#include "core/metric/metric.h"
#include "core/metric/metric_field.h"

namespace pliant {

/// A tensor that stood at a place before an update.
struct PlacedTensor {
  Vec2 position;
  Metric tensor;
  std::int32_t hint = 0;  ///< For the new field, at the position.
};

/// How far the metric has moved, if it has moved as a whole: the shift u for which the new field at
/// p + u is most like the old tensor at p, over samples.
///
/// Looks in 16 directions at distances from the size of the samples' box down to 1/1000 of it, then
/// refines the best by a compass search and Gauss-Newton steps on the logarithms of the tensors.
/// @param samples  where the metric has changed; some dozens do
/// @param stop  who may end the search; null: nobody
/// @return nothing if no shift explains most of the change, or if it was stopped
/// @par Cost some thousand questions to the field
[[nodiscard]] std::optional<Vec2> FindShift(std::span<const PlacedTensor> samples,
                                            const MetricField& field,
                                            const StopSignal* stop = nullptr);

/// The same by Gauss-Newton steps alone, from a shift that is nearly right.
/// @par Cost some hundred questions to the field
[[nodiscard]] Vec2 RefineShift(std::span<const PlacedTensor> samples, const MetricField& field,
                               Vec2 from);

}  // namespace pliant
