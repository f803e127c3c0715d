#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/geometry/mesh_data.h"
#include "core/geometry/vec2.h"
#include "core/mesh/mesh_diff.h"
#include "core/metric/metric.h"

namespace pliant::client {

/// A mesh with dense numbers 0..n-1, in ascending order of slot, and the maps between both.
struct CompactMesh {
  MeshData mesh;
  /// Metric at each point; empty if the replica does not know it at every vertex.
  std::vector<Metric> metrics;

  std::vector<VertexId> vertex_ids;      ///< Slot of each point.
  std::vector<TriangleId> triangle_ids;  ///< Slot of each triangle.
  std::vector<EdgeId> edge_ids;          ///< Slot of each constrained edge.

  std::vector<std::int32_t> vertex_indices;    ///< By slot: number of the point; -1 if free.
  std::vector<std::int32_t> triangle_indices;  ///< By slot, likewise.
  std::vector<std::int32_t> edge_indices;      ///< By slot, likewise.
};

/// The client's copy of a session's mesh: plain arrays by slot that follow the server diff by diff.
///
/// Every diff is checked in full before anything is written: that it starts at this revision, that
/// it removes what lives and names vertices that live, that no element is left with a corner that
/// is removed, and that counts and hash of the result are the server's. So a replica that says
/// revision r holds the mesh of revision r, bit for bit.
///
/// *Invariants*: summary() is that of the arrays; corners and ends of live elements are live.
/// *Threads*: one writer or any number of readers.
class MeshReplica {
 public:
  /// Goes from diff.base_revision to diff.revision. A diff from 0 (a snapshot) is only taken by an
  /// empty replica; see Reset.
  ///
  /// Fails with kReplicaMismatch, a message that says what differs, and leaves the replica as it
  /// was; `field` is one of "base_revision", "removed_vertices", "vertex_ids" and so on, "counts"
  /// or "state_hash". The way out is a snapshot (Session::Resync).
  /// @par Cost O(diff)
  [[nodiscard]] Status Apply(const MeshDiff& diff);

  /// Replaces everything by a snapshot (a diff from revision 0). Fails like Apply.
  [[nodiscard]] Status Reset(const MeshDiff& snapshot);

  [[nodiscard]] Revision revision() const { return revision_; }
  [[nodiscard]] const MeshSummary& summary() const { return summary_; }

  /// By slot; what free slots hold means nothing.
  [[nodiscard]] std::span<const Vec2> positions() const { return vertices_.rows; }
  [[nodiscard]] std::span<const std::array<VertexId, 3>> triangles() const {
    return triangles_.rows;
  }
  [[nodiscard]] std::span<const std::int32_t> triangle_regions() const { return triangles_.tags; }
  [[nodiscard]] std::span<const std::array<VertexId, 2>> edges() const { return edges_.rows; }
  [[nodiscard]] std::span<const std::int32_t> edge_tags() const { return edges_.tags; }

  [[nodiscard]] bool IsLive(VertexId id) const { return vertices_.IsLive(id.value()); }
  [[nodiscard]] bool IsLive(TriangleId id) const { return triangles_.IsLive(id.value()); }
  [[nodiscard]] bool IsLive(EdgeId id) const { return edges_.IsLive(id.value()); }

  /// The metric that came with the diffs; nothing keeps it for a session that was opened without
  /// metrics. @pre IsLive(id)
  [[nodiscard]] const Metric& metric(VertexId id) const { return metrics_[id.index()]; }
  [[nodiscard]] bool HasMetric(VertexId id) const {
    return id.index() < metric_known_.size() && metric_known_[id.index()] != 0;
  }

  /// The live elements with dense numbers. @par Cost O(mesh)
  [[nodiscard]] CompactMesh Compact() const;

 private:
  /// Elements of one kind by slot.
  template <class Row>
  struct Slots {
    std::vector<Row> rows;
    std::vector<std::int32_t> tags;  ///< Unused for vertices.
    std::vector<std::uint8_t> live;

    [[nodiscard]] bool IsLive(std::int32_t slot) const {
      return slot >= 0 && static_cast<std::size_t>(slot) < live.size() &&
             live[static_cast<std::size_t>(slot)] != 0;
    }
    void Write(std::size_t slot, const Row& row, std::int32_t tag);
  };

  /// What a diff would do to the counts and the hash. Assumes that its lists are sound.
  [[nodiscard]] MeshSummary SummaryAfter(const MeshDiff& diff) const;
  [[nodiscard]] Status CheckLists(const MeshDiff& diff) const;
  void MarkLiveAfter(const MeshDiff& diff);
  void UnmarkLiveAfter(const MeshDiff& diff);
  [[nodiscard]] Status CheckSound(const MeshDiff& diff) const;
  [[nodiscard]] Status CheckReferences(const MeshDiff& diff) const;
  [[nodiscard]] Status CountUses(const MeshDiff& diff);
  void AddUses(const MeshDiff& diff, std::int32_t sign);
  void Write(const MeshDiff& diff);

  Revision revision_ = Revision::kNone;
  MeshSummary summary_;
  Slots<Vec2> vertices_;
  Slots<std::array<VertexId, 3>> triangles_;
  Slots<std::array<VertexId, 2>> edges_;
  /// Vertices that live, and while a diff is checked those that will, if it is taken.
  std::vector<std::uint8_t> live_after_;
  /// By slot of a vertex: how many corners and ends of live elements it is.
  std::vector<std::int32_t> uses_;
  std::vector<Metric> metrics_;
  std::vector<std::uint8_t> metric_known_;
};

/// True if both hold the same revision, slots and contents, bit for bit; metrics are not compared.
[[nodiscard]] bool SameMesh(const MeshReplica& a, const MeshReplica& b);

}  // namespace pliant::client
