// PliantLoop, the part that halves edges in bulk where a metric has become much finer.

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "core/metric/metric.h"
#include "core/pliant/insert.h"
#include "core/pliant/loop.h"

namespace pliant {
namespace {

/// Triangles whose sides are all longer than this are halved on all sides: the halves are long
/// enough to stay. Where the size falls in one direction alone, halving gains nothing.
constexpr double kHalvedLength = 1.6;

/// Edges that one call halves at most: some milliseconds. The loop splits the others.
constexpr std::size_t kHalvedMax = std::size_t{1} << 14;

/// A size that falls by more than 2^kHalvingRounds is left to the loop in the end.
constexpr int kHalvingRounds = 6;

}  // namespace

void PliantLoop::HalveLongEdges(const MetricField& field, std::vector<VertexId> nodes) {
  if (options_.variant == Variant::kPaper || !(options_.permissions == Permissions{})) return;
  std::size_t left = kHalvedMax;
  for (int round = 0; round < kHalvingRounds && left > 0; ++round) {
    const std::vector<VertexId> made = HalveOnce(field, nodes, left);
    if (made.empty()) return;
    left -= made.size();
    nodes.insert(nodes.end(), made.begin(), made.end());
  }
}

std::vector<VertexId> PliantLoop::HalveOnce(const MetricField& field,
                                            std::span<const VertexId> nodes, std::size_t count) {
  // All are chosen before the first is halved: they are edges of one triangulation, and its
  // triangles get the shape of their parents.
  std::vector<std::pair<VertexId, VertexId>> edges;
  for (const VertexId node : nodes) {
    const VertexRecord& record = mesh_.vertex(node);
    if (!record.live || record.pinched) continue;
    star_.Gather(mesh_, node);
    for (const TriangleId id : star_.triangles()) {
      const auto& v = mesh_.triangle(id).vertices;
      // Of several corners that are asked, the lowest looks at a triangle.
      const bool is_first = std::ranges::all_of(
          v, [&](VertexId corner) { return corner >= node || !IsAwakeAnew(corner); });
      if (!is_first || !IsLarge(v)) continue;
      for (std::size_t i = 0; i < 3; ++i) edges.push_back(std::minmax(v[i], v[(i + 1) % 3]));
    }
  }
  std::ranges::sort(edges);
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  std::vector<VertexId> made;
  for (const auto& [node, other] : edges) {
    if (made.size() >= count || mesh_.vertex_count() >= options_.vertices_max) break;
    star_.Gather(mesh_, node);
    const auto spoke =
        static_cast<std::size_t>(std::ranges::find(star_.ring(), other) - star_.ring().begin());
    if (spoke == star_.ring().size()) continue;  // In another fan of a pinched node.
    if (!MaySplit(mesh_, star_, spoke, options_.permissions)) continue;
    if (!state_.allowance.Take(mesh_)) break;
    const std::optional<Insertion> half =
        InsertOnSpoke(edit_, flipper_, field, star_, spoke, AfterInsertion::kLeaveEdges);
    if (half) made.push_back(half->vertex);
  }
  state_.counts.insertions += std::ssize(made);
  for (const VertexId node : made) {
    state_.counts.swaps += flipper_.AroundInserted(node);
    Wake(node);
  }
  return made;
}

bool PliantLoop::IsLarge(const std::array<VertexId, 3>& corners) const {
  for (std::size_t i = 0; i < 3; ++i) {
    const VertexRecord& a = mesh_.vertex(corners[i]);
    const VertexRecord& b = mesh_.vertex(corners[(i + 1) % 3]);
    const double squared = SquaredEdgeLength(a, b);
    if (!(squared > kHalvedLength * kHalvedLength)) return false;
  }
  return true;
}

bool PliantLoop::IsAwakeAnew(VertexId node) const {
  const VisitState& visit = mesh_.vertex(node).visit;
  return visit.epoch == state_.epoch && visit.active && visit.hop == 0;
}

}  // namespace pliant
