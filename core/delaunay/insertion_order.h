#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/stop_signal.h"
#include "core/geometry/vec2.h"

namespace pliant {

/// The order in which points are inserted: rounds that double in size [Amenta2003], each along a
/// Hilbert curve, so that the next point is near the last one and no input is a bad one.
/// Deterministic: depends on the points only. Cost O(n log n).
/// @param stop  not owned; null: nobody; else asked, and the order is of no use if it says yes.
[[nodiscard]] std::vector<std::int32_t> InsertionOrder(std::span<const Vec2> points,
                                                       const StopSignal* stop = nullptr);

/// Points along one Hilbert curve through their bounding box: neighbours in the plane are near each
/// other in the order. Points in one cell of its 2^62 are in order of index. Cost O(n log n).
[[nodiscard]] std::vector<std::int32_t> HilbertOrder(std::span<const Vec2> points);

}  // namespace pliant
