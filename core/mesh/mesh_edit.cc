#include "core/mesh/mesh_edit.h"

#include <algorithm>
#include <utility>

namespace pliant {
namespace {

constexpr std::int32_t kNoHint = -1;

/// Up to this many triangles or sides, looking through all of them is fastest.
constexpr std::size_t kFewTriangles = 32;

constexpr std::uint8_t Bit(int side) { return static_cast<std::uint8_t>(1U << side); }

VertexId& At(std::array<VertexId, 3>& values, int index) {
  return values[static_cast<std::size_t>(index)];
}
VertexId At(const std::array<VertexId, 3>& values, int index) {
  return values[static_cast<std::size_t>(index)];
}
TriangleId& At(std::array<TriangleId, 3>& values, int index) {
  return values[static_cast<std::size_t>(index)];
}
TriangleId At(const std::array<TriangleId, 3>& values, int index) {
  return values[static_cast<std::size_t>(index)];
}

/// Constrained bits of three sides, in order.
std::uint8_t Bits(bool side0, bool side1, bool side2) {
  return static_cast<std::uint8_t>((side0 ? 1 : 0) | (side1 ? 2 : 0) | (side2 ? 4 : 0));
}

/// Empties a record and gives its slot back.
template <class Record>
void Bury(Record& record, std::int32_t slot, SlotAllocator& allocator) {
  Record dead;
  dead.touched = record.touched;
  dead.committed = record.committed;
  record = dead;
  if (dead.committed) {
    allocator.Park(slot);
  } else {
    allocator.Free(slot);
  }
}

/// Finds directed sides by their ends: of few by looking through them, of many in a sorted table.
template <class Side>
class SideTable {
 public:
  explicit SideTable(std::span<const Side> sides) : sides_(sides) {
    if (sides.size() <= kFewTriangles) return;
    for (const Side& side : sides) sorted_.push_back(&side);
    std::sort(sorted_.begin(), sorted_.end(), [](const Side* a, const Side* b) {
      return std::pair(a->from, a->to) < std::pair(b->from, b->to);
    });
  }

  /// The side with these ends; null if there is none.
  [[nodiscard]] const Side* Find(VertexId from, VertexId to) const {
    if (sorted_.empty()) {
      const auto at = std::find_if(sides_.begin(), sides_.end(), [&](const Side& side) {
        return side.from == from && side.to == to;
      });
      return at == sides_.end() ? nullptr : &*at;
    }
    const auto at =
        std::lower_bound(sorted_.begin(), sorted_.end(), std::pair(from, to),
                         [](const Side* side, const std::pair<VertexId, VertexId>& ends) {
                           return std::pair(side->from, side->to) < ends;
                         });
    const bool found = at != sorted_.end() && (*at)->from == from && (*at)->to == to;
    return found ? *at : nullptr;
  }

