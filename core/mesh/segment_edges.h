#pragma once

#include "core/base/check.h"
#include "core/mesh/mesh.h"

namespace pliant {

/// Calls visit(edge) for every constrained edge at a vertex.
template <class Visit>
void ForEachEdgeAt(const Mesh& mesh, VertexId vertex, Visit visit) {
  for (EdgeId id = mesh.vertex(vertex).edge; id.valid();) {
    const EdgeRecord& edge = mesh.edge(id);
    const EdgeId next = edge.next[edge.vertices[0] == vertex ? 0 : 1];
    visit(id);
    id = next;
  }
}

/// The edge of a segment that begins at a vertex; none if there is none.
inline EdgeId EdgeFrom(const Mesh& mesh, std::int32_t segment, VertexId vertex) {
  EdgeId found;
  ForEachEdgeAt(mesh, vertex, [&](EdgeId id) {
    const EdgeRecord& edge = mesh.edge(id);
    if (edge.segment == segment && edge.vertices[0] == vertex) found = id;
  });
  return found;
}

/// Calls visit(edge) for every edge of a segment, from its beginning on. @pre it is a line
template <class Visit>
void ForEachPiece(const Mesh& mesh, std::int32_t segment, Visit visit) {
  const SegmentRecord& line = mesh.segments()[static_cast<std::size_t>(segment)];
  for (VertexId at = line.a; at != line.b;) {
    const EdgeId next = EdgeFrom(mesh, segment, at);
    PLIANT_CHECK(next.valid(), "segment", segment, "vertex", at);
    at = mesh.edge(next).vertices[1];
    visit(next);
  }
}

/// Calls visit(vertex, t) for every vertex inside a segment, from its beginning on.
template <class Visit>
void ForEachInside(const Mesh& mesh, std::int32_t segment, Visit visit) {
  VertexId at = mesh.segments()[static_cast<std::size_t>(segment)].a;
  const VertexId end = mesh.segments()[static_cast<std::size_t>(segment)].b;
  for (;;) {
    const EdgeId next = EdgeFrom(mesh, segment, at);
    PLIANT_CHECK(next.valid(), "segment", segment, "vertex", at);
    at = mesh.edge(next).vertices[1];
    if (at == end) return;
    visit(at, mesh.edge(next).parameters[1]);
  }
}

}  // namespace pliant
