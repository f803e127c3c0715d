#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/mesh/mesh_diff.h"

namespace pliant::server {

/// The part of a session's mesh that a subscriber has asked for, followed from revision to
/// revision: whole diffs go in, diffs of the part come out, whose counts and hash are the part's,
/// so that its mirror can prove them like those of a whole mesh.
///
/// A triangle is in view if its region is; a vertex if it is a corner of one that is; a constrained
/// edge if both its ends are.
///
/// *Invariants*: after Reset, and after each Follow that gave a diff, it is at that revision.
/// *Threads*: one caller at a time. *Memory*: about 60 bytes a vertex of the whole mesh.
class MeshView {
 public:
  struct Spec {
    std::vector<std::int32_t> region_tags = {};  ///< Ascending, none twice; empty: all regions.
    bool only_vertices = false;                  ///< Neither triangles nor edges are told.
    /// Metric or fields are told, too: what comes into view must come with its values.
    bool with_values = false;
  };
  explicit MeshView(Spec spec) : spec_(std::move(spec)), tag_uses_(spec_.region_tags.size()) {}

  /// Begins anew with the whole mesh (a diff from nothing); what is in view of it.
  MeshDiff Reset(const MeshDiff& snapshot);

  /// Takes the diff to the next revision. Nothing if it does not tell all about what comes into
  /// view, because that was there before, out of view; then Reset has to be next.
  /// @pre diff.base_revision is where the view is @par Cost O(diff), and O(constrained edges) where
  /// vertices come into view or leave it
  std::optional<MeshDiff> Follow(const MeshDiff& diff);

  /// Those of Spec::region_tags that no triangle has. @par Cost O(tags)
  [[nodiscard]] std::vector<std::int32_t> AbsentTags() const;

 private:
  struct TriangleRow {
    std::array<VertexId, 3> vertices;
    std::int32_t region = 0;
    bool in_view = false;
  };
  struct EdgeRow {
    std::array<VertexId, 2> vertices;
    std::int32_t tag = 0;
    std::uint64_t hash = 0;  // While it is in view.
    bool live = false;
    bool in_view = false;
  };
  struct Touched {
    VertexId id;
    bool was_in_view = false;
  };

  [[nodiscard]] bool Wants(std::int32_t region) const;
  /// Of a region that is wanted, by tag; null if all are.
  std::int64_t* UsesOf(std::int32_t region);
  [[nodiscard]] bool InView(VertexId id) const {
    return id.index() < uses_.size() && uses_[id.index()] > 0;
  }
  void Grow(const MeshDiff& diff);
  [[nodiscard]] std::vector<Touched> TouchedBy(const MeshDiff& diff) const;
  bool Leave(TriangleId id);
  bool TakeTriangles(const MeshDiff& diff, MeshDiff& seen);
  bool TakeVertices(const MeshDiff& diff, std::span<const Touched> touched, MeshDiff& seen);
  void TakeEdges(const MeshDiff& diff, bool vertices_changed, MeshDiff& seen);
  void TakeValues(const MeshDiff& diff, MeshDiff& seen) const;

  Spec spec_;
  std::vector<std::int64_t> tag_uses_;        // By place in Spec::region_tags: triangles in view.
  std::vector<std::int32_t> uses_;            // By vertex: triangles in view that have it.
  std::vector<std::uint64_t> vertex_hashes_;  // Of vertices in view.
  std::vector<TriangleRow> triangles_;
  std::vector<EdgeRow> edges_;
  MeshSummary summary_;  // Of what is in view.
};

}  // namespace pliant::server
