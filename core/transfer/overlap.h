#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/transfer/region_locator.h"
#include "core/transfer/touched_region.h"

namespace pliant {

/// A convex polygon, corners counter-clockwise: what two triangles have in common.
struct ConvexPolygon {
  /// Three corners and one more for each of three cuts, and as many again that rounding may add.
  std::array<Vec2, 9> corners;
  std::size_t count = 0;

  /// >= 0 up to rounding.
  [[nodiscard]] double Area() const;
};

/// What a new triangle has in common with one old triangle.
struct Overlap {
  std::int32_t before = -1;  ///< Of region.before.
  ConvexPolygon polygon;     ///< Relative to the first corner of the new triangle.
};

/// The old triangles under each new triangle of a touched region.
///
/// Which triangles overlap is decided by exact predicates, so that none is missed and none is
/// taken twice, however thin they are; the polygons' corners are rounded.
/// *Threads*: one at a time.
class OverlapFinder {
 public:
  /// @param region, locator  must outlive this.
  OverlapFinder(const TouchedRegion& region, const RegionLocator& locator)
      : region_(region), locator_(locator), seen_(region.before.triangles.size(), 0) {}

  /// Finds the old triangles that share interior points with triangle `after` of region.after.
  ///
  /// While the boundary stays, they cover it. After the boundary moved, parts of it may lie outside
  /// of the old domain, and where they cut what it has inside in pieces, those that hold neither a
  /// centre nor (nearly) a corner of the triangle are missed.
  /// @par Cost  O(triangles found)
  void Find(std::int32_t after);

  /// Of the last Find, in order of discovery.
  [[nodiscard]] const std::vector<Overlap>& overlaps() const { return overlaps_; }
  /// The old triangle around the centre of the last new one, or nearest to it.
  [[nodiscard]] std::int32_t nearest() const { return nearest_; }

 private:
  void Flood(std::int32_t seed, const std::array<Vec2, 3>& corners);

  const TouchedRegion& region_;
  const RegionLocator& locator_;
  std::vector<Overlap> overlaps_;
  std::int32_t nearest_ = -1;
  std::int64_t find_count_ = 0;
  std::vector<std::int64_t> seen_;  // Per old triangle, the last Find that met it.
  std::vector<std::int32_t> stack_;
};

}  // namespace pliant
