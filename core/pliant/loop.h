#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/executor.h"
#include "core/base/rng.h"
#include "core/delaunay/metric_flip.h"
#include "core/mesh/mesh_edit.h"
#include "core/mesh/star.h"
#include "core/metric/metric_field.h"
#include "core/pliant/allowance.h"
#include "core/pliant/crowd.h"
#include "core/pliant/density.h"
#include "core/pliant/extent.h"
#include "core/pliant/mend.h"
#include "core/pliant/node_queue.h"
#include "core/pliant/options.h"
#include "core/pliant/patch.h"
#include "core/pliant/visit_audit.h"

namespace pliant {

/// Why a run of the loop ended.
enum class StopReason {
  kConverged,    ///< No node is active.
  kVisitBudget,  ///< Budget::visits_max was used up; run again to go on.
  kCancelled,    ///< Budget::cancel was set.
  kVertexLimit,  ///< Ended, but insertions were refused at Options::vertices_max.
  kVisitLimit,   ///< kPaper only: Options::visits_per_vertex_max was reached.
};

/// What the loop did, counted since it was last reset.
struct LoopCounts {
  std::int64_t visits = 0;
  std::int64_t moves = 0;
  std::int64_t insertions = 0;
  std::int64_t deletions = 0;
  std::int64_t swaps = 0;
  /// Nodes that came to rest by their age alone: spots where the metric cannot be met.
  std::int64_t cooled = 0;
  /// Nodes moved or put in and edges swapped by mending, which are also among `moves`, `insertions`
  /// and `swaps`.
  std::int64_t mended = 0;
  /// Insertions refused at Options::vertices_max.
  std::int64_t refused_at_limit = 0;
  /// Insertions refused by the InsertionAllowance.
  std::int64_t refused_by_allowance = 0;

  LoopCounts& operator+=(const LoopCounts& other);
  friend bool operator==(const LoopCounts&, const LoopCounts&) = default;
  friend LoopCounts operator+(LoopCounts a, const LoopCounts& b) { return a += b; }
};

/// How the loop runs within one update. The fields mean what Options says of theirs.
struct LoopSettings {
  double alpha = 0.3;
  double speed_threshold = 0.03;
  /// A step longer than this also wakes the neighbours; the paper's rule has one threshold.
  double neighbor_threshold = 0.03;
  std::int32_t age_cooling = 30;
  std::int32_t age_max = 80;
};

/// The settings that the options ask for: those of every update.
[[nodiscard]] LoopSettings SettingsOf(const Options& options);

/// The pliant loop: visits active nodes, one at a time; a visit moves the node, swaps edges, and
/// then deletes it or splits its largest edge. [BossenHeckbert1996, sec. 3]
///
/// Ends (Variant::kCooled) because a visit makes its node older, a new node is at least as old as
/// the node whose visit made it is then, and nodes of age Options::age_max are not visited:
/// core/README.md, "Why it ends".
///
/// *Invariants*: every triangle is positive after every visit. Active nodes of the mesh are in the
/// queue.
/// On an editor that works within a territory, nodes that it may not visit, because they or a
/// neighbour belong to another, wait aside instead: they are active, and HandOver has them.
/// *Threads*: one caller at a time.
class PliantLoop {
 public:
  PliantLoop(MeshEdit& edit, const Options& options);

  /// Begins an update: ages and hops count from zero again.
  void BeginUpdate(const LoopSettings& settings);

  /// What vertices have left behind that were carried along, until the next commit or the way back
  /// to the last.
  enum class LeftBehind {
    kNothing,
    kByBody,   ///< Or its layer: edges are split above an extent of 1.15 instead of 1.
    kByFront,  ///< Above 1.13, and rows of the lattice that end there are shortened (`kEndOfRow`),
               ///< and nodes whose metric has changed wait with short steps (`kPatientVisits`).
  };
  void Follow(LeftBehind what) { left_behind_ = what; }

