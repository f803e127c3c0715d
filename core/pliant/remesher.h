#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/geometry/domain.h"
#include "core/geometry/mesh_data.h"
#include "core/mesh/mesh.h"
#include "core/mesh/mesh_diff.h"
#include "core/metric/metric_spec.h"
#include "core/pliant/frozen.h"
#include "core/pliant/loop.h"
#include "core/pliant/mesh_change.h"
#include "core/pliant/metric_report.h"
#include "core/pliant/nested_build.h"
#include "core/pliant/options.h"
#include "core/pliant/quality.h"
#include "core/pliant/revision_delta.h"
#include "core/pliant/trouble.h"
#include "core/transfer/field_set.h"

namespace pliant {

/// What happened since the last commit.
struct Progress {
  StopReason stop_reason = StopReason::kConverged;
  std::int64_t active_count = 0;  ///< Nodes that still wait for a visit.
  LoopCounts counts;
  MetricReport metric = {};  ///< What limits made of the metric when they were laid last.
};

/// One persistent mesh that follows a metric: the engine of a session.
///
/// Life: Create, then Step until it has converged (or as long as wished) and Commit; after that any
/// number of: updates (SetMetric, SetTensors), Step, Commit. Nothing is visible outside between
/// commits; Rollback returns to the last commit.
///
/// *Invariants*: the mesh is a valid triangulation of the domain at every return (Validate).
/// The same calls with the same arguments give the same bits, whatever the budgets of the single
/// steps add up from.
/// *Threads*: none of its own; one caller at a time.
class Remesher {
 public:
  /// A session from a polygonal domain: its constrained Delaunay triangulation, every node active.
  /// Errors: those of TriangulateDomain, MakeMetricField and kOutOfRange for options.
  static Result<std::unique_ptr<Remesher>> Create(const Domain& domain, const MetricSpec& metric,
                                                  const Options& options);

  /// A session from an existing triangulation. Vertex and triangle i keep the numbers i as slots.
  /// Constrained edges are the given ones and every edge on the boundary or between two regions
  /// (tag 0 if not given).
  /// Vertices where constrained edges meet at an angle, change tag or branch are fixed; the others
  /// may slide along the straight line they lie on. Errors: those of ImportMesh.
  static Result<std::unique_ptr<Remesher>> Create(const MeshData& mesh, const MetricSpec& metric,
                                                  const Options& options);

  /// The same for a field of the caller's own instead of a specification.
  static Result<std::unique_ptr<Remesher>> Create(const Domain& domain,
                                                  std::unique_ptr<MetricField> field,
                                                  const Options& options);
  static Result<std::unique_ptr<Remesher>> Create(const MeshData& mesh,
                                                  std::unique_ptr<MetricField> field,
                                                  const Options& options);

  ~Remesher();
  Remesher(const Remesher&) = delete;
  Remesher& operator=(const Remesher&) = delete;

  /// Follows another metric from now on. Nodes whose tensor changes by more than
  /// Options::metric_tolerance wake. An equal specification changes nothing and costs nothing.
  /// On error everything stays as it was.
  Status SetMetric(const MetricSpec& metric);

  /// The same for a field of the caller's own; no two are ever equal.
  Status SetField(std::unique_ptr<MetricField> field);

  /// New tensors at some vertices; the others keep the tensors that they have, and in between the
  /// metric is interpolated on the mesh as it is now. With every commit, the tensors of the mesh of
  /// that moment become the metric. An empty `vertices` means all live vertices in ascending order
  /// of slot, and ends functions beside tensors (below), which else stay. Errors: kArrayLength,
  /// kIndexOutOfRange (not a live vertex), kDuplicateId, kNotFinite, kNotPositiveDefinite; index =
  /// position in the given span.
  /// @par Cost O(k + changed since the last commit); before the first commit O(mesh)
  Status SetTensors(std::span<const VertexId> vertices, std::span<const Metric> tensors);

  /// The same with other limits, which hold from now on, for the tensors of the other vertices too.
  /// Bounds that are looser than those before change only tensors that are sent from now on: what
  /// bounds have cut off is not kept. Errors: also kOutOfRange for the limits.
  /// @par Cost as above if these limits hold already, else O(mesh)
  Status SetTensors(std::span<const VertexId> vertices, std::span<const Metric> tensors,
                    const MetricLimits& limits);

