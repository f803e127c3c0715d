#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/executor.h"
#include "core/base/ids.h"
#include "core/base/stop_signal.h"
#include "core/geometry/vec2.h"
#include "core/mesh/change_log.h"
#include "core/mesh/id_bits.h"
#include "core/mesh/mesh.h"
#include "core/mesh/mesh_delta.h"
#include "core/mesh/mesh_diff.h"
#include "core/mesh/star.h"
#include "core/mesh/territory.h"
#include "core/mesh/validate_local.h"
#include "core/metric/metric.h"

namespace pliant {

/// A triangle to be made: corners counter-clockwise, and its region.
struct NewTriangle {
  std::array<VertexId, 3> vertices;
  std::int32_t region = 0;
};

/// An edge of the mesh seen from one of its triangles.
struct Side {
  TriangleId triangle;
  int corner = 0;  ///< The corner opposite the edge.
};

/// A new vertex in the middle of an edge.
struct EdgeSplit {
  Side side;  ///< The edge, from the one of its triangles that has the lower slot.
  Vec2 position;
  double t = 0;  ///< Parameter on the segment, for a constrained edge.
};

/// A constrained edge of a mesh that is being set up.
struct NewEdge {
  std::array<VertexId, 2> vertices;
  std::array<double, 2> parameters{};
  std::int32_t tag = 0;
  std::int32_t segment = -1;
};

/// Numbers of slots.
struct SlotCounts {
  std::int32_t vertices = 0;
  std::int32_t triangles = 0;
  std::int32_t edges = 0;
};

/// The one way to change a mesh. Keeps connectivity, edge lists and slots consistent and writes the
/// change log; does not judge geometry: callers test orientation first.
///
/// *Invariants*: after every call the mesh is consistent in everything but orientation; between
/// commits the log holds each touched element's state at the last commit. Before the first commit
/// nothing is logged, because there is nothing to go back to.
/// *Threads*: one caller at a time; between LendSlots and ReturnSlots, one for each territory.
class MeshEdit {
 public:
  explicit MeshEdit(Mesh& mesh) : mesh_(mesh) {}

  /// One of several that change the same mesh at the same time, each within its territory, which
  /// must have slots lent by LendSlots and outlive this. Neither logs nor commits.
  MeshEdit(Mesh& mesh, Territory& territory) : mesh_(mesh), territory_(&territory) {}

  /// Prepares for writers beside each other: each of the territories gets this many slots of its
  /// own. @pre nothing was committed
  void LendSlots(std::span<Territory> territories, const SlotCounts& counts);
  /// Brings the counts of live elements up to date while slots are lent and no writer is at work.
  void CountLent(std::span<Territory> territories);
  /// Ends what LendSlots began. Slots that nobody took are free from now on.
  void ReturnSlots(std::span<Territory> territories);

  /// True if this may change edges at the vertex: always, but within a territory.
  [[nodiscard]] bool Owns(VertexId vertex) const {
    return territory_ == nullptr || territory_->Owns(vertex);
  }
  /// The territory that this works within; null if it may change everything.
  [[nodiscard]] const Territory* territory() const { return territory_; }
  /// The mesh, for another editor of it.
  [[nodiscard]] Mesh& mesh_to_share() { return mesh_; }

  /// Sets up a mesh from nothing: vertices with their positions, triangles with corners and
  /// regions, constrained edges, segments. Finds neighbours and pinched vertices; Fix must follow
  /// for every vertex that has constrained edges other than two of one segment.
  /// @pre the mesh is empty; the arrays describe a conforming triangulation
  void Build(std::span<const Vec2> positions, std::span<const NewTriangle> triangles,
             std::span<const NewEdge> edges, std::span<const SegmentRecord> segments);

  /// Marks a vertex as given: the loop neither moves nor deletes it.
  void Fix(VertexId vertex);

  /// Whether a constraint keeps an element. Who freezes a triangle freezes its corners and its
  /// constrained edges too, who freezes an edge its ends.
  enum class Hold { kFree, kFrozen };
  void SetHold(VertexId vertex, Hold hold) { TouchVertex(vertex).frozen = hold == Hold::kFrozen; }
  void SetHold(EdgeId edge, Hold hold) { TouchEdge(edge).frozen = hold == Hold::kFrozen; }
  void SetHold(TriangleId id, Hold hold) { TouchTriangle(id).frozen = hold == Hold::kFrozen; }