  /// Wakes a node whose metric or geometry has changed: hop 0, age 0, as if it were new.
  void Wake(VertexId node);

  /// Says of a node that was woken that its metric has changed by little, so that it is looked at
  /// whether nodes are missing around it, or too many: edges that are all a little too long are
  /// each still good. Holds until the next commit or the way back to the last.
  void Drift(VertexId node);

  /// Gives every vertex the field's metric and wakes it: first those that an update has reached
  /// before, then the new ones, each in order of slot.
  /// @return false if the executor was stopped: another call goes on, and must before anything else
  /// @pre the field answers any number of threads at once
  [[nodiscard]] bool WakeAll(const MetricField& field, Executor& executor);

  /// The same for a mesh that was just refined, without a question to the field: multiplies the
  /// metric of every vertex by `growth`. It is not quite the field's, so a node's first visit asks
  /// for it, which it does anyway if the node moves.
  [[nodiscard]] bool WakeRefined(double growth, Executor& executor);

  /// Asks the field for the nodes that WakeRefined has woken and nobody has visited yet.
  void AskForUnvisited(const MetricField& field);

  /// Halves long edges in bulk where the metric has become much finer: one visit of the loop splits
  /// one edge, and a lattice that is torn open in this way takes nine visits for each new node to
  /// become one again. Where all edges of a lattice are halved at once it stays one.
  /// @param nodes  woken since BeginUpdate, because their metric changed
  /// @par Cost of what is halved, some milliseconds at most
  void HalveLongEdges(const MetricField& field, std::vector<VertexId> nodes);

  /// Takes nodes away in bulk where the metric has become much coarser, so that what was a lattice
  /// is one again, twice as wide. A visit of the loop deletes one node where it finds it too close
  /// to the others, which leaves a lattice with holes.
  /// @param nodes  woken since BeginUpdate, because their metric changed
  /// @par Cost O(nodes) and of what is deleted, some milliseconds at most
  void ThinOut(std::vector<VertexId> nodes);

  /// Visits a node again though nothing about it has changed: it starts at the age of a neighbour
  /// that an update reaches.
  void Revisit(VertexId node) { Push(node, 0); }

  /// Takes part in the update of another loop on the same mesh: the same ages, hops and settings.
  void Join(const PliantLoop& other);
  /// Takes over active nodes of another loop, to be visited in this order.
  void TakeOver(std::span<const VertexId> nodes);
  /// Gives away all active nodes: those in the queue, then those that wait aside.
  [[nodiscard]] std::vector<VertexId> HandOver();
  /// Counts what other loops did as if this one had done it.
  void Add(const LoopCounts& counts);

  /// Goes on with the end of an update, when its nodes are at rest: what they have left bad is
  /// mended, the neighbours of what was mended settle, and what that leaves bad is mended. Each
  /// call begins one of the three; Run carries it out. @return false if nothing is left to do
  /// @param executor  looks at parts of the mesh; changes nothing in the result. If it was stopped
  ///                  this has begun nothing, and another call does
  /// @pre no node is active
  bool Mend(Executor& executor);

  /// Vertices where mending has come upon what may be a trouble, since the last call.
  std::vector<VertexId> TakePoor() { return mender_.TakePoor(); }

  /// Visits nodes until none is active and none waits for mending, or the budget is used up. The
  /// result does not depend on how
  /// a run is cut into budgets.
  StopReason Run(const MetricField& field, const Budget& budget);

  /// How far the end of the update has come.
  enum class Mending { kNotBegun, kFirst, kSettling, kLast, kDone };

  /// The parts of the loop's state that the mesh does not hold, for a later Restore. Entries of the
  /// queue are copied: O(active nodes), none after convergence.
  struct State {
    Options options;
    NodeQueue queue;
    Rng rng{0};
    std::uint32_t epoch = 0;
    LoopCounts counts;
    std::int64_t visits_in_update = 0;
    LoopSettings settings;
    Mending mending = Mending::kNotBegun;
    Mender::State mender;
    InsertionAllowance allowance;
  };
  [[nodiscard]] State Save() const;
  void Restore(State state);

