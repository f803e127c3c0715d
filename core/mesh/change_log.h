#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/ids.h"
#include "core/mesh/mesh.h"
#include "core/mesh/record_log.h"

namespace pliant {

/// The state at the last commit of everything that changed since: what a diff is folded from and a
/// rollback restores. MeshEdit writes it, once per element and revision.
struct ChangeLog {
  /// Slots in order of first touch with their records before it (live = false for new slots).
  RecordLog<VertexId, VertexRecord> vertices;
  RecordLog<TriangleId, TriangleRecord> triangles;
  RecordLog<EdgeId, EdgeRecord> edges;
  /// Segments that were cut, by index.
  std::vector<std::pair<std::int32_t, SegmentRecord>> segments;

  /// Slots in the arrays at the last commit.
  std::int32_t vertex_slots = 0;
  std::int32_t triangle_slots = 0;
  std::int32_t edge_slots = 0;
  std::int32_t segment_slots = 0;

  [[nodiscard]] bool empty() const {
    return vertices.empty() && triangles.empty() && edges.empty() && segments.empty();
  }
};

}  // namespace pliant
