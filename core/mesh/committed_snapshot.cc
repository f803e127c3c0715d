#include "core/mesh/committed_snapshot.h"

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

namespace pliant {
namespace {

/// Calls `visit(id, record)` for every element that was live at the last commit, ascending.
/// @param log    what stood there, for those that were touched since. @param now  id -> record
/// @param slots  in the array at the commit
template <class Id, class Record, class Now, class Visit>
void ForEachCommitted(const std::vector<std::pair<Id, Record>>& log, std::int32_t slots,
                      const Now& now, const Visit& visit) {
  std::vector<const std::pair<Id, Record>*> sorted;
  sorted.reserve(log.size());
  for (const auto& entry : log) sorted.push_back(&entry);
  std::sort(sorted.begin(), sorted.end(),
            [](const auto* a, const auto* b) { return a->first < b->first; });
  std::size_t next = 0;
  for (std::int32_t i = 0; i < slots; ++i) {
    const bool touched = next < sorted.size() && sorted[next]->first == Id(i);
    const Record& record = touched ? sorted[next++]->second : now(Id(i));
    if (record.live) visit(Id(i), record);
  }
}

}  // namespace

MeshDiff CommittedSnapshot(const MeshEdit& edit, Revision revision) {
  const Mesh& mesh = edit.mesh();
  const ChangeLog& log = edit.log();
  MeshDiff diff;
  diff.revision = revision;
  diff.summary = edit.summary();
  ForEachCommitted(
      log.vertices, log.vertex_slots,
      [&](VertexId id) -> const VertexRecord& { return mesh.vertex(id); },
      [&](VertexId id, const VertexRecord& vertex) {
        diff.vertex_ids.push_back(id);
        diff.vertex_positions.push_back(vertex.position);
        diff.metric_vertex_ids.push_back(id);
        diff.metrics.push_back(vertex.metric);
      });
  ForEachCommitted(
      log.triangles, log.triangle_slots,
      [&](TriangleId id) -> const TriangleRecord& { return mesh.triangle(id); },
      [&](TriangleId id, const TriangleRecord& triangle) {
        diff.triangle_ids.push_back(id);
        diff.triangle_vertices.push_back(CanonicalTriangle(triangle.vertices));
        diff.triangle_regions.push_back(triangle.region);
      });
  ForEachCommitted(
      log.edges, log.edge_slots, [&](EdgeId id) -> const EdgeRecord& { return mesh.edge(id); },
      [&](EdgeId id, const EdgeRecord& edge) {
        diff.edge_ids.push_back(id);
        diff.edge_vertices.push_back(edge.vertices);
        diff.edge_tags.push_back(edge.tag);
      });
  return diff;
}

}  // namespace pliant
