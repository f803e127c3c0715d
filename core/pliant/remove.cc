#include "core/pliant/remove.h"

#include <algorithm>
#include <vector>

#include "core/pliant/retriangulate.h"

namespace pliant {
namespace {

/// The ring from one of its vertices to another, counter-clockwise, both included.
std::vector<VertexId> RingBetween(const Star& star, VertexId from, VertexId to) {
  const std::span<const VertexId> ring = star.ring();
  std::vector<VertexId> part;
  std::size_t k =
      static_cast<std::size_t>(std::find(ring.begin(), ring.end(), from) - ring.begin());
  for (;; k = (k + 1) % ring.size()) {
    part.push_back(ring[k]);
    if (ring[k] == to) return part;
  }
}

/// The polygons that remain when a center on a segment goes: one, or one on each side.
std::vector<std::vector<VertexId>> PolygonsOf(const Mesh& mesh, const Star& star) {
  if (!star.closed()) return {{star.ring().begin(), star.ring().end()}};
  const auto [before, after] = mesh.SegmentEdges(star.center());
  const VertexId a = mesh.edge(before).vertices[0];
  const VertexId b = mesh.edge(after).vertices[1];
  return {RingBetween(star, a, b), RingBetween(star, b, a)};
}

/// The region of the star's triangle that begins at ring vertex `from`.
std::int32_t RegionAfter(const Mesh& mesh, const Star& star, VertexId from) {
  const auto k = static_cast<std::size_t>(std::find(star.ring().begin(), star.ring().end(), from) -
                                          star.ring().begin());
  return mesh.triangle(star.triangles()[k]).region;
}

/// Triangles in place of the star of a vertex on a segment; nothing if there are none.
std::optional<std::vector<NewTriangle>> CutBesideSegment(const Mesh& mesh, const Star& star) {
  std::vector<NewTriangle> triangles;
  for (const std::vector<VertexId>& polygon : PolygonsOf(mesh, star)) {
    if (polygon.size() < 3) return std::nullopt;
    const auto part = CutEars(mesh, polygon, mesh.metric(star.center()),
                              RegionAfter(mesh, star, polygon.front()));
    if (!part) return std::nullopt;
    triangles.insert(triangles.end(), part->begin(), part->end());
  }
  return triangles;
}

}  // namespace

std::optional<std::int32_t> RemoveNode(MeshEdit& edit, MetricFlipper& flipper, const Star& star,
                                       AfterRemoval after) {
  const Mesh& mesh = edit.mesh();
  const VertexId center = star.center();
  const Metric metric = mesh.metric(center);
  const bool on_segment = mesh.vertex(center).edge.valid();
  const auto triangles =
      on_segment ? CutBesideSegment(mesh, star)
                 : CutEars(mesh, star.ring(), metric, mesh.triangle(star.triangles()[0]).region);
  if (!triangles) return std::nullopt;
  if (on_segment) {
    edit.MergeEdges(center);
    edit.ReplaceCavity(star.triangles(), *triangles);
  } else {
    edit.ReplaceStar(star, *triangles);
  }
  edit.RemoveVertex(center);

  if (after == AfterRemoval::kLeaveEdges) return 0;
  // Both use the slots of the star in order.
  return flipper.Within(star.triangles().first(triangles->size()), metric);
}

}  // namespace pliant
