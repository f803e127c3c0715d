#pragma once

#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/delaunay/import_mesh.h"
#include "core/mesh/mesh_edit.h"
#include "core/pliant/followed_metric.h"
#include "core/pliant/frozen.h"
#include "core/pliant/nested_build.h"
#include "core/pliant/remesher.h"
#include "core/pliant/snapshot.h"

namespace pliant {

/// What is behind Remesher, for the three files that share the work: remesher.cc makes it,
/// remesher_update.cc carries updates out, remesher_commit.cc makes revisions and goes back to
/// them. The functions that have the names of Remesher's are those.
class Remesher::Impl {
 public:
  /// What happens to slots at the first commit.
  enum class Numbering { kClosesGaps, kKeeps };

  Impl(const MeshPlan& plan, Numbering numbering, const Options& options);
  explicit Impl(SavedSession snapshot);

  static Result<std::unique_ptr<Impl>> Make(const Result<MeshPlan>& plan, Numbering numbering,
                                            std::unique_ptr<MetricField> field,
                                            const Options& options);
  static Result<std::unique_ptr<Impl>> MakeFromSpec(const Result<MeshPlan>& plan,
                                                    Numbering numbering, const MetricSpec& spec,
                                                    const Options& options);

  Status SetSpec(const MetricSpec& spec);
  /// @param spec  what the field was made from; null for a field of the caller's own.
  Status SetField(std::unique_ptr<MetricField> field, const MetricSpec* spec);
  /// What shall hold for tensors at vertices.
  struct WantedTerms {
    const MetricLimits* limits = nullptr;  ///< Null: those that hold.
    /// Null: none, or, for tensors at some vertices, those that hold.
    const FunctionsSpec* functions = nullptr;
  };
  Status SetTensors(std::span<const VertexId> given, std::span<const Metric> tensors,
                    const WantedTerms& wanted);
  Status SetLimits(const MetricLimits& limits);
  Status SetFunctions(const FunctionsSpec& functions, const MetricLimits& limits);
  Status Change(MeshChange& change);
  Status SetConstraints(const Constraints& constraints);
  Status SetOptions(const Options& options);
  Result<Progress> Step(Budget budget);
  [[nodiscard]] TroubleSearch WhereTroublesMayBe() const;
  [[nodiscard]] std::vector<Trouble> FindTroubles(const TroubleSearch& search) const;

  MeshDiff Commit() { return fields_.idle() ? CommitMesh() : CommitAndTransfer(); }
  MeshDiff CommitAndTransfer();
  Status SetFields(const FieldUpdate& update);
  void Rollback();
  [[nodiscard]] MeshDiff Snapshot() const;
  std::optional<RevisionDelta> TakeUndo();
  [[nodiscard]] RevisionDelta InverseOf(const RevisionDelta& delta) const;
  Result<MeshDiff> Apply(const RevisionDelta& delta, Revision revision);
  [[nodiscard]] Result<Bytes> Save() const;
  static Result<std::unique_ptr<Impl>> Load(std::span<const std::byte> bytes);
  [[nodiscard]] Result<RevisionDelta> ReadDelta(std::span<const std::byte> bytes) const;

  void ListenTo(const StopSignal* stop) { stop_ = stop; }
  void UseHelpers(const Helpers& helpers) { helpers_ = helpers; }
  [[nodiscard]] const Mesh& mesh() const { return mesh_; }
  [[nodiscard]] const MetricField& field() const { return followed_.field(); }
  [[nodiscard]] std::shared_ptr<const MetricField> raw_field() const {
    return followed_.RawField();
  }
  [[nodiscard]] MetricLimits limits() const { return followed_.asked_limits(); }
  [[nodiscard]] const FunctionsSpec* functions() const {
    const auto& held = followed_.state().functions;
    return held == nullptr ? nullptr : &held->spec();
  }
  [[nodiscard]] const MetricReport& metric_report() const { return followed_.limits().report(); }
  [[nodiscard]] bool building() const { return nested_.has_value(); }
  [[nodiscard]] Revision revision() const { return revision_; }
  [[nodiscard]] const Options& options() const { return options_; }
  [[nodiscard]] const FieldSet& fields() const { return fields_; }

 private:
  /// What a rollback needs beyond the change log.
  struct Committed {
    FollowedMetric::State followed;
    PliantLoop::State loop;
    SharedFields fields;
  };

  /// How long work listens to a stop signal.
  enum class Asks {
    kBeforeChanges,  ///< Until it changes the mesh.
    kToTheEnd,       ///< To its end: who called it goes back to the commit.
  };
  /// Whether vertices are carried along where a metric at rest has moved.
  enum class Carries { kFronts, kNobody };
  enum class Fate { kKept, kUndone };
  /// Carries a change out, and undoes it if something is wrong with it or it is to be undone.
  Result<MeshChange::Outcome> Try(MeshChange& change, Fate fate);
  /// Gives every vertex its first metric and wakes it.
  Status Start(std::unique_ptr<MetricField> field, const MetricSpec* spec);
  void UseOptions(const Options& options);
  void GoOnAsCommitted();
  void LeaveNestedBuild();
  Status LetMetricFollow();
  Result<StopReason> RunToRest(Budget budget);
  Status LimitAgain(const StopSignal* stop);
  Status LayDueLimits(const StopSignal* stop);
  [[nodiscard]] bool NeedsLimits();
  [[nodiscard]] TroubleContext ContextOfTroubles() const;
  [[nodiscard]] Result<FollowedMetric::Terms> TermsOf(const WantedTerms& wanted);
  Status FollowTensors(std::span<const VertexId> vertices, std::span<const Metric> tensors,
                       const FollowedMetric::Terms& terms);
  [[nodiscard]] const StopSignal* StopOfWhole() const;
  Status ApplyOrGoBack(Result<WantedTensors> wanted, const StopSignal* stop,
                       std::optional<FollowedMetric::Way> way);
  Status Apply(WantedTensors wanted, const StopSignal* stop, Asks asks = Asks::kBeforeChanges,
               Carries carries = Carries::kFronts);
  [[nodiscard]] bool nothing_staged() const;
  void GoBackToCommit();
  Status FollowChange(MeshChange::Outcome outcome, const StopSignal* stop);
  void ChangeInBulk();

  MeshDiff CommitMesh();
  [[nodiscard]] bool PutsLimitsOff() const;
  void SettleMetric();
  void RestoreFields();
  [[nodiscard]] FieldChanges AllFields(const SharedFields& before) const;

  Options options_;
  Helpers helpers_;
  const StopSignal* stop_ = nullptr;  // Of metric updates; a step has one in its budget.
  Mesh mesh_;
  MeshEdit edit_;
  PliantLoop loop_;
  const BoundingBox box_;
  const Numbering numbering_;
  FollowedMetric followed_;
  FieldSet fields_;
  std::optional<FrozenElements> frozen_;  // Absent: to be looked up in the mesh.
  bool domain_replaced_ = false;          // Since the last commit.
  bool was_stopped_ = false;              // The last step, by a stop signal.
  std::vector<VertexId> carriers_;        // Their tensors are not in the followed field yet.
  std::vector<VertexId> rewoken_;         // Whose tensors have changed since the last step.
  std::optional<NestedBuild> nested_;     // While the first mesh is built from coarse to fine.
  Revision revision_ = Revision::kNone;
  Committed committed_;
  // Of the commit before, for TakeUndo.
  Revision previous_revision_ = Revision::kNone;
  Committed previous_;
  RawTensors undo_raw_;
};

}  // namespace pliant
