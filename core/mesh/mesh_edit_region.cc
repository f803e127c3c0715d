// MeshEdit, the part that lets a mesh cover another part of the plane.

#include <algorithm>
#include <utility>
#include <vector>

#include "core/mesh/mesh_edit.h"

namespace pliant {
namespace {

template <class Side>
bool GoesBefore(const Side& a, const Side& b) {
  return std::pair(a.from, a.to) < std::pair(b.from, b.to);
}

template <class Side>
std::vector<Side> Sorted(std::span<const Side> sides) {
  std::vector<Side> sorted(sides.begin(), sides.end());
  std::sort(sorted.begin(), sorted.end(), GoesBefore<Side>);
  return sorted;
}

/// The side of a sorted list with these ends; null if there is none.
template <class Side>
const Side* Find(const std::vector<Side>& sorted, VertexId from, VertexId to) {
  Side wanted;
  wanted.from = from;
  wanted.to = to;
  const auto at = std::lower_bound(sorted.begin(), sorted.end(), wanted, GoesBefore<Side>);
  return at != sorted.end() && at->from == from && at->to == to ? &*at : nullptr;
}

/// The side of a triangle that runs from one vertex to another; -1 if it has none.
int SideFrom(const TriangleRecord& triangle, VertexId from, VertexId to) {
  for (int side = 0; side < 3; ++side) {
    if (triangle.vertices[static_cast<std::size_t>(NextCorner(side))] == from &&
        triangle.vertices[static_cast<std::size_t>(PreviousCorner(side))] == to) {
      return side;
    }
  }
  return -1;
}

void MarkConstrained(TriangleRecord& record, int side, bool constrained) {
  const auto bit = 1U << side;
  record.constrained =
      static_cast<std::uint8_t>(constrained ? record.constrained | bit : record.constrained & ~bit);
}

}  // namespace

VertexId MeshEdit::AddVertex(Vec2 position) {
  const VertexId id = TakeVertex();
  TouchVertex(id).position = position;
  return id;
}

void MeshEdit::Unfix(VertexId vertex) {
  if (mesh_.vertex(vertex).fixed) TouchVertex(vertex).fixed = false;
}

std::vector<std::int32_t> MeshEdit::ReplaceSegments(std::span<const std::int32_t> removed,
                                                    std::span<const SegmentRecord> added) {
  std::vector<SegmentRecord>& segments = mesh_.segments_;
  std::vector<bool> logged = LoggedSegments();
  for (const std::int32_t index : removed) {
    LogSegment(index, logged);
    segments[static_cast<std::size_t>(index)] = {};
  }
  std::vector<std::int32_t> places;
  std::size_t next = 0;
  for (const SegmentRecord& record : added) {
    while (next < segments.size() && segments[next].a.valid()) ++next;
    if (next == segments.size()) segments.emplace_back();
    places.push_back(static_cast<std::int32_t>(next));
    LogSegment(places.back(), logged);
    segments[next] = record;
  }
  return places;
}

EdgeId MeshEdit::AddEdge(const NewEdge& edge) {
  edges_ahead_ = true;
  const EdgeId id = TakeEdge();
  EdgeRecord& record = TouchEdge(id);
  record.vertices = edge.vertices;
  record.parameters = edge.parameters;
  record.tag = edge.tag;
  record.segment = edge.segment;
  LinkEdge(id);
  return id;
}

void MeshEdit::RemoveEdge(EdgeId id) {
  edges_ahead_ = true;
  const EdgeRecord edge = mesh_.edge(id);
  const TriangleRecord& at = mesh_.triangle(edge.triangle);
  const auto [a, b] = edge.vertices;
  const int side = std::max(SideFrom(at, a, b), SideFrom(at, b, a));
  PLIANT_CHECK(side >= 0, "edge", id, "triangle", edge.triangle);
  const TriangleId beyond = at.neighbors[static_cast<std::size_t>(side)];
  MarkConstrained(TouchTriangle(edge.triangle), side, false);
  if (beyond.valid()) {
    MarkConstrained(TouchTriangle(beyond), mesh_.SideTowards(beyond, edge.triangle), false);
  }
  UnlinkEdge(id, a);
  UnlinkEdge(id, b);
  FreeEdge(id);
}

void MeshEdit::SetEdge(EdgeId id, const NewEdge& now) {
  EdgeRecord& record = TouchEdge(id);
  if (record.vertices != now.vertices) {
    PLIANT_CHECK(record.vertices[0] == now.vertices[1] && record.vertices[1] == now.vertices[0],
                 "edge", id);
    std::swap(record.vertices[0], record.vertices[1]);
    std::swap(record.next[0], record.next[1]);
  }
  record.parameters = now.parameters;
  record.tag = now.tag;
  record.segment = now.segment;
}

bool MeshEdit::ReplaceRegion(std::span<const TriangleId> gone,
                             std::span<const NewTriangle> triangles, const StopSignal* stop) {
  StopPoll stopped(stop);
  IdBits<TriangleId> gone_bits(mesh_.triangle_slots());
  for (const TriangleId id : gone) gone_bits.Add(id);
  const std::vector<OuterSide> outer = OuterSidesOf(gone, gone_bits, stopped);
  const std::vector<VertexId> corners = CornersOf(gone, triangles, stopped).Ascending();

  const std::size_t reused = std::min(gone.size(), triangles.size());
  for (std::size_t i = gone.size(); i > reused && !stopped(); --i) FreeTriangle(gone[i - 1]);
  edges_ahead_ = false;
  if (stopped()) return false;
  const std::vector<TriangleId> slots = FillSlots(gone.first(reused), triangles);
  LinkRegion(gone_bits, OpenSidesOf(slots), outer);
  for (const OuterSide& side : outer) {
    if (!side.beyond.valid()) continue;
    PointVerticesAt(side.beyond);
    PointEdgesAt(side.beyond);
  }
  for (const TriangleId id : slots) {
    PointVerticesAt(id);
    PointEdgesAt(id);
  }
  for (const VertexId vertex : corners) {
    if (stopped()) return false;
    SettleCorner(vertex);
  }
  CheckAfter(slots);
  return true;
}

/// The sides of a region that others will have to do with; not all of them once it is stopped.
std::vector<MeshEdit::OuterSide> MeshEdit::OuterSidesOf(std::span<const TriangleId> gone,
                                                        const IdBits<TriangleId>& gone_bits,
                                                        StopPoll& stopped) const {
  std::vector<OuterSide> sides;
  for (const TriangleId id : gone) {
    if (stopped()) break;
    const TriangleRecord& record = mesh_.triangle(id);
    for (int side = 0; side < 3; ++side) {
      const auto k = static_cast<std::size_t>(side);
      const TriangleId beyond = record.neighbors[k];
      const bool inner = gone_bits.Has(beyond);
      const bool constrained = record.IsConstrained(k);
      if (inner && !constrained) continue;
      sides.push_back({record.vertices[static_cast<std::size_t>(NextCorner(side))],
                       record.vertices[static_cast<std::size_t>(PreviousCorner(side))],
                       inner ? TriangleId() : beyond, constrained});
    }
  }
  return sides;
}

/// The corners of what goes and of what comes; not all of them once it is stopped.
IdBits<VertexId> MeshEdit::CornersOf(std::span<const TriangleId> gone,
                                     std::span<const NewTriangle> triangles,
                                     StopPoll& stopped) const {
  IdBits<VertexId> corners(mesh_.vertex_slots());
  for (const TriangleId id : gone) {
    if (stopped()) break;
    for (const VertexId vertex : mesh_.triangle(id).vertices) corners.Add(vertex);
  }
  for (const NewTriangle& triangle : triangles) {
    for (const VertexId vertex : triangle.vertices) corners.Add(vertex);
  }
  return corners;
}

void MeshEdit::LinkRegion(const IdBits<TriangleId>& gone, std::span<const OpenSide> open,
                          std::span<const OuterSide> outer) {
  const std::vector<OpenSide> open_at = Sorted(open);
  std::vector<OuterSide> outer_at = Sorted(outer);
  std::erase_if(outer_at, [](const OuterSide& side) { return !side.beyond.valid(); });
  for (const OpenSide& side : open) {
    if (const OuterSide* old = Find(outer_at, side.from, side.to)) {
      LinkAcross(side, old->beyond);
    } else if (const OpenSide* twin = Find(open_at, side.to, side.from)) {
      LinkAcross(side, twin->triangle);
    } else {
      const EdgeId edge = mesh_.FindEdge(side.from, side.to);
      PLIANT_CHECK(edge.valid(), "from", side.from, "to", side.to);
      const TriangleId behind = mesh_.edge(edge).triangle;
      // A triangle that stays has no neighbour across the edge yet.
      const bool stays = behind.valid() && mesh_.triangle(behind).live && !gone.Has(behind) &&
                         SideFrom(mesh_.triangle(behind), side.to, side.from) >= 0;
      LinkAcross(side, stays ? behind : TriangleId());
    }
  }
  for (const OuterSide& side : outer_at) {
    if (Find(open_at, side.from, side.to) != nullptr) continue;
    const int across = SideFrom(mesh_.triangle(side.beyond), side.to, side.from);
    PLIANT_CHECK(mesh_.FindEdge(side.from, side.to).valid(), "from", side.from, "to", side.to);
    TriangleRecord& stays = TouchTriangle(side.beyond);
    stays.neighbors[static_cast<std::size_t>(across)] = TriangleId();
    MarkConstrained(stays, across, true);
  }
}

/// Makes a new side and a neighbour, if there is one, know each other and their edge.
void MeshEdit::LinkAcross(const OpenSide& side, TriangleId neighbor) {
  const bool constrained = mesh_.FindEdge(side.from, side.to).valid();
  TriangleRecord& record = TouchTriangle(side.triangle);
  record.neighbors[static_cast<std::size_t>(side.side)] = neighbor;
  MarkConstrained(record, side.side, constrained);
  if (!neighbor.valid()) return;
  const int across = SideFrom(mesh_.triangle(neighbor), side.to, side.from);
  PLIANT_CHECK(across >= 0, "triangle", side.triangle, "neighbor", neighbor);
  TriangleRecord& other = TouchTriangle(neighbor);
  other.neighbors[static_cast<std::size_t>(across)] = side.triangle;
  MarkConstrained(other, across, constrained);
}

/// Gives a vertex a triangle that has it, where there is one, and counts the fans at it: each has
/// two sides with nothing beyond, unless there is one fan only.
void MeshEdit::SettleCorner(VertexId vertex) {
  const TriangleId named = mesh_.vertex(vertex).triangle;
  const auto has = [&](TriangleId id) {
    return id.valid() && mesh_.triangle(id).live && mesh_.triangle(id).HasCorner(vertex);
  };
  bool found = has(named);
  int open_count = 0;
  for (EdgeId id = mesh_.vertex(vertex).edge; id.valid();) {
    const EdgeRecord& edge = mesh_.edge(id);
    const TriangleId at = edge.triangle;
    if (has(at)) {
      if (!found) TouchVertex(vertex).triangle = at;
      found = true;
      const auto& corners = mesh_.triangle(at);
      const int side = std::max(SideFrom(corners, edge.vertices[0], edge.vertices[1]),
                                SideFrom(corners, edge.vertices[1], edge.vertices[0]));
      if (side >= 0 && !corners.neighbors[static_cast<std::size_t>(side)].valid()) ++open_count;
    }
    id = edge.next[edge.vertices[0] == vertex ? 0 : 1];
  }
  const bool pinched = open_count > 2;
  if (mesh_.vertex(vertex).pinched != pinched) TouchVertex(vertex).pinched = pinched;
}

}  // namespace pliant
