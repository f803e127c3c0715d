#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/base/stop_signal.h"
#include "core/mesh/frozen_mesh.h"
#include "core/mesh/mesh_edit.h"
#include "core/metric/gradation.h"
#include "core/metric/metric.h"
#include "core/metric/metric_field.h"
#include "core/metric/metric_functions.h"
#include "core/metric/metric_spec.h"
#include "core/pliant/mesh_limits.h"
#include "core/pliant/recalled_field.h"

namespace pliant {

/// Live vertices in ascending order of slot, for a request that names none. @par Cost O(mesh)
[[nodiscard]] std::vector<VertexId> LiveVertices(const Mesh& mesh);

/// Refuses tensors at vertices that no metric can have. Errors: those of Remesher::SetTensors.
/// @param stop  null: nobody; else kCancelled if it asks to
[[nodiscard]] Status CheckTensorsAt(const Mesh& mesh, std::span<const VertexId> vertices,
                                    std::span<const Metric> tensors,
                                    const StopSignal* stop = nullptr);

/// The metric that a session follows: as it was sent, and limited.
///
/// A formula, a background mesh or a field of the caller's own is asked as it is. Once tensors at
/// vertices are sent, and wherever limits hold, the metric lives at the vertices of the mesh
/// itself, as it was when the update began (FrozenMesh): an update of k tensors copies k tensors.
/// With every commit the mesh of that moment takes its place, so that a committed metric is known
/// from the mesh, from what was sent (State) and from what vertices wanted before limits
/// (RawTensors).
///
/// Tensors at vertices may come with functions of place. MeshLimits intersects them at vertices, as
/// the first of what limits; in between, unless there are other limits that change anything, the
/// loop sees the tensors' interpolation intersected with what the functions have there.
///
/// Reads the mesh and moves hints, but changes nothing of it: what vertices shall have comes back
/// as WantedTensors.
/// *Invariants*: field() answers for the mesh as it was when it was set, whatever has become of it.
/// Limits are those of a full run over the raw tensors, to the bit.
/// *Threads*: one caller at a time; field() too, unless it was sent as it is.
class FollowedMetric {
 public:
  /// What was sent. A copy shares the field, which does not change.
  struct State {
    std::shared_ptr<MetricField> source;  ///< Bounds applied; null: tensors at the vertices.
    std::optional<MetricSpec> spec;       ///< What `source` was made from, if it can be compared.
    /// Beside tensors at the vertices; null: none.
    std::shared_ptr<const MetricFunctions> functions;
    SizeBounds bounds;
    GradationOptions limits;
    bool usual_hold = false;  ///< The usual ones among them, because they were needed.
    int limit_rounds_left = 0;
    /// The limits have been put off: vertices have tensors that were laid on another mesh.
    bool limits_due = false;

    /// True if vertices keep what they wanted beside what they have.
    [[nodiscard]] bool keeps_raw() const { return limits.any() || functions != nullptr; }
  };

  /// What is followed, to come back to it.
  struct Way {
    State state;
    std::shared_ptr<MetricField> field;
    std::shared_ptr<FrozenMesh> base;
  };

  /// @param tolerance  Options::metric_tolerance.
  FollowedMetric(MeshEdit& edit, double tolerance)
      : edit_(edit), mesh_(edit.mesh()), tolerance_(tolerance), limits_(edit) {}

  /// Another Options::metric_tolerance from now on.
  void SetTolerance(double tolerance) { tolerance_ = tolerance; }

  /// Refuses a specification that names impossible limits; the field is checked when it is made.
  [[nodiscard]] static Status Check(const MetricSpec& spec);
  /// Refuses impossible limits.
  [[nodiscard]] static Status Check(const MetricLimits& limits);

  /// True if `spec` is known to be what is followed already.
  [[nodiscard]] bool Follows(const MetricSpec& spec) const {
    return state_.spec.has_value() && *state_.spec == spec;
  }

  /// Leads back from SetField and SetTensors as long as the mesh has not changed. Nothing where
  /// limits are not those of the last commit, which is all that they go back to.
  [[nodiscard]] std::optional<Way> WayBack() const;
  void GoBack(Way way);

  /// What a field wants at every vertex, for SetField. @par Cost O(mesh): a formula has to be asked
  /// at every vertex once, for nobody knows where it changed.
  /// @param stop  null: nobody; else kCancelled if it asks to
  [[nodiscard]] Result<WantedTensors> Evaluate(const MetricField& field,
                                               const StopSignal* stop = nullptr);

  /// What a field wants at some vertices, in their order, whether or not it has an answer
  /// everywhere (MetricField::status). @param stop  as for Evaluate
  [[nodiscard]] Result<std::vector<Metric>> Ask(const MetricField& field,
                                                std::span<const VertexId> vertices,
                                                const StopSignal* stop = nullptr);

