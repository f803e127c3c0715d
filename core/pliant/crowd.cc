#include "core/pliant/crowd.h"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// A polygon with fewer corners is none.
constexpr double kNeighborsMin = 3;

/// The length of the ring's edge behind vertex k if both its ends are given, at most 1; 1 of
/// others.
double LinkLength(const Mesh& mesh, const Star& star, std::size_t k) {
  const VertexRecord& a = mesh.vertex(star.ring()[k]);
  const VertexRecord& b = mesh.vertex(star.ring_after(k));
  if (!a.fixed || !b.fixed) return 1;
  const double squared = SquaredEdgeLength(a, b);
  return squared < 1 ? std::sqrt(squared) : 1;
}

}  // namespace

bool Crowd::MeasureLinks(const Mesh& mesh, const Star& star) {
  const std::size_t ring_count = star.ring().size();
  const std::size_t link_count = star.triangles().size();
  weights_.assign(ring_count, 1);
  neighbor_count_ = 0;
  bool any = false;
  double before = star.closed() ? LinkLength(mesh, star, link_count - 1) : 1;
  for (std::size_t k = 0; k < ring_count; ++k) {
    const double after = k < link_count ? LinkLength(mesh, star, k) : 1;
    // Where a row ends, the edge that is not of the ring is most likely as long as the one that is.
    const bool is_inside = before < 1 && after < 1;
    weights_[k] = is_inside ? 0.5 * (before + after) : std::min(before, after);
    any = any || weights_[k] < 1;
    if (k < link_count) neighbor_count_ += after;
    before = after;
  }
  neighbor_count_ = std::max(neighbor_count_, kNeighborsMin);
  return any;
}

}  // namespace pliant
