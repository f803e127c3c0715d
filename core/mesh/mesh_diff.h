#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/base/executor.h"
#include "core/base/ids.h"
#include "core/geometry/vec2.h"
#include "core/mesh/diff_values.h"
#include "core/mesh/mesh.h"
#include "core/metric/metric.h"

namespace pliant {

/// Counts of live elements and their hash: what a replica compares after every diff.
struct MeshSummary {
  std::int32_t vertex_count = 0;
  std::int32_t triangle_count = 0;
  std::int32_t edge_count = 0;
  /// Sum modulo 2^64 of ElementHash over all live elements: independent of order, so that it can
  /// be kept up to date by adding what came and subtracting what went.
  std::uint64_t state_hash = 0;

  friend bool operator==(const MeshSummary&, const MeshSummary&) = default;
};

/// Strong 64-bit mixes of an element's kind, slot and contents (positions by their bits). The
/// definition is part of the protocol: proto/README.md restates it for other languages.
[[nodiscard]] std::uint64_t VertexHash(VertexId id, Vec2 position);
[[nodiscard]] std::uint64_t TriangleHash(TriangleId id, const std::array<VertexId, 3>& vertices,
                                         std::int32_t region);
[[nodiscard]] std::uint64_t EdgeHash(EdgeId id, const std::array<VertexId, 2>& vertices,
                                     std::int32_t tag);

/// The three corners turned so that the smallest slot comes first: the form in which triangles
/// leave the core. The orientation stays.
[[nodiscard]] std::array<VertexId, 3> CanonicalTriangle(const std::array<VertexId, 3>& vertices);

/// What takes the mesh of revision `base_revision` to that of `revision`.
///
/// Plain columns in ascending order of slot; what was created and destroyed in between is absent,
/// and so is what ended as it began. Remove first, then write the upserts.
struct MeshDiff {
  Revision base_revision = Revision::kNone;
  Revision revision = Revision::kNone;

  std::vector<VertexId> removed_vertices;
  std::vector<TriangleId> removed_triangles;
  std::vector<EdgeId> removed_edges;

  std::vector<VertexId> vertex_ids;  ///< New or moved.
  std::vector<Vec2> vertex_positions;
  std::vector<TriangleId> triangle_ids;                    ///< New or other corners or region.
  std::vector<std::array<VertexId, 3>> triangle_vertices;  ///< Canonical, see above.
  std::vector<std::int32_t> triangle_regions;
  std::vector<EdgeId> edge_ids;                        ///< New or other ends or tag.
  std::vector<std::array<VertexId, 2>> edge_vertices;  ///< In the direction of their segment.
  std::vector<std::int32_t> edge_tags;

  /// Of the written ids, those that were not live at `base_revision`; left empty where that is
  /// kNone and every id is such a one. For whoever merges diffs; they do not travel.
  std::vector<VertexId> created_vertices;
  std::vector<TriangleId> created_triangles;
  std::vector<EdgeId> created_edges;

  /// Vertices whose metric changed (a superset of the new ones), with it.
  std::vector<VertexId> metric_vertex_ids;
  std::vector<Metric> metrics;

  /// Carries nodal values from `base_revision` to `revision`; absent where it was not asked for,
  /// and in a diff over several revisions, whose rows would have more than three sources.
  std::optional<TransferRows> transfer = std::nullopt;
  /// Of the session's fields.
  FieldChanges fields = {};

  /// Of the mesh at `revision`.
  MeshSummary summary;

  /// True if no vertex, triangle or edge differs. Metrics and fields may.
  [[nodiscard]] bool empty() const {
    return removed_vertices.empty() && removed_triangles.empty() && removed_edges.empty() &&
           vertex_ids.empty() && triangle_ids.empty() && edge_ids.empty();
  }
};

/// The whole mesh as a diff from nothing (base_revision 0): snapshots and GetMesh.
/// @par Cost O(mesh)
[[nodiscard]] MeshDiff SnapshotOf(const Mesh& mesh, Revision revision);
/// The same, with an executor to work on parts of the mesh.
[[nodiscard]] MeshDiff SnapshotOf(const Mesh& mesh, Revision revision, Executor& executor);

}  // namespace pliant