  [[nodiscard]] const LoopCounts& counts() const { return state_.counts; }
  void ResetCounts() {
    state_.counts = {};
    first_epoch_ = state_.epoch;
    left_behind_ = LeftBehind::kNothing;
    drifting_.clear();
  }
  /// Another number with every BeginUpdate.
  [[nodiscard]] std::uint32_t epoch() const { return state_.epoch; }
  /// Nodes waiting, an upper bound while some have died in the queue.
  [[nodiscard]] std::int64_t active_count() const {
    return static_cast<std::int64_t>(state_.queue.size() + mender_.waiting_count());
  }
  /// Works by other options from now on; those of a running update's settings count from the next.
  void SetOptions(const Options& options);
  /// Gives the queue's nodes other slots, after MeshEdit::Compact.
  void Renumber(std::span<const VertexId> new_ids);

 private:
  /// How warm a node is: thresholds and step shrink with its age, so that the last visits of a spot
  /// that cannot be met only smooth.
  struct Heat {
    double delete_below = 1;
    double delete_end_below = 1;  ///< For a node with five neighbours or less.
    double insert_above = 1;
    double alpha = 0;
  };

  /// What was woken in one part of the mesh, of all of it.
  struct AskedMetrics;
  struct GrownMetrics;
  struct Woken {
    std::vector<VertexId> old_nodes;
    std::vector<VertexId> new_nodes;
    bool done = false;
  };

  /// Has the memory fetch what the next visits read: without it a visit in a large mesh spends a
  /// fifth of its time on waiting for the first triangle.
  void PrefetchAhead(const MetricField& field) const;

  [[nodiscard]] Heat HeatOf(const VisitState& visit) const;
  [[nodiscard]] VisitState CurrentVisit(VertexId node) const;
  /// Makes a node as awake as a new one. @return true if it was not in the queue
  bool MarkAwake(VertexId node);
  /// Wakes every vertex after it was given a metric: by a copy of `giver` for each chunk of slots,
  /// which first hears of a few slots (Prepare), then of each of their live vertices (Give).
  template <class Giver>
  [[nodiscard]] bool WakeEach(Executor& executor, const Giver& giver);
  /// True in the first visit of a node whose metric is not quite the field's.
  [[nodiscard]] bool OwesQuestion(VertexId node) const {
    return refined_ && mesh_.vertex(node).visit.age == 1;
  }
  void Push(VertexId node, int hop) {
    // Mostly the node waits already.
    const VisitState& visit = mesh_.vertex(node).visit;
    if (!(visit.epoch == state_.epoch && visit.active && visit.hop <= hop)) Enter(node, hop);
  }
  void Enter(VertexId node, int hop);
  void PushRing(const Star& star, int hop);

  /// One round of HalveLongEdges. @return the new nodes, at most `count`, which are awake
  std::vector<VertexId> HalveOnce(const MetricField& field, std::span<const VertexId> nodes,
                                  std::size_t count);
  [[nodiscard]] bool IsLarge(const std::array<VertexId, 3>& corners) const;
  /// Whether this update has changed the node's metric or geometry, and not visited it yet.
  [[nodiscard]] bool IsAwakeAnew(VertexId node) const;

  class Thinning;
  /// Whether the loop may delete the node, and all its neighbours are much too close.
  [[nodiscard]] bool IsCrowded(VertexId node);

