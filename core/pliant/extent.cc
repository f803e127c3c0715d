#include "core/pliant/extent.h"

#include <cmath>

namespace pliant {
namespace {

double StarArea(const Mesh& mesh, const Star& star, std::size_t k) {
  const VertexRecord& center = mesh.vertex(star.center());
  const VertexRecord& a = mesh.vertex(star.ring()[k]);
  const VertexRecord& b = mesh.vertex(star.ring_after(k));
  return NormalizedArea(center.position, center.metric, a.position, a.metric, b.position, b.metric);
}

template <class IsAllowed>
SpokeExtent LargestAmong(const Mesh& mesh, const Star& star, IsAllowed is_allowed) {
  const VertexRecord& center = mesh.vertex(star.center());
  const std::size_t triangle_count = star.triangles().size();
  SpokeExtent largest;
  double area_before = star.closed() ? StarArea(mesh, star, triangle_count - 1) : 0;
  for (std::size_t k = 0; k < star.ring().size(); ++k) {
    const double area_after = k < triangle_count ? StarArea(mesh, star, k) : 0;
    double extent = 0.8 * (area_before + area_after);
    area_before = area_after;
    if (center.edge.valid() && mesh.FindEdge(star.center(), star.ring()[k]).valid()) {
      extent = 0.5 * SquaredEdgeLength(center, mesh.vertex(star.ring()[k]));
    }
    if (extent > largest.extent && is_allowed(k)) largest = {k, extent};
  }
  return largest;
}

}  // namespace

double NodeExtent(const Mesh& mesh, const Star& star) { return NodeExtent(mesh, star, Crowd()); }

double NodeExtent(const Mesh& mesh, const Star& star, const Crowd& crowd) {
  const VertexRecord& center = mesh.vertex(star.center());
  if (center.edge.valid()) {
    const auto [before, after] = mesh.SegmentEdges(star.center());
    const double sum =
        std::sqrt(SquaredEdgeLength(center, mesh.vertex(mesh.edge(before).vertices[0]))) +
        std::sqrt(SquaredEdgeLength(center, mesh.vertex(mesh.edge(after).vertices[1])));
    return 0.5 * sum * sum;
  }
  double area = 0;
  for (std::size_t k = 0; k < star.triangles().size(); ++k) area += StarArea(mesh, star, k);
  const double n = crowd.NeighborCount(star.ring().size());
  return 2.3 / std::sqrt(n * (n - 2)) * area;
}

SpokeExtent LargestSpokeExtent(const Mesh& mesh, const Star& star) {
  return LargestAmong(mesh, star, [](std::size_t) { return true; });
}

bool MaySplit(const Mesh& mesh, const Star& star, std::size_t spoke,
              const Permissions& permissions) {
  const EdgeId edge = mesh.FindEdge(star.center(), star.ring()[spoke]);
  if (edge.valid()) return permissions.surface && !mesh.edge(edge).frozen;
  // Both triangles at any other edge lie in one region: they are frozen together.
  const std::size_t at = spoke < star.triangles().size() ? spoke : spoke - 1;
  return !mesh.triangle(star.triangles()[at]).frozen;
}

SpokeExtent LargestFreeSpokeExtent(const Mesh& mesh, const Star& star,
                                   const Permissions& permissions) {
  return LargestAmong(mesh, star,
                      [&](std::size_t spoke) { return MaySplit(mesh, star, spoke, permissions); });
}

}  // namespace pliant