  /// The same, intersected with functions of place from now on: a vertex keeps its tensor apart
  /// from what the functions have where it is, and has the finest of both in every direction,
  /// limits coming after that. Functions are asked where a vertex is, whenever it is put in or
  /// moved; the tensors are interpolated there by themselves. Later tensors at some vertices
  /// replace only their tensors. Errors: also those of MakeMetricField for each function,
  /// kExpressionValue if one has no value at a vertex, and kRevisionNotFound before the first
  /// commit.
  ///
  /// @par Cost O(mesh); if these limits and functions hold already, O(k + changed since the last
  ///           commit)
  Status SetTensors(std::span<const VertexId> vertices, std::span<const Metric> tensors,
                    const MetricLimits& limits, const FunctionsSpec& functions);

  /// Other functions, or another time of theirs, for the tensors that vertices have, which are the
  /// metric from now on if they were not yet. Errors: as above.
  Status SetFunctions(const FunctionsSpec& functions, const MetricLimits& limits);

  /// Other limits for the tensors that vertices have, which are the metric from now on if they were
  /// not yet: limits of a specification change with SetMetric. Functions stay. Errors: kOutOfRange.
  Status SetLimits(const MetricLimits& limits);

  /// Who helps from now on with large work: the first build of a large mesh. No executor changes
  /// any bit; a rule other than the default does, and is for tests.
  void UseHelpers(const Helpers& helpers);

  /// Who may end SetMetric, SetField and SetTensors before they take the metric over, from now on:
  /// they then return kCancelled, and everything is as it was. What follows, moving vertices along
  /// and waking those whose tensors differ, is not interrupted, nor are limits.
  /// @param stop  not owned; null: nobody
  void ListenTo(const StopSignal* stop);

  /// Carries out a change of the mesh that is not the loop's (core/motion has them), gives moved
  /// vertices the metric of where they are now, and wakes what was disturbed. On an error
  /// everything stays as it was, with what this revision had changed before. Ends a first build
  /// that was under way, as a metric update does. Errors: those of the change; kExpressionValue;
  /// kFrozen if it would change something frozen.
  Status Apply(MeshChange& change);

  /// Leaves other things alone from now on: these constraints replace those that held, permissions
  /// of Options included. What has thawed wakes, and every node if permissions grow. Whatever is
  /// frozen keeps its bits, ids and tags in every Step; an Apply that would change it is refused.
  /// Ends a first build that was under way, as a metric update does. On error everything stays.
  /// Errors: kIndexOutOfRange, kDuplicateId (see WhatFreezes); kRevisionNotFound if anything is
  /// named before the first commit, which may number anew.
  /// @par Cost O(what is and what was frozen); with regions O(mesh)
  Status SetConstraints(const Constraints& constraints);

  /// Works by other options from now on, permissions included. A greater vertices_max wakes every
  /// node if the old one was reached. Ends a first build that was under way.
  /// Errors: kOutOfRange; kProtocolOrder for another seed or variant, which are the session's.
  Status SetOptions(const Options& options);

  /// Runs the loop. Errors: kExpressionValue if the metric has no value where a node went; the
  /// caller should then Rollback.
  Result<Progress> Step(const Budget& budget);

  /// Where the metric is not met, among what has changed since the last commit; the whole mesh
  /// before the first. Meant for a mesh that has come to rest: while nodes are active there is work
  /// left.
  /// @par Cost O(changed)
  [[nodiscard]] std::vector<Trouble> FindTroubles() const;
  /// The same in two parts: where to look, before a commit, and the look, then or right after it.
  [[nodiscard]] TroubleSearch WhereTroublesMayBe() const;
  [[nodiscard]] std::vector<Trouble> FindTroubles(const TroubleSearch& search) const;

  /// Ends the update: the changes since the last commit as a diff, and a revision more. Allowed
  /// while nodes are active; a later Step goes on with them.
  /// The first commit of a session from a domain also closes gaps in the numbering; the points of
  /// the domain keep their numbers. @pre the last Step returned no error
  /// @par Cost O(changed); the first O(mesh)
  MeshDiff Commit();