  void MoveVertex(VertexId vertex, Vec2 position) {
    TouchVertex(vertex).position = position;
    CheckAfter(vertex);
  }
  /// The same as one of many that move together: triangles are looked at when all are in place.
  void PlaceVertex(VertexId vertex, Vec2 position);
  /// Moves a vertex along its segment to parameter t, and to the segment's point there.
  /// @pre it has exactly two constrained edges, of one segment, and t lies between their far ends
  void SlideVertex(VertexId vertex, double t);
  /// Writes down another parameter of a vertex inside a segment, and leaves it where it is: for
  /// motions of a whole segment, which put every vertex of it in its place.
  void SetParameter(VertexId vertex, double t);
  void SetMetric(VertexId vertex, const Metric& metric) { TouchVertex(vertex).metric = metric; }
  /// Writable state of the loop. The reference is valid until the next call that adds vertices.
  VisitState& Visit(VertexId vertex) { return TouchVertex(vertex).visit; }
  /// Writable without a trace in the log: hints never decide anything.
  std::int32_t& Hint(VertexId vertex) { return mesh_.hints_[vertex.index()]; }

  /// Replaces the diagonal `side` of its two triangles by the other one. Both slots stay in use.
  /// @pre the side has a neighbour and is not constrained
  void SwapEdge(Side side);

  /// Puts a new vertex on an edge; splits its one or two triangles and, if it is constrained, the
  /// constrained edge, at parameter `t` of its segment. @return the new vertex
  VertexId SplitEdge(Side side, Vec2 position, double t);

  /// Splits many edges at once, by templates: a triangle with three split sides becomes four, with
  /// two three (by the shorter diagonal in the metric), with one two. Everything is numbered anew,
  /// so that neighbours have near slots: triangles in the given order of their parents, children
  /// together; vertices in the order in which triangles have them, but for the fixed ones, which
  /// come first, in their old order. A new vertex has the geometric mean of the metrics at the ends
  /// of its edge.
  /// @param order  the live triangles, each once. @pre nothing was committed; all children are
  /// positive. @par Cost O(mesh)
  void Refine(std::span<const EdgeSplit> splits, std::span<const TriangleId> order);
  /// The same, with an executor to work on parts of the mesh; it changes nothing in the result.
  /// @return false if the executor was stopped: then nothing has changed
  [[nodiscard]] bool Refine(std::span<const EdgeSplit> splits, std::span<const TriangleId> order,
                            Executor& executor);

  /// Replaces the triangles of a cavity by others that cover the same polygon. Vertices that lose
  /// their last triangle must be removed by RemoveVertex.
  /// @pre new sides without partner are sides of the cavity or constrained edges
  void ReplaceCavity(std::span<const TriangleId> cavity, std::span<const NewTriangle> triangles);

  /// Does what ReplaceCavity does, in the time of a few look-ups, for the closed star of a vertex
  /// without constrained edges: `ears` were cut off the polygon of its ring one after the other,
  /// each as (corner before, tip, corner after), and the last is what was left.
  void ReplaceStar(const Star& star, std::span<const NewTriangle> ears);

  /// Frees a vertex that no triangle and no constrained edge uses.
  void RemoveVertex(VertexId vertex);

  /// Merges the two constrained edges at a vertex inside a segment into one. The triangles still
  /// have the vertex: ReplaceCavity must follow. @return the edge that is left
  EdgeId MergeEdges(VertexId vertex);

  /// Lets a vertex split a constrained edge, at parameter t. The triangles still have the whole
  /// edge: ReplaceCavity must follow.
  void SplitConstrainedEdge(EdgeId edge, VertexId vertex, double t);

  /// Makes vertices inside segments given points: their segments end there and new ones go on, in
  /// free places, lowest first. @par Cost O(segments of the mesh + edges of those that are cut)
  void CutSegments(std::span<const VertexId> vertices);
  void CutSegment(VertexId vertex) { CutSegments({&vertex, 1}); }

