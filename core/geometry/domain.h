#pragma once

#include <cstdint>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/vec2.h"

namespace pliant {

/// A straight piece of the boundary or of an internal constraint.
struct Segment {
  std::int32_t a = 0;    ///< Index into Domain::points.
  std::int32_t b = 0;    ///< Index into Domain::points, != a.
  std::int32_t tag = 0;  ///< Any value; every edge that comes to lie on the segment carries it.

  friend bool operator==(const Segment&, const Segment&) = default;
};

/// Gives the region around `point`, up to the next segments, a tag.
struct RegionSeed {
  Vec2 point;
  std::int32_t tag = 0;

  friend bool operator==(const RegionSeed&, const RegionSeed&) = default;
};

/// A polygonal domain, in the convention of Triangle's .poly files: what can be reached from far
/// away, or from a hole seed, without crossing a segment is outside; the rest is the domain.
/// Segments with the domain on both sides are internal constraints; they need not form loops.
/// Points on no segment are fixed vertices of the mesh. Loops may touch and share points.
struct Domain {
  std::vector<Vec2> points;  ///< Point i becomes vertex slot i of the session's mesh.
  std::vector<Segment> segments;
  std::vector<Vec2> holes;          ///< One point inside each hole.
  std::vector<RegionSeed> regions;  ///< Triangles of a region without a seed carry tag 0.
};

}  // namespace pliant
