#include "core/mesh/mesh.h"

namespace pliant {

Vec2 Mesh::PointOnSegment(std::int32_t segment, double t) const {
  const SegmentRecord& line = segments_[static_cast<std::size_t>(segment)];
  const Vec2 a = position(line.a);
  const Vec2 b = position(line.b);
  if (t == 1) return b;  // a + (b - a) need not round to b.
  return a + t * (b - a);
}

EdgeId Mesh::FindEdge(VertexId a, VertexId b) const {
  for (EdgeId id = vertex(a).edge; id.valid();) {
    const EdgeRecord& record = edge(id);
    const std::size_t end = record.vertices[0] == a ? 0 : 1;
    if (record.vertices[1 - end] == b) return id;
    id = record.next[end];
  }
  return EdgeId();
}

std::array<EdgeId, 2> Mesh::SegmentEdges(VertexId vertex_id) const {
  const EdgeId first = vertex(vertex_id).edge;
  PLIANT_CHECK(first.valid(), "vertex", vertex_id);
  const std::size_t end = edge(first).vertices[0] == vertex_id ? 0 : 1;
  const EdgeId second = edge(first).next[end];
  PLIANT_CHECK(second.valid(), "vertex", vertex_id);
  return end == 1 ? std::array{first, second} : std::array{second, first};
}

TriangleId Mesh::FanStart(VertexId vertex_id, TriangleId start) const {
  if (!vertex(vertex_id).edge.valid()) return start;  // Only a boundary opens a fan.
  TriangleId current = start;
  for (;;) {
    // Side (vertex, next corner) lies opposite the previous corner.
    const int corner = CornerOf(current, vertex_id);
    const TriangleId clockwise =
        triangle(current).neighbors[static_cast<std::size_t>(PreviousCorner(corner))];
    if (!clockwise.valid()) return current;
    if (clockwise == start) return start;
    current = clockwise;
  }
}

}  // namespace pliant
