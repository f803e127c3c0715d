#pragma once

#include "core/geometry/vec2.h"

namespace pliant {

/// True if p lies on the segment ab, its ends excluded. Exact. @pre a != b, all finite
[[nodiscard]] bool IsInsideSegment(Vec2 a, Vec2 b, Vec2 p);

/// True if some point lies inside both ab and cd, ends excluded: they cross or overlap. Segments
/// that share an end, or of which one ends on the other, do not. Exact.
/// @pre a != b, c != d, all finite
[[nodiscard]] bool CrossOrOverlap(Vec2 a, Vec2 b, Vec2 c, Vec2 d);

/// True if p, a point of the line ab, lies on the same side of a as b does. Exact.
/// @pre Orient2d(a, b, p) == 0, p != a, a != b
[[nodiscard]] bool IsAhead(Vec2 a, Vec2 b, Vec2 p);

}  // namespace pliant