  /// Follows a field from now on, as it is until limits are laid: for the first one of a session.
  /// @param spec  what it was made from, remembered to compare the next one with, unless it has a
  ///              background mesh: that is as large as the mesh, and comparing tensors at the
  ///              vertices finds the same. Null for a field of the caller's own, which nothing
  ///              limits.
  void Follow(std::shared_ptr<MetricField> field, const MetricSpec* spec);

  /// Follows another field from now on, limits laid. @param raw  Evaluate(*field)
  /// @param stop  null: nobody; else kCancelled if it asks to, and GoBack must follow
  [[nodiscard]] Result<WantedTensors> SetField(std::shared_ptr<MetricField> field,
                                               const MetricSpec* spec, WantedTensors raw,
                                               const StopSignal* stop = nullptr);

  /// Refuses what SetTensors cannot take.
  [[nodiscard]] Status CheckTensors(std::span<const VertexId> vertices,
                                    std::span<const Metric> tensors,
                                    const StopSignal* stop = nullptr) const {
    return CheckTensorsAt(mesh_, vertices, tensors, stop);
  }

  /// Refuses functions that have no value at a vertex. @par Cost O(mesh)
  [[nodiscard]] Status CheckAtVertices(const MetricFunctions& functions,
                                       const StopSignal* stop = nullptr) const;

  /// True if SetTensors at these vertices leaves nothing of what was followed before, unless it is
  /// the same tensors.
  [[nodiscard]] bool IsReplacedBy(std::span<const VertexId> vertices) const {
    return committed() && !state_.keeps_raw() && std::ssize(vertices) == mesh_.vertex_count();
  }

  /// Other tensors at some vertices from now on, bounds applied; the others keep theirs. Wants
  /// nothing if none differs from what is followed. @pre CheckTensors
  /// @param stop  null: nobody; else kCancelled if it asks to, and GoBack must follow
  /// @par Cost O(k + changed since the last commit); before the first commit O(mesh)
  [[nodiscard]] Result<WantedTensors> SetTensors(std::span<const VertexId> vertices,
                                                 std::span<const Metric> tensors,
                                                 const StopSignal* stop = nullptr);

  /// What holds for tensors at vertices.
  struct Terms {
    MetricLimits limits;
    /// Made with the bounds of `limits`; null: none.
    std::shared_ptr<const MetricFunctions> functions = nullptr;
  };
  /// True if they hold already.
  [[nodiscard]] bool Holds(const Terms& terms) const {
    return terms.limits == asked_limits() && terms.functions == state_.functions;
  }
  /// The same on other terms from now on: also for the tensors of the other vertices, as far as
  /// they are known. What bounds have cut off a tensor is lost.
  /// @pre CheckTensors, Check(terms.limits), CheckAtVertices; functions only after a commit
  /// @param stop  as for SetTensors
  /// @par Cost O(k) if they are those that hold, else O(mesh)
  [[nodiscard]] Result<WantedTensors> SetTensors(std::span<const VertexId> vertices,
                                                 std::span<const Metric> tensors,
                                                 const Terms& terms,
                                                 const StopSignal* stop = nullptr);

  /// Tensors that vertices brought along when they were moved: the field takes them over where they
  /// are now, and over the triangles at them. Beside functions only what these have not made of
  /// them comes along. @pre the mesh has them already
  [[nodiscard]] Result<WantedTensors> Carry(std::span<const VertexId> vertices,
                                            std::span<const Metric> tensors);

  /// Limits the raw metric over the edges of the mesh as it is and follows the result.
  /// @param stop  null: nobody; else kCancelled if it asks to, and PutLimitsOff must follow
  /// @pre limits_again() @par Cost O(changed since the last time); before the first commit O(mesh)
  [[nodiscard]] Result<WantedTensors> Limit(const StopSignal* stop = nullptr);

  /// True where limits that hold can be put off: until LayDueLimits vertices keep what they have.
  /// What was sent is known everywhere only if it is a field of its own.
  [[nodiscard]] bool may_put_limits_off() const {
    return state_.limits.any() && state_.source != nullptr;
  }
  /// Forgets what limits have made of the metric. @pre may_put_limits_off()
  void PutLimitsOff();
  [[nodiscard]] bool limits_due() const { return state_.limits_due; }
  /// Lays the limits on the mesh as it is, as in an update. @pre limits_due()
  /// @param stop  null: nobody; else kCancelled if it asks to, and they are due as before
  /// @par Cost O(mesh)
  [[nodiscard]] Result<WantedTensors> LayDueLimits(const StopSignal* stop);

  /// True while it is open whether the metric needs the usual limits.
  [[nodiscard]] bool awaits_need() const { return state_.limits.awaits_need(); }
  /// It needs them: limits_again() from now on. @pre awaits_need()
  void HoldUsualLimits();

  /// True while the metric is to be limited on the mesh that the loop has made of it: that of
  /// before may be too coarse to know the metric.
  [[nodiscard]] bool limits_again() const { return state_.limit_rounds_left > 0; }
  /// No more rounds in this update: nothing woke.
  void EndRounds() { state_.limit_rounds_left = 0; }

