#include "core/mesh/export_mesh.h"

#include "core/mesh/mesh_diff.h"

namespace pliant {

ExportedMesh ExportMesh(const Mesh& mesh) {
  ExportedMesh out;
  std::vector<std::int32_t> dense(static_cast<std::size_t>(mesh.vertex_slots()), -1);
  for (std::int32_t v = 0; v < mesh.vertex_slots(); ++v) {
    const VertexRecord& vertex = mesh.vertex(VertexId(v));
    if (!vertex.live) continue;
    dense[static_cast<std::size_t>(v)] = static_cast<std::int32_t>(out.data.points.size());
    out.data.points.push_back(vertex.position);
    out.vertex_ids.emplace_back(v);
  }
  for (std::int32_t t = 0; t < mesh.triangle_slots(); ++t) {
    const TriangleRecord& triangle = mesh.triangle(TriangleId(t));
    if (!triangle.live) continue;
    const auto [a, b, c] = CanonicalTriangle(triangle.vertices);
    out.data.triangles.push_back({dense[a.index()], dense[b.index()], dense[c.index()]});
    out.data.triangle_tags.push_back(triangle.region);
    out.triangle_ids.emplace_back(t);
  }
  for (std::int32_t e = 0; e < mesh.edge_slots(); ++e) {
    const EdgeRecord& edge = mesh.edge(EdgeId(e));
    if (!edge.live) continue;
    out.data.edges.push_back({dense[edge.vertices[0].index()], dense[edge.vertices[1].index()]});
    out.data.edge_tags.push_back(edge.tag);
    out.edge_ids.emplace_back(e);
  }
  return out;
}

}  // namespace pliant
