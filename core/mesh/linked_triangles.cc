#include "core/mesh/linked_triangles.h"

#include "core/mesh/mesh_diff.h"

namespace pliant {

MeshTriangles LinkTriangles(const Mesh& mesh, const StopSignal* stop) {
  MeshTriangles out;
  LinkedTriangles& linked = out.linked;
  StopPoll stopped(stop);
  std::vector<std::int32_t> dense(static_cast<std::size_t>(mesh.vertex_slots()), -1);
  linked.points.reserve(static_cast<std::size_t>(mesh.vertex_count()));
  for (std::int32_t v = 0; v < mesh.vertex_slots() && !stopped(); ++v) {
    const VertexRecord& vertex = mesh.vertex(VertexId(v));
    if (!vertex.live) continue;
    dense[static_cast<std::size_t>(v)] = static_cast<std::int32_t>(linked.points.size());
    linked.points.push_back(vertex.position);
  }
  out.rank_of.resize(static_cast<std::size_t>(mesh.triangle_slots()), -1);
  std::int32_t count = 0;
  for (std::int32_t t = 0; t < mesh.triangle_slots() && !stopped(); ++t) {
    if (mesh.triangle(TriangleId(t)).live) out.rank_of[static_cast<std::size_t>(t)] = count++;
  }
  linked.triangles.reserve(static_cast<std::size_t>(count));
  for (std::int32_t t = 0; t < mesh.triangle_slots() && !stopped(); ++t) {
    const TriangleRecord& triangle = mesh.triangle(TriangleId(t));
    if (!triangle.live) continue;
    const auto corners = CanonicalTriangle(triangle.vertices);
    std::size_t from = 0;
    while (triangle.vertices[from] != corners[0]) ++from;
    TriangleLinks links;
    for (std::size_t k = 0; k < 3; ++k) {
      links.corners[k] = dense[corners[k].index()];
      const TriangleId neighbor = triangle.neighbors[(from + k) % 3];
      links.neighbors[k] = neighbor.valid() ? out.rank_of[neighbor.index()] : -1;
    }
    linked.triangles.push_back(links);
  }
  return out;
}

}  // namespace pliant
