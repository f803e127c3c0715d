#include "core/transfer/region_locator.h"

#include "core/base/as_index.h"

namespace pliant {
namespace {

/// Passes in which knowledge spreads from old vertices to new ones. Triangles come in ascending
/// order, in which new ones follow what they were cut from, so that one pass reaches far; whatever
/// is left after the last begins its search at triangle 0.
constexpr int kPassesMax = 8;

}  // namespace

RegionLocator::RegionLocator(const TouchedRegion& region)
    : before_(region.before.points, region.before.triangles),
      hints_(region.after.vertex_ids.size(), -1) {
  std::vector<std::int32_t> triangle_of(region.before.vertex_ids.size(), 0);
  for (std::size_t t = 0; t < region.before.triangles.size(); ++t) {
    for (const std::int32_t corner : region.before.triangles[t]) {
      triangle_of[AsIndex(corner)] = static_cast<std::int32_t>(t);
    }
  }
  SlotMap old_vertices(region.before.vertex_ids.size());
  for (const VertexId id : region.before.vertex_ids) old_vertices.Add(id.value());
  for (std::size_t v = 0; v < hints_.size(); ++v) {
    const std::int32_t known = old_vertices.Find(region.after.vertex_ids[v].value());
    if (known >= 0) hints_[v] = triangle_of[AsIndex(known)];
  }
  SpreadHints(region);
}

void RegionLocator::SpreadHints(const TouchedRegion& region) {
  bool changed = true;
  bool complete = false;
  for (int pass = 0; pass < kPassesMax && changed && !complete; ++pass) {
    changed = false;
    complete = true;
    for (const auto& corners : region.after.triangles) {
      std::int32_t known = -1;
      for (const std::int32_t corner : corners) {
        if (hints_[AsIndex(corner)] >= 0) known = hints_[AsIndex(corner)];
      }
      for (const std::int32_t corner : corners) {
        std::int32_t& hint = hints_[AsIndex(corner)];
        if (hint >= 0) continue;
        if (known < 0) {
          complete = false;
          continue;
        }
        hint = before_.Locate(region.after.points[AsIndex(corner)], known).triangle;
        known = hint;
        changed = true;
      }
    }
  }
  for (std::int32_t& hint : hints_) {
    if (hint < 0) hint = 0;
  }
}

}  // namespace pliant