  /// The same, with transfer rows in the diff; the first commit has none. @par Cost as Commit
  MeshDiff CommitAndTransfer();

  /// Sets, changes or drops solution fields, which every commit carries from the old mesh to the
  /// new one. Ids and values are of the elements of the last commit, also while the mesh already
  /// differs from it. Takes effect at the next commit; Rollback forgets it.
  /// Errors: kRevisionNotFound before the first commit, else those of FieldSet::Stage.
  Status SetFields(const FieldUpdate& update);

  /// Takes mesh, metric and loop back to the last commit, bit for bit. Before the first commit
  /// there is nothing to go back to. @pre revision() != kNone
  void Rollback();

  /// The mesh of the last commit as a diff from nothing, whatever has changed since.
  /// @pre revision() != kNone @par Cost O(mesh)
  [[nodiscard]] MeshDiff Snapshot() const;

  /// What takes the session from the last commit back to the one before it. Can be taken once,
  /// until the next commit; nothing after the first one, and after Load. @par Cost O(changed)
  std::optional<RevisionDelta> TakeUndo();

  /// What takes the session back to the last commit from where `delta` leads: with the undo of that
  /// commit, the commit itself, for a journal.
  /// @pre nothing changed since the last commit @par Cost O(delta)
  [[nodiscard]] RevisionDelta InverseOf(const RevisionDelta& delta) const;

  /// Goes where a delta leads, as the commit of `revision`; what changed since the last commit is
  /// lost. From there on the session gives the bits that it gave there before.
  /// @param revision  any number: that of the delta, or one that nobody has seen yet.
  /// Errors: kDataCorrupt for a delta that does not lead from the last commit; then nothing
  /// changed but what Rollback does.
  /// @par Cost O(delta)
  Result<MeshDiff> Apply(const RevisionDelta& delta, Revision revision);

  /// The last commit as bytes: versioned, little-endian, with a checksum. Errors: kUnimplemented if
  /// the metric is a field of the caller's own; kRevisionNotFound before the first commit; and
  /// kProtocolOrder if something changed since. @par Cost O(mesh)
  [[nodiscard]] Result<Bytes> Save() const;

  /// A session as it was when it was saved: it goes on with the bits that the other one gives. A
  /// second session from one revision is Load(*Save()).
  /// Errors: kDataCorrupt, kDataVersion. The bytes are safe to read whatever they are; whether they
  /// hold a valid mesh, which a checksum cannot tell, Validate does. @par Cost O(bytes)
  static Result<std::unique_ptr<Remesher>> Load(std::span<const std::byte> bytes);

  /// Reads what WriteDelta wrote of a delta that leads from the last commit. Errors: kDataCorrupt,
  /// kDataVersion; kRevisionMismatch if it leads from another revision.
  [[nodiscard]] Result<RevisionDelta> ReadDelta(std::span<const std::byte> bytes) const;

  [[nodiscard]] const Mesh& mesh() const;
  /// The metric that the mesh follows, limits applied; good until the next call that is not const.
  /// One question at a time, unless it is a formula or a background mesh that nothing limits.
  [[nodiscard]] const MetricField& field() const;
  /// The metric as it was sent, bounds applied, without limits: to measure the mesh against it.
  [[nodiscard]] std::shared_ptr<const MetricField> raw_field() const;
  /// The limits that were asked for; not those that `automatic` has laid.
  [[nodiscard]] MetricLimits limits() const;
  /// The functions beside tensors at vertices, null if there are none; good until the next call
  /// that is not const.
  [[nodiscard]] const FunctionsSpec* functions() const;
  /// What the limits made of the metric when they were laid last.
  [[nodiscard]] const MetricReport& metric_report() const;
  /// The first mesh is being built from coarse to fine: a commit now ends that, and what follows
  /// takes longer.
  [[nodiscard]] bool building() const;
  /// Of the last commit; kNone before the first.
  [[nodiscard]] Revision revision() const;
  [[nodiscard]] const Options& options() const;
  /// Of the last commit.
  [[nodiscard]] const FieldSet& fields() const;

 private:
  class Impl;
  explicit Remesher(std::unique_ptr<Impl> impl);
  static Result<std::unique_ptr<Remesher>> Wrap(Result<std::unique_ptr<Impl>> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace pliant
