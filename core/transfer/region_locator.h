#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/geometry/locate.h"
#include "core/transfer/touched_region.h"

namespace pliant {

/// Finds new points in the old triangles of a touched region.
///
/// It knows an old triangle near every vertex of the new mesh: for an old vertex one that it had,
/// for a new one that which its neighbours lead to. So a search is a walk of a few triangles, also
/// among needles, where a tree of boxes would have to look at very many.
/// *Invariants*: as TriangleLocator, answers do not depend on what is known.
/// *Threads*: one at a time.
class RegionLocator {
 public:
  /// @pre region.before has a triangle. @par Cost O(k log k)
  explicit RegionLocator(const TouchedRegion& region);

  /// Where p lies in region.before.
  /// @param vertex  a vertex of region.after near p.
  [[nodiscard]] Location Locate(Vec2 p, std::int32_t vertex) const {
    return before_.Locate(p, hints_[static_cast<std::size_t>(vertex)]);
  }

  /// Neighbours of old triangle t within the region.
  [[nodiscard]] const std::array<std::int32_t, 3>& neighbors(std::int32_t t) const {
    return before_.neighbors(t);
  }

 private:
  void SpreadHints(const TouchedRegion& region);

  TriangleLocator before_;
  std::vector<std::int32_t> hints_;  // Per vertex of region.after.
};

}  // namespace pliant
