#include "core/transfer/touched_region.h"

#include <algorithm>
#include <bit>

#include "core/base/sort_unique.h"
#include "core/mesh/mesh_diff.h"
#include "core/mesh/star.h"

namespace pliant {
namespace {

/// Numbers the corners of `triangle_ids`; `corners_of` and `position_of` say which mesh is meant.
template <class CornersOf, class PositionOf>
RegionMesh Number(std::vector<TriangleId> triangle_ids, CornersOf corners_of,
                  PositionOf position_of) {
  RegionMesh region;
  region.triangle_ids = std::move(triangle_ids);
  region.triangles.reserve(region.triangle_ids.size());
  SlotMap local(region.triangle_ids.size());
  for (const TriangleId id : region.triangle_ids) {
    const std::array<VertexId, 3>& corners = corners_of(id);
    std::array<std::int32_t, 3> indices{};
    for (std::size_t i = 0; i < 3; ++i) {
      indices[i] = local.Add(corners[i].value());
      if (static_cast<std::size_t>(local.count()) == region.vertex_ids.size()) continue;
      region.vertex_ids.push_back(corners[i]);
      region.points.push_back(position_of(corners[i]));
    }
    region.triangles.push_back(indices);
  }
  return region;
}

/// Where the mesh has grown, new triangles have old corners of which no old triangle was touched:
/// such a triangle joins the region, so that there is something beside the new ones. Those corners
/// lie on constrained edges, which the mesh has grown across.
void AddNeighbors(const OldMesh& old, std::vector<TriangleId>& before,
                  std::vector<TriangleId>& after) {
  SlotMap known;
  const auto on_edge = [&](VertexId corner) { return old.mesh().vertex(corner).edge.valid(); };
  for (const TriangleId id : before) {
    for (const VertexId corner : old.triangle(id).vertices) {
      if (on_edge(corner)) known.Add(corner.value());
    }
  }
  const std::size_t count = after.size();
  for (std::size_t i = 0; i < count; ++i) {
    for (const VertexId corner : old.mesh().triangle(after[i]).vertices) {
      if (!on_edge(corner) || known.Find(corner.value()) >= 0) continue;
      if (!old.mesh().vertex(corner).committed) continue;
      const TriangleId beside = old.vertex(corner).triangle;
      known.Add(corner.value());
      before.push_back(beside);
      // It may have changed itself; then it is not what it was.
      const TriangleRecord& now = old.mesh().triangle(beside);
      if (now.live && now.vertices == old.triangle(beside).vertices) after.push_back(beside);
    }
  }
}

}  // namespace

bool SamePosition(Vec2 a, Vec2 b) {
  return std::bit_cast<std::uint64_t>(a.x) == std::bit_cast<std::uint64_t>(b.x) &&
         std::bit_cast<std::uint64_t>(a.y) == std::bit_cast<std::uint64_t>(b.y);
}

TouchedRegion GatherTouchedRegion(const OldMesh& old) {
  const Mesh& mesh = old.mesh();
  std::vector<TriangleId> changed;
  std::vector<TriangleId> before;
  std::vector<TriangleId> after;
  for (const auto& [id, record] : old.log().triangles) {
    const TriangleRecord& now = mesh.triangle(id);
    const bool same = record.live && now.live &&
                      CanonicalTriangle(record.vertices) == CanonicalTriangle(now.vertices);
    if (same) continue;
    changed.push_back(id);
    if (record.live) before.push_back(id);
    if (now.live) after.push_back(id);
  }
  std::sort(changed.begin(), changed.end());

  // A vertex may move while its triangles keep their corners: those are not in the log.
  TouchedRegion region;
  Star star;
  for (const auto& [id, record] : old.log().vertices) {
    const VertexRecord& now = mesh.vertex(id);
    if (!now.live || (record.live && SamePosition(record.position, now.position))) continue;
    region.moved.push_back(id);
    if (!record.live) continue;
    for (const TriangleId fan : FansOf(mesh, id)) {
      star.Gather(mesh, id, fan);
      for (const TriangleId triangle : star.triangles()) {
        if (std::binary_search(changed.begin(), changed.end(), triangle)) continue;
        before.push_back(triangle);
        after.push_back(triangle);
      }
    }
  }
  std::sort(region.moved.begin(), region.moved.end());
  AddNeighbors(old, before, after);
  SortUnique(before);
  SortUnique(after);

  region.before = Number(
      std::move(before),
      [&](TriangleId id) -> const std::array<VertexId, 3>& { return old.triangle(id).vertices; },
      [&](VertexId id) { return old.position(id); });
  region.after = Number(
      std::move(after),
      [&](TriangleId id) -> const std::array<VertexId, 3>& { return mesh.triangle(id).vertices; },
      [&](VertexId id) { return mesh.position(id); });
  return region;
}

}  // namespace pliant