  /// What a new domain needs (mesh_edit_region.cc): in this order edges and segments go and come,
  /// ReplaceRegion follows, then vertices without triangles are removed.
  ///
  /// A new vertex. It has no triangle yet, and no metric.
  VertexId AddVertex(Vec2 position);
  /// Takes Fix back: the loop may move and delete the vertex.
  void Unfix(VertexId vertex);
  /// Frees the places of some segments and gives such places, lowest first, to new ones.
  /// @return the places of `added` @par Cost O(segments of the mesh)
  std::vector<std::int32_t> ReplaceSegments(std::span<const std::int32_t> removed,
                                            std::span<const SegmentRecord> added);
  /// A new constrained edge; triangles that have it as a side must follow.
  EdgeId AddEdge(const NewEdge& edge);
  /// Makes a constrained edge a side like others, or one of none.
  void RemoveEdge(EdgeId edge);
  /// Makes a constrained edge a piece of another segment. @pre it has the same two ends
  void SetEdge(EdgeId edge, const NewEdge& now);
  void SetRegion(TriangleId id, std::int32_t region) { TouchTriangle(id).region = region; }
  /// Replaces triangles by others that need not cover the same part of the plane. Sides of `gone`
  /// that get no new triangle, and new sides without a partner, must be constrained edges. A new
  /// side on a constrained edge that had nothing there becomes the neighbour of what lies behind.
  /// Finds out again which of the vertices concerned are pinched.
  /// @param stop  not owned; null: nobody
  /// @return false if it was stopped: then the mesh is not consistent, and Undo or Rollback must
  ///         follow
  /// @par Cost O(k + m log m + slots / 64) for k triangles that go and m that come
  [[nodiscard]] bool ReplaceRegion(std::span<const TriangleId> gone,
                                   std::span<const NewTriangle> triangles,
                                   const StopSignal* stop = nullptr);

  /// What MeshEdit::Undo goes back to. Holds a copy of the free slots.
  struct Trial {
    ChangeLog outer;  ///< What the revision had changed before.
    SlotAllocator vertices;
    SlotAllocator triangles;
    SlotAllocator edges;
  };
  /// Begins changes that are kept or undone as a whole, within a revision or before the first.
  /// Keep or Undo must follow before the next BeginTrial, Commit or Rollback.
  /// @par Cost O(changed in this revision so far + free slots); Keep and Undo cost in addition what
  ///           the trial changed.
  [[nodiscard]] Trial BeginTrial();
  void Keep(Trial trial);
  void Undo(Trial trial);

  /// Ends a revision: folds the log into a diff, empties it and logs from now on.
  MeshDiff Commit(Revision revision);
  /// The same, with an executor to work on parts of a first revision.
  MeshDiff Commit(Revision revision, Executor& executor);
  /// Takes every touched element back to its state at the last commit.
  /// @pre there was a commit
  void Rollback();

  /// What takes the mesh from the last commit back to the one before it: the log that the commit
  /// folded. Can be taken once, until the next commit; nothing after a first commit or a Restore.
  /// @par Cost O(changed)
  std::optional<MeshDelta> TakeUndo();
  /// What takes the mesh back to what it is now from where `delta` leads.
  /// @pre nothing changed since the last commit
  [[nodiscard]] MeshDelta InverseOf(const MeshDelta& delta) const;
  /// Whether a delta leads from this mesh, and to one with the counts and the hash that it names.
  [[nodiscard]] bool Fits(const MeshDelta& delta) const;
  /// Writes the records of a delta and commits them as `revision`. Hints stay, or are none.
  /// @pre Fits(delta); nothing changed since the last commit @par Cost O(delta)
  MeshDiff Apply(const MeshDelta& delta, Revision revision);
  /// Sets up a mesh as it was at a commit. @pre the mesh is empty
  void Restore(MeshState state, Revision revision);
  /// Renumbers live elements to 0..n-1 in order of slot. @return new slots by old vertex slot, none
  /// for the dead. @pre nothing was committed yet
  std::vector<VertexId> Compact();
  /// The same, with an executor to work on parts of the mesh; it changes nothing in the result.
  std::vector<VertexId> Compact(Executor& executor);

  [[nodiscard]] const ChangeLog& log() const { return log_; }
  /// Of the last commit; kNone before the first, when the log does not know what has changed.
  [[nodiscard]] Revision committed() const { return committed_; }
  /// Of the last commit.
  [[nodiscard]] const MeshSummary& summary() const { return summary_; }
  [[nodiscard]] const Mesh& mesh() const { return mesh_; }

 private:
  /// Writable records; the first call in a revision logs what stood there.
  VertexRecord& TouchVertex(VertexId id) {
    VertexRecord& record = mesh_.vertices_[id.index()];
    if (logging() && !record.touched) {
      log_.vertices.Add(id, record, mesh_.vertices_.size());
      record.touched = true;
    }
    return record;
  }
  TriangleRecord& TouchTriangle(TriangleId id) {
    TriangleRecord& record = mesh_.triangles_[id.index()];
    if (logging() && !record.touched) {
      log_.triangles.Add(id, record, mesh_.triangles_.size());
      record.touched = true;
    }
    return record;
  }
  EdgeRecord& TouchEdge(EdgeId id) {
    EdgeRecord& record = mesh_.edges_[id.index()];
    if (logging() && !record.touched) {
      log_.edges.Add(id, record, mesh_.edges_.size());
      record.touched = true;
    }
    return record;
  }
  [[nodiscard]] SlotAllocator& vertex_allocator() {
    return territory_ == nullptr ? mesh_.vertex_allocator_ : territory_->slots.vertices;
  }
  [[nodiscard]] SlotAllocator& triangle_allocator() {
    return territory_ == nullptr ? mesh_.triangle_allocator_ : territory_->slots.triangles;
  }
  [[nodiscard]] SlotAllocator& edge_allocator() {
    return territory_ == nullptr ? mesh_.edge_allocator_ : territory_->slots.edges;
  }
  [[nodiscard]] bool logging() const { return committed_ != Revision::kNone || in_trial_; }
  VertexId TakeVertex();
  TriangleId TakeTriangle();
  EdgeId TakeEdge();
  void FreeTriangle(TriangleId id);
  void FreeEdge(EdgeId id);