  /// Before MeshEdit::Commit: lays the limits on the mesh that is about to be committed. What comes
  /// back is to be taken over without waking anybody.
  [[nodiscard]] Result<WantedTensors> Settle();
  /// After MeshEdit::Commit. @return what leads back to the commit before, besides State.
  RawTensors AfterCommit();
  /// Around MeshEdit::BeginTrial and the Keep or Undo that ends it.
  void BeforeTrial();
  void AfterTrial();
  /// The mesh was changed by something else than the loop: limits are laid again after it.
  void MeshMoved();

  /// Back to the last commit. @pre MeshEdit::Rollback was called
  void Rollback(const State& committed);
  /// To another commit, which the mesh already has gone to.
  /// @param touched  vertices that differ from those of the commit before, or whose neighbours do.
  /// @return what leads back to the commit before, besides State.
  RawTensors GoTo(const State& state, const RawTensors& raw, std::span<const VertexId> touched);

  /// True if a tensor is another one than a vertex has, by more than the tolerance.
  [[nodiscard]] bool Differs(const Metric& old, const Metric& now) const {
    return !(now == old) && RelativeChange(old, now) > tolerance_;
  }

  /// What the loop sees.
  [[nodiscard]] const MetricField& field() const { return *field_; }
  [[nodiscard]] const std::shared_ptr<MetricField>& shared_field() const { return field_; }
  /// The same if it is tensors sent at most vertices, else null.
  [[nodiscard]] RecalledField* recalled_field() const {
    return field_ == recalled_ ? recalled_.get() : nullptr;
  }
  /// The metric as it was sent, bounds applied, without limits; good until the next update.
  [[nodiscard]] std::shared_ptr<const MetricField> RawField() const;
  /// The first question since the field was sent that it had no usable answer to.
  [[nodiscard]] Status status() const {
    if (state_.functions != nullptr) return state_.functions->status();
    return state_.source == nullptr ? Status() : state_.source->status();
  }
  [[nodiscard]] const MeshLimits& limits() const { return limits_; }
  [[nodiscard]] const State& state() const { return state_; }
  /// Those that were asked for: without the usual ones that were needed.
  [[nodiscard]] MetricLimits asked_limits() const;

 private:
  /// Passes of the limits in one update, the first before the loop runs.
  static constexpr int kLimitRounds = 3;

  [[nodiscard]] bool committed() const { return edit_.committed() != Revision::kNone; }
  /// True if the loop sees what was sent: also where limits are laid but change nothing.
  [[nodiscard]] bool as_sent() const {
    return state_.source != nullptr && !state_.limits_due &&
           !(limits_.on() && limits_.limits_anything());
  }
  /// True if the loop sees functions and the raw tensors.
  [[nodiscard]] bool as_met() const {
    return state_.functions != nullptr && !limits_.limits_anything();
  }
  [[nodiscard]] std::shared_ptr<MetricField> MetField() const;
  [[nodiscard]] std::shared_ptr<const MetricField> RawOfVertices() const;
  void Take(std::shared_ptr<MetricField> field, const MetricSpec* spec);
  void TakeLimits(const MetricLimits& limits);
  [[nodiscard]] Result<WantedTensors> RawNow(const StopSignal* stop);
  [[nodiscard]] WantedTensors RawAt(std::span<const VertexId> vertices) const;
  [[nodiscard]] Result<WantedTensors> FollowTensors(WantedTensors wanted, const StopSignal* stop);
  [[nodiscard]] Result<WantedTensors> LimitTensors(std::span<const VertexId> vertices,
                                                   const std::vector<Metric>& tensors,
                                                   const StopSignal* stop);
  [[nodiscard]] Status LoadLimits(const StopSignal* stop);
  [[nodiscard]] Result<WantedTensors> LimitAnew(const StopSignal* stop);
  [[nodiscard]] Result<WantedTensors> LayLimits(const StopSignal* stop);
  [[nodiscard]] bool WantsCopy(const WantedTensors& others) const;
  Status FollowMesh(const WantedTensors& others, const StopSignal* stop);
  void FollowCommitted();
  [[nodiscard]] std::unique_ptr<BackgroundField> CopyWith(const WantedTensors& others,
                                                          const StopSignal* stop) const;
  [[nodiscard]] std::unique_ptr<BackgroundField> CopyOf(std::span<const Metric> tensors,
                                                        const StopSignal* stop) const;

  MeshEdit& edit_;
  const Mesh& mesh_;
  double tolerance_;
  State state_;
  MeshLimits limits_;
  std::shared_ptr<MetricField> field_;
  std::shared_ptr<RecalledField> recalled_;  ///< field_, or one that was.
  /// The mesh of the last commit or Update of the limits, whichever came later; from the first
  /// commit on.
  std::shared_ptr<FrozenMesh> base_;
};

}  // namespace pliant
