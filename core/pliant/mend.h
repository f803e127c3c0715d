#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/base/executor.h"
#include "core/mesh/mesh_edit.h"
#include "core/mesh/star.h"
#include "core/metric/metric_field.h"
#include "core/pliant/options.h"

namespace pliant {

struct MeritCorner;

/// Cures the tail that a converged loop leaves: the few triangles that are flat, and the few edges
/// that are too long or too short, at pairs of vertices of degree 5 and 7, at corners, and where
/// the last nodes were inserted. One triangle in some hundreds.
///
/// A triangle has a merit: 1 where it is just good enough, less where it is worse,
///
///     merit = min(Q / 0.8, (1.42 / l)^2, (l / 0.65)^2)   over its edges l  (merit.h),
///
/// and a shortfall, max(0, 1.1 - merit)^4. A node at a triangle of merit below 1 is moved (on its
/// segment, if it lies on one) to where the sum of the shortfalls around it is least, by a compass
/// search; an edge is swapped where that lessens the sum over its two triangles. Triangles of merit
/// 1.1 have no say, so that good nodes stay where the loop has put them. Where given vertices are
/// crowded a node is put in if moving and swapping do not help.
///
/// Where the metric has just changed, mending asks for a merit of 1.03: what is only just good
/// enough would be bad again as soon as an update far away lets one of its nodes make a last,
/// short step, and mending would answer to a metric that did not change.
///
/// Ends: the sum of the shortfalls over the mesh is finite and not negative, and every change
/// lessens it by at least `kGainMin`; only a change makes other nodes wait. Beside crowds it is not
/// one sum: changes there are counted, and are as many as `is_worn_out` allows.
///
/// *Invariants*: every triangle is positive after every visit.
/// *Threads*: one caller at a time.
class Mender {
 public:
  Mender(MeshEdit& edit, const Permissions& permissions)
      : edit_(edit), mesh_(edit.mesh()), permissions_(permissions) {}

  /// Other permissions from now on.
  void Permit(const Permissions& permissions) { permissions_ = permissions; }
  /// The mesh may have so many vertices.
  void LimitVertices(std::int32_t vertices_max) { vertices_max_ = vertices_max; }

  /// Looks for bad triangles and lets their vertices wait for a visit: triangles with a vertex that
  /// the loop has reached, and, after the first commit, that has changed since the last one: those
  /// that were carried along as a piece of a lattice are as good as they were.
  /// @param warm_since the epoch of the update: nodes that have been visited since, and are not
  /// cold, are those whose metric has changed
  /// @param reached_since  the epoch since which nodes count as reached; 0: all
  /// @param executor  looks at parts of the mesh, or of what has changed
  /// @return false if the executor was stopped: then nobody waits who did not before
  /// @par Cost O(changed); before the first commit O(mesh)
  [[nodiscard]] bool Start(std::uint32_t warm_since, std::uint32_t reached_since,
                           Executor& executor);

  [[nodiscard]] bool done() const { return state_.next == state_.waiting.size(); }
  [[nodiscard]] std::size_t waiting_count() const { return state_.waiting.size() - state_.next; }

  /// What a visit did.
  struct Mended {
    int moves = 0;
    int swaps = 0;
    int insertions = 0;
  };
  /// Visits the first node that waits. @pre !done()
  Mended VisitNext(const MetricField& field);

  /// The nodes that were moved since the last call, ascending, each once.
  std::vector<VertexId> TakeMoved();
  /// Corners of the triangles that Start has come upon since the last call and that may be troubles
  /// (trouble.h). They may be mended by now, or dead.
  std::vector<VertexId> TakePoor() { return std::exchange(state_.poor, {}); }

  /// Nodes are visited in rounds, each in ascending order of slot: the next round has the vertices
  /// of triangles that a visit changed and that are still bad.
  struct State {
    std::uint32_t warm_since = 0;
    std::vector<VertexId> moved;  // Since the last TakeMoved.
    std::vector<VertexId> waiting;
    std::size_t next = 0;
    std::vector<VertexId> next_round;
    std::vector<VertexId> poor;  // Since the last TakePoor.
  };
  [[nodiscard]] const State& state() const { return state_; }
  void Restore(State state) { state_ = std::move(state); }
  /// Gives waiting nodes other slots, after MeshEdit::Compact.
  void Renumber(std::span<const VertexId> new_ids);

 private:
  /// Far more than a node takes to come to a place where it is good.
  static constexpr std::size_t kMovesOfNode = 8;

  /// What was found in a part of the mesh.
  struct Part {
    std::vector<VertexId> nodes;  ///< At bad triangles.
    std::vector<VertexId> poor;   ///< At those that may be troubles.
  };
  using Parts = std::vector<Part>;
  [[nodiscard]] Parts FindBad(std::uint32_t reached_since, Executor& executor) const;
  [[nodiscard]] Parts FindBadAmongChanged(std::uint32_t reached_since, Executor& executor) const;
  [[nodiscard]] bool IsReached(VertexId node, std::uint32_t since) const;
  [[nodiscard]] double MeritAt(TriangleId triangle) const;
  [[nodiscard]] bool IsBad(TriangleId triangle, double merit) const;
  [[nodiscard]] bool IsBad(TriangleId triangle) const { return IsBad(triangle, MeritAt(triangle)); }
  [[nodiscard]] bool IsWarm(VertexId node) const;
  [[nodiscard]] bool HasBadTriangle() const;
  /// True when so many nodes were moved that nothing but a circle can be the cause.
  [[nodiscard]] bool is_worn_out() const {
    return state_.moved.size() / kMovesOfNode >= static_cast<std::size_t>(mesh_.vertex_count());
  }
  [[nodiscard]] bool StaysPositive(Vec2 center) const;
  /// The ring of a closed star begins again at its end.
  [[nodiscard]] std::vector<MeritCorner> RingCorners() const;
  /// Where the shortfall around a center is less than at `start`, by a compass search.
  [[nodiscard]] static Vec2 BestPlace(std::span<const MeritCorner> ring, const MeritCorner& start);
  bool Move(const MetricField& field);
  /// Where given vertices are crowded beside the center, puts a node between it and them.
  bool Insert(const MetricField& field);
  struct Row;
  [[nodiscard]] bool IsCrowdedLink(std::span<const MeritCorner> ring, std::size_t k) const;
  [[nodiscard]] std::vector<Row> RowsAtCrowd(std::span<const MeritCorner> ring) const;
  bool InsertBeside(const Row& row, const MetricField& field);
  void PutIn(Vec2 place, std::span<const VertexId> corners, std::span<const TriangleId> cavity);
  bool Slide(const MetricField& field);
  /// The metric at a better place for the center, if it is better in that metric too.
  struct Arrival {
    bool better = false;
    Metric metric;
    std::int32_t hint = 0;
  };
  [[nodiscard]] Arrival Arrive(std::span<const MeritCorner> ring, const MetricField& field,
                               Vec2 target) const;
  bool SwapOne();
  [[nodiscard]] bool WantsSwap(Side side) const;
  void AddCornersIfBad(TriangleId triangle, Part& part) const;

  MeshEdit& edit_;
  const Mesh& mesh_;
  Permissions permissions_;
  std::int32_t vertices_max_ = INT32_MAX;
  Star star_;
  State state_;
};

}  // namespace pliant