 private:
  std::span<const Side> sides_;
  std::vector<const Side*> sorted_;
};

}  // namespace

void MeshEdit::Fix(VertexId vertex) {
  if (!mesh_.vertex(vertex).fixed) TouchVertex(vertex).fixed = true;
}

void MeshEdit::SlideVertex(VertexId vertex, double t) {
  const auto [before, after] = mesh_.SegmentEdges(vertex);
  PLIANT_DCHECK(mesh_.edge(before).segment == mesh_.edge(after).segment, "vertex", vertex);
  PLIANT_DCHECK(mesh_.edge(before).parameters[0] < t && t < mesh_.edge(after).parameters[1],
                "vertex", vertex, "t", t);
  TouchEdge(before).parameters[1] = t;
  TouchEdge(after).parameters[0] = t;
  TouchVertex(vertex).position = mesh_.PointOnSegment(mesh_.edge(before).segment, t);
  CheckAfter(vertex);
}

void MeshEdit::SwapEdge(Side side) {
  const int i = side.corner;
  const TriangleId t_id = side.triangle;
  const TriangleId u_id = At(mesh_.triangle(t_id).neighbors, i);
  PLIANT_DCHECK(u_id.valid() && !mesh_.triangle(t_id).IsConstrained(i), "triangle", t_id);
  const int j = mesh_.SideTowards(u_id, t_id);
  TriangleRecord& t = TouchTriangle(t_id);
  TriangleRecord& u = TouchTriangle(u_id);

  // t = (p, a, b) and u = (q, b, a) become t = (p, a, q) and u = (q, b, p).
  const int i1 = NextCorner(i);
  const int i2 = PreviousCorner(i);
  const int j1 = NextCorner(j);
  const int j2 = PreviousCorner(j);
  const VertexId p = At(t.vertices, i);
  const VertexId a = At(t.vertices, i1);
  const VertexId b = At(t.vertices, i2);
  const VertexId q = At(u.vertices, j);
  const TriangleId beyond_bp = At(t.neighbors, i1);
  const TriangleId beyond_aq = At(u.neighbors, j1);
  const bool bp = t.IsConstrained(i1);
  const bool pa = t.IsConstrained(i2);
  const bool aq = u.IsConstrained(j1);
  const bool qb = u.IsConstrained(j2);

  At(t.vertices, i2) = q;
  At(t.neighbors, i) = beyond_aq;
  At(t.neighbors, i1) = u_id;
  t.constrained = static_cast<std::uint8_t>((aq ? Bit(i) : 0) | (pa ? Bit(i2) : 0));
  At(u.vertices, j2) = p;
  At(u.neighbors, j) = beyond_bp;
  At(u.neighbors, j1) = t_id;
  u.constrained = static_cast<std::uint8_t>((bp ? Bit(j) : 0) | (qb ? Bit(j2) : 0));

  SetNeighbor(beyond_aq, u_id, t_id);
  SetNeighbor(beyond_bp, t_id, u_id);
  if (mesh_.vertex(a).triangle == u_id) TouchVertex(a).triangle = t_id;
  if (mesh_.vertex(b).triangle == t_id) TouchVertex(b).triangle = u_id;
  if (t.constrained != 0) PointEdgesAt(t_id);
  if (u.constrained != 0) PointEdgesAt(u_id);
  CheckAfter(std::array{t_id, u_id});
}

VertexId MeshEdit::SplitEdge(Side side, Vec2 position, double t_on_segment) {
  const VertexId m = TakeVertex();
  TouchVertex(m).position = position;

  const TriangleId t_id = side.triangle;
  const int i = side.corner;
  const TriangleRecord t = mesh_.triangle(t_id);  // Copies: the arrays may grow below.
  const VertexId p = At(t.vertices, i);
  const VertexId a = At(t.vertices, NextCorner(i));
  const VertexId b = At(t.vertices, PreviousCorner(i));
  const bool constrained = t.IsConstrained(i);
  if (constrained) SplitConstrainedEdge(mesh_.FindEdge(a, b), m, t_on_segment);

  // (p, a, b) becomes (p, a, m) and (p, m, b); likewise (q, b, a) behind the edge.
  const TriangleId u_id = At(t.neighbors, i);
  const TriangleId t2_id = TakeTriangle();
  const TriangleId u2_id = u_id.valid() ? TakeTriangle() : TriangleId();
  const bool pa = t.IsConstrained(PreviousCorner(i));
  const bool bp = t.IsConstrained(NextCorner(i));
  const TriangleId beyond_pa = At(t.neighbors, PreviousCorner(i));
  const TriangleId beyond_bp = At(t.neighbors, NextCorner(i));
  {
    TriangleRecord& first = TouchTriangle(t_id);
    first.vertices = {p, a, m};
    first.neighbors = {u2_id, t2_id, beyond_pa};
    first.constrained = Bits(constrained, false, pa);
    TriangleRecord& second = TouchTriangle(t2_id);
    second.vertices = {p, m, b};
    second.neighbors = {u_id, beyond_bp, t_id};
    second.constrained = Bits(constrained, bp, false);
    second.region = t.region;
  }
  SetNeighbor(beyond_bp, t_id, t2_id);
  if (u_id.valid()) {
    const TriangleRecord u = mesh_.triangle(u_id);
    const int j = mesh_.SideTowards(u_id, t_id);
    const VertexId q = At(u.vertices, j);
    const TriangleId beyond_qb = At(u.neighbors, PreviousCorner(j));
    const TriangleId beyond_aq = At(u.neighbors, NextCorner(j));
    TriangleRecord& first = TouchTriangle(u_id);
    first.vertices = {q, b, m};
    first.neighbors = {t2_id, u2_id, beyond_qb};
    first.constrained = Bits(constrained, false, u.IsConstrained(PreviousCorner(j)));
    TriangleRecord& second = TouchTriangle(u2_id);
    second.vertices = {q, m, a};
    second.neighbors = {t_id, beyond_aq, u_id};
    second.constrained = Bits(constrained, u.IsConstrained(NextCorner(j)), false);
    second.region = u.region;
    SetNeighbor(beyond_aq, u_id, u2_id);
    if (mesh_.vertex(a).triangle == u_id) TouchVertex(a).triangle = t_id;
  }
  TouchVertex(m).triangle = t_id;
  if (mesh_.vertex(b).triangle == t_id) TouchVertex(b).triangle = t2_id;
  for (const TriangleId id : {t_id, t2_id, u_id, u2_id}) {
    if (id.valid() && mesh_.triangle(id).constrained != 0) PointEdgesAt(id);
  }
  edges_ahead_ = false;
  CheckAfter(m);
  return m;
}

void MeshEdit::ReplaceCavity(std::span<const TriangleId> cavity,
                             std::span<const NewTriangle> triangles) {
  std::vector<OuterSide> outer = OuterSidesOf(cavity);
  const std::vector<TriangleId> slots = FillSlots(cavity, triangles);
  const std::vector<OpenSide> open = OpenSidesOf(slots);
  LinkSides(open, outer);
  for (const TriangleId id : slots) {
    PointVerticesAt(id);
    if (mesh_.triangle(id).constrained != 0) PointEdgesAt(id);
  }
  edges_ahead_ = false;
  CheckAfter(slots);
}

std::vector<TriangleId> MeshEdit::FillSlots(std::span<const TriangleId> gone,
                                            std::span<const NewTriangle> triangles) {
  std::vector<TriangleId> slots(gone.begin(), gone.end());
  while (slots.size() > triangles.size()) {
    FreeTriangle(slots.back());
    slots.pop_back();
  }
  while (slots.size() < triangles.size()) slots.push_back(TakeTriangle());
  for (std::size_t k = 0; k < triangles.size(); ++k) {
    TriangleRecord& record = TouchTriangle(slots[k]);
    record.vertices = triangles[k].vertices;
    record.region = triangles[k].region;
    record.neighbors = {};
    record.constrained = 0;
  }
  return slots;
}

std::vector<MeshEdit::OpenSide> MeshEdit::OpenSidesOf(std::span<const TriangleId> triangles) const {
  std::vector<OpenSide> open;
  for (const TriangleId id : triangles) {
    const auto& corners = mesh_.triangle(id).vertices;
    for (int side = 0; side < 3; ++side) {
      open.push_back({At(corners, NextCorner(side)), At(corners, PreviousCorner(side)), id, side});
    }
  }
  return open;
}

std::vector<MeshEdit::OuterSide> MeshEdit::OuterSidesOf(std::span<const TriangleId> cavity) const {
  std::vector<OuterSide> sides;
  // Few are looked through, as after a deletion; of many a sorted copy is worth its price.
  std::vector<TriangleId> sorted;
  if (cavity.size() > kFewTriangles) {
    sorted.assign(cavity.begin(), cavity.end());
    std::sort(sorted.begin(), sorted.end());
  }
  const auto is_inside = [&](TriangleId id) {
    if (sorted.empty()) return std::find(cavity.begin(), cavity.end(), id) != cavity.end();
    return std::binary_search(sorted.begin(), sorted.end(), id);
  };
  for (const TriangleId id : cavity) {
    const TriangleRecord& record = mesh_.triangle(id);
    for (int side = 0; side < 3; ++side) {
      const TriangleId beyond = At(record.neighbors, side);
      const bool inner = is_inside(beyond);
      if (inner && !record.IsConstrained(side)) continue;
      sides.push_back({At(record.vertices, NextCorner(side)),
                       At(record.vertices, PreviousCorner(side)), inner ? TriangleId() : beyond,
                       record.IsConstrained(side)});
    }
  }
  return sides;
}

void MeshEdit::LinkSides(std::span<const OpenSide> open, std::span<const OuterSide> outer) {
  const SideTable<OpenSide> open_at(open);
  const SideTable<OuterSide> outer_at(outer);
  for (const OpenSide& side : open) {
    TriangleRecord& record = TouchTriangle(side.triangle);
    const OuterSide* const old = outer_at.Find(side.from, side.to);
    if (old != nullptr && old->beyond.valid()) {
      At(record.neighbors, side.side) = old->beyond;
      // The neighbour may stand behind several sides of the cavity: find it by its corners.
      TriangleRecord& neighbor = TouchTriangle(old->beyond);
      for (int k = 0; k < 3; ++k) {
        if (At(neighbor.vertices, NextCorner(k)) == side.to &&
            At(neighbor.vertices, PreviousCorner(k)) == side.from) {
          At(neighbor.neighbors, k) = side.triangle;
        }
      }
    } else if (const OpenSide* const twin = open_at.Find(side.to, side.from); twin != nullptr) {
      At(record.neighbors, side.side) = twin->triangle;
    }
    const bool constrained =
        old != nullptr ? old->constrained : mesh_.FindEdge(side.from, side.to).valid();
    PLIANT_DCHECK(constrained || At(record.neighbors, side.side).valid(), "from", side.from, "to",
                  side.to);
    if (constrained)
      record.constrained = static_cast<std::uint8_t>(record.constrained | Bit(side.side));
  }
}

void MeshEdit::RemoveVertex(VertexId vertex) {
  PLIANT_CHECK(!mesh_.vertex(vertex).edge.valid(), "vertex", vertex);
  Bury(TouchVertex(vertex), vertex.value(), vertex_allocator());
}

void MeshEdit::FreeTriangle(TriangleId id) {
  Bury(TouchTriangle(id), id.value(), triangle_allocator());
}

void MeshEdit::FreeEdge(EdgeId id) { Bury(TouchEdge(id), id.value(), edge_allocator()); }

VertexId MeshEdit::TakeVertex() {
  const VertexId id(vertex_allocator().Take());
  if (id.index() == mesh_.vertices_.size()) {
    mesh_.vertices_.emplace_back();
    mesh_.hints_.push_back(kNoHint);
  }
  if (territory_ != nullptr) territory_->Settle(id);
  TouchVertex(id).live = true;
  return id;
}

void MeshEdit::LendSlots(std::span<Territory> territories, const SlotCounts& counts) {
  PLIANT_CHECK(!logging() && territory_ == nullptr);
  for (Territory& territory : territories) {
    territory.slots = {mesh_.vertex_allocator_.Lend(counts.vertices),
                       mesh_.triangle_allocator_.Lend(counts.triangles),
                       mesh_.edge_allocator_.Lend(counts.edges)};
  }
  mesh_.vertices_.resize(static_cast<std::size_t>(mesh_.vertex_slots()));
  mesh_.hints_.resize(mesh_.vertices_.size(), kNoHint);
  mesh_.triangles_.resize(static_cast<std::size_t>(mesh_.triangle_slots()));
  mesh_.edges_.resize(static_cast<std::size_t>(mesh_.edge_slots()));
}

void MeshEdit::CountLent(std::span<Territory> territories) {
  for (Territory& territory : territories) {
    mesh_.vertex_allocator_.CountFrom(territory.slots.vertices);
    mesh_.triangle_allocator_.CountFrom(territory.slots.triangles);
    mesh_.edge_allocator_.CountFrom(territory.slots.edges);
  }
}

void MeshEdit::ReturnSlots(std::span<Territory> territories) {
  for (Territory& territory : territories) {
    mesh_.vertex_allocator_.ReturnFrom(std::move(territory.slots.vertices));
    mesh_.triangle_allocator_.ReturnFrom(std::move(territory.slots.triangles));
    mesh_.edge_allocator_.ReturnFrom(std::move(territory.slots.edges));
  }
  mesh_.vertex_allocator_.EndLoans();
  mesh_.triangle_allocator_.EndLoans();
  mesh_.edge_allocator_.EndLoans();
}

TriangleId MeshEdit::TakeTriangle() {
  const TriangleId id(triangle_allocator().Take());
  if (id.index() == mesh_.triangles_.size()) mesh_.triangles_.emplace_back();
  TouchTriangle(id).live = true;
  return id;
}

EdgeId MeshEdit::TakeEdge() {
  const EdgeId id(edge_allocator().Take());
  if (id.index() == mesh_.edges_.size()) mesh_.edges_.emplace_back();
  TouchEdge(id).live = true;
  return id;
}

EdgeId MeshEdit::MergeEdges(VertexId vertex) {
  edges_ahead_ = true;
  const auto [before, after] = mesh_.SegmentEdges(vertex);
  const VertexId far = mesh_.edge(after).vertices[1];
  UnlinkEdge(before, vertex);
  UnlinkEdge(after, vertex);
  UnlinkEdge(after, far);
  EdgeRecord& merged = TouchEdge(before);
  merged.vertices[1] = far;
  merged.parameters[1] = mesh_.edge(after).parameters[1];
  merged.next[1] = mesh_.vertex(far).edge;
  TouchVertex(far).edge = before;
  FreeEdge(after);
  return before;
}

void MeshEdit::SplitConstrainedEdge(EdgeId edge, VertexId vertex, double t) {
  edges_ahead_ = true;
  const EdgeId rest = TakeEdge();
  const VertexId far = mesh_.edge(edge).vertices[1];
  UnlinkEdge(edge, far);
  EdgeRecord& first = TouchEdge(edge);
  EdgeRecord& second = TouchEdge(rest);
  second.vertices = {vertex, far};
  second.parameters = {t, first.parameters[1]};
  second.triangle = first.triangle;
  second.tag = first.tag;
  second.segment = first.segment;
  first.vertices[1] = vertex;
  first.parameters[1] = t;
  first.next[1] = mesh_.vertex(vertex).edge;
  TouchVertex(vertex).edge = edge;
  LinkEdge(rest);
}

void MeshEdit::LinkEdge(EdgeId id) {
  for (std::size_t end = 0; end < 2; ++end) {
    VertexRecord& vertex = TouchVertex(mesh_.edge(id).vertices[end]);
    TouchEdge(id).next[end] = vertex.edge;
    vertex.edge = id;
  }
}

void MeshEdit::UnlinkEdge(EdgeId id, VertexId vertex) {
  const auto end_at = [&](EdgeId edge) -> std::size_t {
    return mesh_.edge(edge).vertices[0] == vertex ? 0 : 1;
  };
  const EdgeId next = mesh_.edge(id).next[end_at(id)];
  if (mesh_.vertex(vertex).edge == id) {
    TouchVertex(vertex).edge = next;
    return;
  }
  EdgeId current = mesh_.vertex(vertex).edge;
  while (mesh_.edge(current).next[end_at(current)] != id) {
    current = mesh_.edge(current).next[end_at(current)];
  }
  TouchEdge(current).next[end_at(current)] = next;
}

void MeshEdit::SetNeighbor(TriangleId triangle, TriangleId from, TriangleId to) {
  if (!triangle.valid()) return;
  const int side = mesh_.SideTowards(triangle, from);
  At(TouchTriangle(triangle).neighbors, side) = to;
}

void MeshEdit::PointEdgesAt(TriangleId id) {
  const TriangleRecord& record = mesh_.triangle(id);
  for (int side = 0; side < 3; ++side) {
    if (!record.IsConstrained(side)) continue;
    const EdgeId edge = mesh_.FindEdge(At(record.vertices, NextCorner(side)),
                                       At(record.vertices, PreviousCorner(side)));
    PLIANT_CHECK(edge.valid(), "triangle", id, "side", side);
    if (mesh_.edge(edge).triangle != id) TouchEdge(edge).triangle = id;
  }
}

void MeshEdit::PointVerticesAt(TriangleId id) {
  for (const VertexId vertex : mesh_.triangle(id).vertices) {
    if (mesh_.vertex(vertex).triangle != id) TouchVertex(vertex).triangle = id;
  }
}

}  // namespace pliant