  /// A side of a cavity: what lies beyond it, and whether it is a constrained edge.
  struct OuterSide {
    VertexId from;
    VertexId to;
    TriangleId beyond;
    bool constrained = false;
  };
  /// A side of a new triangle that waits for its neighbour.
  struct OpenSide {
    VertexId from;
    VertexId to;
    TriangleId triangle;
    int side = 0;
  };
  /// A side of a polygon that ears are cut off: what lies beyond it, and the side of that which is
  /// this one.
  struct RimSide {
    VertexId from;
    TriangleId beyond;
    int side = 0;
    bool constrained = false;
  };
  void GatherRim(const Star& star);
  void LinkToRim(TriangleId id, int side, const RimSide& rim);
  [[nodiscard]] std::vector<OuterSide> OuterSidesOf(std::span<const TriangleId> cavity) const;
  void LinkSides(std::span<const OpenSide> open, std::span<const OuterSide> outer);
  /// Gives triangles their slots: those of `gone`, then new ones; frees what is left.
  std::vector<TriangleId> FillSlots(std::span<const TriangleId> gone,
                                    std::span<const NewTriangle> triangles);
  [[nodiscard]] std::vector<OpenSide> OpenSidesOf(std::span<const TriangleId> triangles) const;
  [[nodiscard]] std::vector<OuterSide> OuterSidesOf(std::span<const TriangleId> gone,
                                                    const IdBits<TriangleId>& gone_bits,
                                                    StopPoll& stopped) const;
  [[nodiscard]] IdBits<VertexId> CornersOf(std::span<const TriangleId> gone,
                                           std::span<const NewTriangle> triangles,
                                           StopPoll& stopped) const;
  void LinkRegion(const IdBits<TriangleId>& gone, std::span<const OpenSide> open,
                  std::span<const OuterSide> outer);
  void LinkAcross(const OpenSide& side, TriangleId neighbor);
  void SettleCorner(VertexId vertex);
  /// By index: whether the log has, or needs, no record of a segment.
  [[nodiscard]] std::vector<bool> LoggedSegments() const;
  void LogSegment(std::int32_t index, std::vector<bool>& logged);
  void CutSegment(VertexId vertex, std::int32_t rest);

  /// The check after an operation, unless a constrained edge was changed whose triangles are about
  /// to follow by ReplaceCavity.
  template <class Touched>
  void CheckAfter(const Touched& touched) const {
    if constexpr (kValidateEvery) {
      if (!edges_ahead_) CheckOperation(mesh_, touched);
    }
  }

  void LinkEdge(EdgeId id);
  void UnlinkEdge(EdgeId id, VertexId vertex);
  void SetNeighbor(TriangleId triangle, TriangleId from, TriangleId to);
  void PointEdgesAt(TriangleId id);
  void PointVerticesAt(TriangleId id);

  void MarkPinched();
  MeshDiff FirstCommit(Revision revision, Executor& executor);
  void StartLog(Revision revision);
  void RestoreSegments();
  void WriteSegments(const SegmentsAt& segments);
  void FoldVertices(MeshDiff& diff);
  void FoldTriangles(MeshDiff& diff);
  void FoldEdges(MeshDiff& diff);

  Mesh& mesh_;
  Territory* territory_ = nullptr;
  ChangeLog log_;
  MeshSummary summary_;
  // Of the last commit, until it is taken or the next one: its log, sorted, and what was before.
  ChangeLog folded_;
  MeshSummary folded_summary_;
  bool has_folded_ = false;
  Revision committed_ = Revision::kNone;
  bool edges_ahead_ = false;  // Of their triangles: see CheckAfter.
  bool in_trial_ = false;
  std::vector<RimSide> rim_;  // Of ReplaceStar, kept for its memory.
};

}  // namespace pliant
