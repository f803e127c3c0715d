#pragma once

#include <span>

#include "core/base/ids.h"
#include "core/geometry/vec2.h"
#include "core/metric/metric.h"

namespace pliant {

/// A displacement and tensors at vertices, in one update. All spans must outlive what takes it.
struct TensorsAhead {
  std::span<const VertexId> displaced;  ///< As for DisplaceVertices, with `by`.
  std::span<const Vec2> by;
  /// Whose tensors are sent, by the mesh before the displacement; empty: all live vertices in
  /// ascending order of slot.
  std::span<const VertexId> vertices;
  /// Row i is the wanted tensor at the place of vertex i plus its displacement, if it has one.
  std::span<const Metric> tensors;
};

}  // namespace pliant
