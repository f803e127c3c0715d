#include "core/mesh/committed_snapshot.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace pliant {
namespace {

/// Calls `visit(id, record)` for every element that was live at the last commit, ascending.
/// @param log    what stood there, for those that were touched since. @param now  id -> record
/// @param slots  in the array at the commit
template <class Id, class Record, class Now, class Visit>
void ForEachCommitted(const RecordLog<Id, Record>& log, std::int32_t slots, const Now& now,
                      const Visit& visit) {
  const std::vector<std::uint32_t> order = log.Order();
  std::size_t next = 0;
  for (std::int32_t i = 0; i < slots; ++i) {
    const bool touched = next < order.size() && log[order[next]].first == Id(i);
    const Record& record = touched ? log[order[next++]].second : now(Id(i));
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
  const auto reserve = [](std::int32_t count, auto&... columns) {
    (columns.reserve(static_cast<std::size_t>(count)), ...);
  };
  reserve(diff.summary.vertex_count, diff.vertex_ids, diff.vertex_positions, diff.metric_vertex_ids,
          diff.metrics);
  reserve(diff.summary.triangle_count, diff.triangle_ids, diff.triangle_vertices,
          diff.triangle_regions);
  reserve(diff.summary.edge_count, diff.edge_ids, diff.edge_vertices, diff.edge_tags);
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
