#include "core/delaunay/metric_flip.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/predicates.h"

namespace pliant {
namespace {

/// Share of the terms of eq. 6 by which their sum must be negative. Far above the rounding of the
/// terms, far below any angle that matters (1e-10 radians for a square).
constexpr double kSwapMargin = 1e-10;

/// Swaps after one move. Most moves need none or one; the limit only ends the endless.
constexpr std::int32_t kSwapsAfterMoveMax = 200;

}  // namespace

bool WantsSwap(Vec2 x, Vec2 y, Vec2 z, Vec2 w, const Metric& metric) {
  const double dot_y = InnerProduct(metric, z - y, x - y);
  const double dot_w = InnerProduct(metric, x - w, z - w);
  if (dot_y >= 0 && dot_w >= 0) return false;  // Two acute angles.
  const double at_y = Cross(z - y, x - y) * dot_w;
  const double at_w = dot_y * Cross(x - w, z - w);
  return at_y + at_w < -kSwapMargin * (std::fabs(at_y) + std::fabs(at_w));
}

std::int32_t MetricFlipper::AroundMoved(const Star& star) {
  for (std::size_t k = 0; k < star.triangles().size(); ++k) {
    stack_.push_back({star.triangles()[k], star.center()});
    stack_.push_back({star.triangles()[k], star.ring()[k]});  // The spoke to ring_after(k).
  }
  return Run(Spread::kAllSides, kSwapsAfterMoveMax);
}

std::int32_t MetricFlipper::AroundInserted(VertexId vertex) {
  const TriangleId start = mesh_.FanStart(vertex, mesh_.vertex(vertex).triangle);
  TriangleId current = start;
  do {
    stack_.push_back({current, vertex});
    const int corner = mesh_.CornerOf(current, vertex);
    current = mesh_.triangle(current).neighbors[static_cast<std::size_t>(NextCorner(corner))];
  } while (current.valid() && current != start);
  return Run(Spread::kOppositeApex, INT32_MAX);
}

std::int32_t MetricFlipper::Within(std::span<const TriangleId> triangles, const Metric& metric) {
  inside_ = triangles;
  metric_ = &metric;
  for (const TriangleId id : triangles) {
    for (const VertexId apex : mesh_.triangle(id).vertices) stack_.push_back({id, apex});
  }
  const std::int32_t swaps = Run(Spread::kAllSides, kSwapsAfterMoveMax);
  metric_ = nullptr;
  return swaps;
}

std::int32_t MetricFlipper::Run(Spread spread, std::int32_t swaps_max) {
  std::int32_t swaps = 0;
  while (!stack_.empty()) {
    const Entry entry = stack_.back();
    stack_.pop_back();
    if (swaps >= swaps_max) continue;  // Empties the stack.
    const int corner = SwappableCorner(entry);
    if (corner < 0) continue;
    const TriangleId other =
        mesh_.triangle(entry.triangle).neighbors[static_cast<std::size_t>(corner)];
    const VertexId far =
        mesh_.triangle(other)
            .vertices[static_cast<std::size_t>(mesh_.SideTowards(other, entry.triangle))];
    edit_.SwapEdge({entry.triangle, corner});
    ++swaps;
    stack_.push_back({entry.triangle, entry.apex});
    stack_.push_back({other, entry.apex});
    if (spread == Spread::kAllSides) {
      stack_.push_back({entry.triangle, far});
      stack_.push_back({other, far});
    }
  }
  return swaps;
}

int MetricFlipper::SwappableCorner(const Entry& entry) const {
  const TriangleRecord& t = mesh_.triangle(entry.triangle);
  int corner = 0;
  while (corner < 3 && t.vertices[static_cast<std::size_t>(corner)] != entry.apex) ++corner;
  if (corner == 3) return -1;
  if (t.IsConstrained(corner) || t.frozen) return -1;
  const TriangleId other = t.neighbors[static_cast<std::size_t>(corner)];
  if (metric_ != nullptr && std::find(inside_.begin(), inside_.end(), other) == inside_.end()) {
    return -1;
  }
  const auto far = static_cast<std::size_t>(mesh_.SideTowards(other, entry.triangle));
  const VertexRecord& p = mesh_.vertex(entry.apex);
  const VertexRecord& a = mesh_.vertex(t.vertices[static_cast<std::size_t>(NextCorner(corner))]);
  const VertexRecord& b =
      mesh_.vertex(t.vertices[static_cast<std::size_t>(PreviousCorner(corner))]);
  const VertexRecord& q = mesh_.vertex(mesh_.triangle(other).vertices[far]);
  // Triangles (b, p, a) and (a, q, b): eq. 6 with x = b, y = p, z = a, w = q.
  const Metric mean =
      metric_ != nullptr ? *metric_ : 0.25 * (p.metric + a.metric + b.metric + q.metric);
  if (!WantsSwap(b.position, p.position, a.position, q.position, mean)) return -1;
  if (Orient2d(p.position, a.position, q.position) <= 0) return -1;
  if (Orient2d(q.position, b.position, p.position) <= 0) return -1;
  if (!edit_.Owns(mesh_.triangle(other).vertices[far])) return -1;
  return corner;
}

}  // namespace pliant
