#include "core/transfer/transfer_rows.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace pliant {
namespace {

/// A constrained edge of the old mesh that was touched.
struct OldEdge {
  std::int32_t segment = -1;
  std::array<double, 2> parameters{};
  std::array<VertexId, 2> vertices;
};

bool IsBefore(const OldEdge& a, const OldEdge& b) {
  return std::pair(a.segment, a.parameters[0]) < std::pair(b.segment, b.parameters[0]);
}

/// True if the segment has the same ends in the same places, so that a parameter means the same
/// point.
bool IsUnmoved(const OldMesh& old, std::int32_t segment) {
  for (const auto& [cut, record] : old.log().segments) {
    if (cut == segment) return false;
  }
  const SegmentRecord& line = old.mesh().segments()[static_cast<std::size_t>(segment)];
  return SamePosition(old.mesh().position(line.a), old.position(line.a)) &&
         SamePosition(old.mesh().position(line.b), old.position(line.b));
}

std::vector<OldEdge> TouchedEdges(const OldMesh& old) {
  const auto segment_count = static_cast<std::int32_t>(old.mesh().segments().size());
  std::vector<OldEdge> edges;
  for (const auto& [id, record] : old.log().edges) {
    if (!record.live || record.segment < 0 || record.segment >= segment_count) continue;
    if (!IsUnmoved(old, record.segment)) continue;
    edges.push_back({record.segment, record.parameters, record.vertices});
  }
  std::sort(edges.begin(), edges.end(), IsBefore);
  return edges;
}

/// The row of a vertex inside a segment, if that segment's old edges are known.
std::optional<TransferRow> RowOnSegment(const Mesh& mesh, VertexId vertex,
                                        std::span<const OldEdge> edges) {
  const VertexRecord& record = mesh.vertex(vertex);
  if (!record.edge.valid() || record.fixed) return std::nullopt;
  const EdgeRecord& incoming = mesh.edge(mesh.SegmentEdges(vertex)[0]);
  const double t = incoming.parameters[1];
  const OldEdge wanted{incoming.segment, {t, t}, {}};
  const auto after = std::upper_bound(edges.begin(), edges.end(), wanted, IsBefore);
  if (after == edges.begin()) return std::nullopt;
  const OldEdge& edge = *std::prev(after);
  const auto [low, high] = edge.parameters;
  if (edge.segment != incoming.segment || !(t <= high)) return std::nullopt;
  const double share = (t - low) / (high - low);
  return MakeTransferRow({edge.vertices[0], edge.vertices[1], VertexId()}, {1 - share, share, 0});
}

}  // namespace

TransferRow MakeTransferRow(const std::array<VertexId, 3>& corners,
                            const std::array<double, 3>& weights) {
  std::array<std::size_t, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return corners[a] < corners[b]; });
  const auto largest =
      static_cast<std::size_t>(std::max_element(weights.begin(), weights.end()) - weights.begin());
  std::array<double, 3> rounded{};
  double rest = 1;
  for (std::size_t i = 0; i < 3; ++i) {
    if (i == largest) continue;
    rounded[i] = std::rint(weights[i] * 0x1p53) * 0x1p-53;
    rest -= rounded[i];
  }
  rounded[largest] = rest;

  TransferRow row;
  std::size_t used = 0;
  for (const std::size_t i : order) {
    if (rounded[i] == 0) continue;
    row.sources[used] = corners[i];
    row.weights[used++] = rounded[i];
  }
  return row;
}

TransferRows MakeTransferRows(const OldMesh& old, const TouchedRegion& region,
                              const RegionLocator& locator) {
  TransferRows result;
  result.vertex_ids = region.moved;
  result.rows.reserve(region.moved.size());
  const std::vector<OldEdge> edges = TouchedEdges(old);
  SlotMap after(region.after.vertex_ids.size());
  for (const VertexId id : region.after.vertex_ids) after.Add(id.value());

  for (const VertexId id : region.moved) {
    if (const auto row = RowOnSegment(old.mesh(), id, edges)) {
      result.rows.push_back(*row);
      continue;
    }
    const Location location = locator.Locate(old.mesh().position(id), after.Find(id.value()));
    const auto& corners = region.before.triangles[static_cast<std::size_t>(location.triangle)];
    const auto slot = [&](std::size_t i) {
      return region.before.vertex_ids[static_cast<std::size_t>(corners[i])];
    };
    result.rows.push_back(MakeTransferRow({slot(0), slot(1), slot(2)}, location.weights));
  }
  return result;
}

}  // namespace pliant