  void VisitNode(const MetricField& field, VertexId node);
  /// VisitNode under the eyes of a VisitAudit.
  void VisitAudited(const MetricField& field, VertexId node);
  /// True if the territory has the node and all its neighbours, and room for an insertion.
  [[nodiscard]] bool MayVisit(const Territory& territory, VertexId node);
  void MendNext(const MetricField& field);
  /// True for a node that is neither moved nor deleted: given, frozen, or on a surface that stays.
  [[nodiscard]] bool Stays(VertexId node) const {
    const VertexRecord& record = mesh_.vertex(node);
    return record.fixed || record.frozen || (record.edge.valid() && !options_.permissions.surface);
  }
  void VisitGiven(const MetricField& field, VertexId node, const Heat& heat);
  /// The visit of an interior node with few neighbours, by columns: the same operations as the
  /// general one in the same order, and the same bits.
  void VisitPatch(const MetricField& field, const Heat& heat);
  [[nodiscard]] bool UsesPatch(VertexId node) const;
  /// The end of a visit: deletion or insertion, and who stays active.
  void FinishVisit(const MetricField& field, const Heat& heat, double speed);
  double MovePatch(const MetricField& field, double alpha);
  /// @return metric length of the step taken, 0 if the node stayed.
  double Move(const MetricField& field, double alpha);
  /// Whether the loop follows a change of a mesh that was finished, and not the paper's rules.
  [[nodiscard]] bool IsUpdate() const {
    return edit_.committed() != Revision::kNone && options_.variant != Variant::kPaper;
  }
  /// Whether a step is so short, half of what would keep its node awake, that an update does not
  /// take it: a visit that finds nothing to do leaves every bit as it was.
  [[nodiscard]] bool IsRest(double speed) const;
  double MoveFree(const MetricField& field, Vec2 step);
  double MoveOnSegment(const MetricField& field, Vec2 step);
  [[nodiscard]] bool StaysPositive(Vec2 center) const;
  void RefreshMetric(const MetricField& field, VertexId node);
  /// The end of a visit, but for who stays active: the center is deleted or an edge split, if the
  /// extents of the center and of its largest spoke ask for it. @return true if the center is gone
  bool ChangeNodes(const MetricField& field, double extent, const SpokeExtent& longest,
                   const Heat& heat);
  /// Deletes the star's center if its extent asks for it. @return true if it is gone.
  bool TryDelete(double extent, const Heat& heat);
  bool Delete();
  /// Splits the star's largest spoke if its extent asks for it. @return true if it did.
  bool TryInsert(const MetricField& field, const SpokeExtent& longest, const Heat& heat);
  bool Insert(const MetricField& field, std::size_t spoke);
  /// Splits the spoke if constraints let it.
  void InsertIfFree(const MetricField& field, std::size_t spoke);

  /// Whether the center of a visit goes by the density around it, not by its extents alone.
  [[nodiscard]] bool Drifts(VertexId node) const;
  /// ChangeNodes for such a center.
  bool EvenOut(const MetricField& field, double extent, const SpokeExtent& longest,
               const Heat& heat);
  bool EvenOutOnSegment(const MetricField& field, double extent, const SpokeExtent& longest,
                        const Heat& heat);
  /// The end of a move: who is to be visited (again) because the node moved. The star is that of
  /// the node, as it is now.
  void StayActive(double speed);
  void NotifyRing(double speed);
  void AddDrift(VertexId node, Vec2 step);
  /// Restores the Delaunay criterion around the star. @return true if the star is out of date.
  bool Swap();

  MeshEdit& edit_;
  const Mesh& mesh_;
  Options options_;
  MetricFlipper flipper_;
  Mender mender_;
  Star star_;
  Patch patch_;
  Crowd crowd_;  // Of a general visit.
  State state_;
  DensityProbe probe_;
  LeftBehind left_behind_ = LeftBehind::kNothing;  // Not in the state: a commit ends it.
  std::vector<bool> drifting_;                     // By slot, as far as there are any. Likewise.
  std::uint32_t first_epoch_ = 0;  // Nodes reached since the last commit have this or a later one.
  VisitAudit audit_;               // Idle unless kValidateEvery.
  std::vector<VertexId> aside_;
  std::vector<Woken> waking_;  // Empty unless waking all was stopped.
  bool refined_ = false;       // Since BeginUpdate: WakeRefined has woken the nodes.
};

}  // namespace pliant
