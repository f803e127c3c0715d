#include "core/mesh/star.h"

#include <algorithm>

namespace pliant {

std::vector<TriangleId> FansOf(const Mesh& mesh, VertexId vertex) {
  const VertexRecord& record = mesh.vertex(vertex);
  if (!record.pinched) return {record.triangle};
  // Every fan of a pinched vertex begins and ends with a constrained edge of it.
  std::vector<TriangleId> fans;
  for (EdgeId id = record.edge; id.valid();) {
    const EdgeRecord& edge = mesh.edge(id);
    const TriangleId start = mesh.FanStart(vertex, edge.triangle);
    if (std::find(fans.begin(), fans.end(), start) == fans.end()) fans.push_back(start);
    id = edge.next[edge.vertices[0] == vertex ? 0 : 1];
  }
  return fans;
}

}  // namespace pliant
