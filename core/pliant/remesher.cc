#include "core/pliant/remesher.h"

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/delaunay/import_mesh.h"
#include "core/mesh/committed_snapshot.h"
#include "core/mesh/mesh_edit.h"
#include "core/pliant/check_options.h"
#include "core/pliant/followed_metric.h"
#include "core/pliant/nested_build.h"
#include "core/pliant/snapshot.h"
#include "core/transfer/check_fields.h"

namespace pliant {
namespace {

BoundingBox BoxOf(std::span<const Vec2> points) {
  BoundingBox box{points.front(), points.front()};
  for (const Vec2 p : points) {
    box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y)};
    box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y)};
  }
  return box;
}

/// What happens to slots at the first commit.
enum class Numbering { kClosesGaps, kKeeps };

}  // namespace

class Remesher::Impl {
 public:
  Impl(const MeshPlan& plan, Numbering numbering, const Options& options)
      : options_(options),
        edit_(mesh_),
        loop_(edit_, options),
        box_(BoxOf(plan.positions)),
        numbering_(numbering),
        followed_(edit_, options.metric_tolerance) {
    BuildFromPlan(plan, edit_);
  }

  explicit Impl(SavedSession snapshot)
      : options_(snapshot.options),
        edit_(mesh_),
        loop_(edit_, options_),
        box_(snapshot.box),
        numbering_(Numbering::kKeeps),
        followed_(edit_, options_.metric_tolerance),
        revision_(snapshot.revision),
        committed_{std::move(snapshot.metric), std::move(snapshot.loop), snapshot.fields} {
    edit_.Restore(std::move(snapshot.mesh), revision_);
    followed_.Restore(committed_.followed);
    loop_.Restore(committed_.loop);
    RestoreFields();
  }

  static Result<std::unique_ptr<Impl>> Make(const Result<MeshPlan>& plan, Numbering numbering,
                                            std::unique_ptr<MetricField> field,
                                            const MetricSpec* spec, const Options& options) {
    PLIANT_RETURN_IF_ERROR(CheckOptions(options));
    if (!plan.ok()) return plan.error();
    auto impl = std::make_unique<Impl>(*plan, numbering, options);
    PLIANT_RETURN_IF_ERROR(impl->Start(std::move(field), spec));
    return impl;
  }

  static Result<std::unique_ptr<Impl>> MakeFromSpec(const Result<MeshPlan>& plan,
                                                    Numbering numbering, const MetricSpec& spec,
                                                    const Options& options) {
    if (!plan.ok()) return plan.error();
    PLIANT_RETURN_IF_ERROR(FollowedMetric::Check(spec));
    PLIANT_ASSIGN_OR_RETURN(std::unique_ptr<MetricField> field,
                            MakeMetricField(spec, BoxOf(plan->positions)));
    return Make(plan, numbering, std::move(field), &spec, options);
  }

  /// Gives every vertex its first metric and wakes it.
  Status Start(std::unique_ptr<MetricField> field, const MetricSpec* spec) {
    followed_.Follow(std::move(field), spec);
    MetricField& raw = *followed_.raw();
    if (options_.variant == Variant::kNested && numbering_ == Numbering::kClosesGaps &&
        options_.permissions == Permissions{}) {
      nested_.emplace(edit_, loop_, followed_.raw(), options_);
    } else {
      loop_.BeginUpdate(SettingsOf(options_));
      for (const VertexId vertex : LiveVertices(mesh_)) {
        edit_.SetMetric(vertex, raw.At(mesh_.position(vertex), edit_.Hint(vertex)));
        loop_.Wake(vertex);
      }
    }
    return raw.status();
  }

  Status SetSpec(const MetricSpec& spec) {
    if (followed_.Follows(spec)) return {};
    PLIANT_RETURN_IF_ERROR(FollowedMetric::Check(spec));
    PLIANT_ASSIGN_OR_RETURN(std::unique_ptr<MetricField> field, MakeMetricField(spec, box_));
    return SetField(std::move(field), &spec);
  }

  /// @param spec  what the field was made from; null for a field of the caller's own.
  Status SetField(std::unique_ptr<MetricField> field, const MetricSpec* spec) {
    WantedTensors wanted{LiveVertices(mesh_), {}};
    wanted.tensors.reserve(wanted.vertices.size());
    for (const VertexId vertex : wanted.vertices) {
      wanted.tensors.push_back(field->At(mesh_.position(vertex), edit_.Hint(vertex)));
    }
    PLIANT_RETURN_IF_ERROR(field->status());
    LeaveNestedBuild();
    carriers_.clear();  // Another field replaces what they carried.
    followed_.Follow(std::move(field), spec);
    if (followed_.limits_again()) return Limit();
    Apply(wanted);
    return {};
  }

  Status SetTensors(std::span<const VertexId> given, std::span<const Metric> tensors) {
    const std::vector<VertexId> all = given.empty() ? LiveVertices(mesh_) : std::vector<VertexId>();
    const std::span<const VertexId> vertices = given.empty() ? std::span(all) : given;
    PLIANT_RETURN_IF_ERROR(followed_.CheckTensors(vertices, tensors));
    LeaveNestedBuild();
    PLIANT_RETURN_IF_ERROR(LetMetricFollow());
    PLIANT_ASSIGN_OR_RETURN(const WantedTensors wanted, followed_.SetTensors(vertices, tensors));
    if (!wanted.vertices.empty()) Apply(wanted);
    return {};
  }

  Status Change(MeshChange& change) {
    LeaveNestedBuild();
    PLIANT_RETURN_IF_ERROR(LetMetricFollow());
    MeshEdit::Trial trial = edit_.BeginTrial();
    Result<MeshChange::Outcome> outcome = change.Apply(edit_);
    if (!outcome.ok()) {
      edit_.Undo(std::move(trial));
      return outcome.error();
    }
    edit_.Keep(std::move(trial));
    WantedTensors wanted{std::move(outcome->moved), {}};
    for (const VertexId vertex : wanted.vertices) {
      wanted.tensors.push_back(followed_.field().At(mesh_.position(vertex), edit_.Hint(vertex)));
    }
    Apply(wanted);
    for (const VertexId vertex : outcome->disturbed) loop_.Wake(vertex);
    carriers_ = std::move(outcome->carriers);
    return {};
  }

  /// The limits are laid on the mesh as it is when an update begins, which may be too coarse to
  /// know the metric; they are laid again on the mesh that comes out.
  Result<Progress> Step(Budget budget) {
    PLIANT_RETURN_IF_ERROR(LetMetricFollow());
    Progress progress;
    for (;;) {
      const std::int64_t visits_before = loop_.counts().visits;
      progress.stop_reason =
          nested_ ? nested_->Run(budget, helpers_) : loop_.Run(followed_.field(), budget);
      PLIANT_RETURN_IF_ERROR(followed_.raw()->status());
      budget.visits_max -= loop_.counts().visits - visits_before;
      if (!Ended(progress.stop_reason)) break;
      if (nested_ && nested_->levels_left() > 0) {
        nested_->NextLevel(helpers_);
        continue;
      }
      nested_.reset();
      if (followed_.limits_again()) {
        PLIANT_RETURN_IF_ERROR(Limit());
      } else if (!loop_.Mend()) {
        break;
      }
    }
    progress.active_count = nested_ ? nested_->active_count() : loop_.active_count();
    progress.counts = loop_.counts();
    return progress;
  }

  MeshDiff Commit() { return fields_.idle() ? CommitMesh() : CommitAndTransfer(); }

  MeshDiff CommitAndTransfer() {
    if (revision_ == Revision::kNone) return CommitMesh();
    const bool staged = fields_.staged();
    const MeshTransfer transfer(mesh_, edit_.log());
    FieldChanges fields = fields_.Commit(transfer);
    MeshDiff diff = CommitMesh();
    const bool same = diff.empty() && !staged;
    committed_.fields = same ? previous_.fields : KeepFields(fields_.fields());
    diff.transfer = transfer.rows();
    diff.fields = std::move(fields);
    return diff;
  }

  Status SetFields(const FieldUpdate& update) {
    if (revision_ == Revision::kNone) {
      return Error{ErrorCode::kRevisionNotFound,
                   "there is no revision yet whose elements could have values; advance first",
                   "fields"};
    }
    return fields_.Stage(mesh_, update);
  }

  MeshDiff CommitMesh() {
    LeaveNestedBuild();
    PLIANT_CHECK(carriers_.empty() || LetMetricFollow().ok());
    PLIANT_CHECK(followed_.raw()->status().ok());
    if (revision_ == Revision::kNone && numbering_ == Numbering::kClosesGaps) {
      loop_.Renumber(edit_.Compact(helpers_.executor()));
    }
    previous_revision_ = revision_;
    revision_ = Revision(static_cast<std::int64_t>(revision_) + 1);
    MeshDiff diff = edit_.Commit(revision_, helpers_.executor());
    loop_.ResetCounts();
    previous_ = std::move(committed_);
    committed_ = {followed_.state(), loop_.Save(), nullptr};
    return diff;
  }

  [[nodiscard]] std::vector<Trouble> FindTroubles() const {
    const LoopCounts& counts = loop_.counts();
    const TroubleContext context{.insertions_refused = counts.refused_at_limit > 0 ||
                                                       counts.refused_by_allowance > 0};
    const std::vector<TriangleId> triangles = revision_ == Revision::kNone
                                                  ? LiveTrianglesOf(mesh_)
                                                  : TrianglesAtChanges(mesh_, edit_.log());
    return pliant::FindTroubles(mesh_, triangles, context);
  }

  void Rollback() {
    PLIANT_CHECK(revision_ != Revision::kNone);
    edit_.Rollback();
    fields_.Discard();
    carriers_.clear();
    followed_.Restore(committed_.followed);
    loop_.Restore(committed_.loop);
  }

  void UseHelpers(const Helpers& helpers) { helpers_ = helpers; }

  [[nodiscard]] MeshDiff Snapshot() const {
    PLIANT_CHECK(revision_ != Revision::kNone);
    return CommittedSnapshot(edit_, revision_);
  }

  std::optional<RevisionDelta> TakeUndo() {
    std::optional<MeshDelta> mesh = edit_.TakeUndo();
    if (!mesh) return std::nullopt;
    return RevisionDelta{.base = revision_,
                         .revision = previous_revision_,
                         .mesh = *std::move(mesh),
                         .metric = previous_.followed,
                         .base_metric = committed_.followed,
                         .loop = previous_.loop,
                         .fields = previous_.fields,
                         .base_fields = committed_.fields};
  }

  [[nodiscard]] RevisionDelta InverseOf(const RevisionDelta& delta) const {
    return {.base = delta.revision,
            .revision = revision_,
            .mesh = edit_.InverseOf(delta.mesh),
            .metric = committed_.followed,
            .base_metric = delta.metric,
            .loop = committed_.loop,
            .fields = committed_.fields,
            .base_fields = delta.fields};
  }

  Result<MeshDiff> Apply(const RevisionDelta& delta, Revision revision) {
    if (revision_ == Revision::kNone) return NoRevision();
    Rollback();
    if (!edit_.Fits(delta.mesh)) {
      return CorruptData(
          "revision record",
          "does not lead from revision " + std::to_string(static_cast<std::int64_t>(revision_)));
    }
    MeshDiff diff = edit_.Apply(delta.mesh, revision);
    previous_revision_ = std::exchange(revision_, revision);
    previous_ = std::exchange(committed_, {delta.metric, delta.loop, delta.fields});
    followed_.Restore(committed_.followed);
    loop_.Restore(committed_.loop);
    RestoreFields();
    if (previous_.fields != committed_.fields) diff.fields = AllFields(previous_.fields);
    return diff;
  }

  [[nodiscard]] Result<Bytes> Save() const {
    if (revision_ == Revision::kNone) return NoRevision();
    if (!edit_.log().empty()) {
      return Error{ErrorCode::kProtocolOrder,
                   "the session has changed since its last commit; commit or roll back, then save"};
    }
    return WriteSnapshot({.options = options_,
                          .box = box_,
                          .revision = revision_,
                          .summary = edit_.summary(),
                          .mesh = mesh_,
                          .metric = committed_.followed,
                          .loop = committed_.loop,
                          .fields = committed_.fields});
  }

  static Result<std::unique_ptr<Impl>> Load(std::span<const std::byte> bytes) {
    PLIANT_ASSIGN_OR_RETURN(SavedSession snapshot, ReadSnapshot(bytes));
    const MeshSummary summary = snapshot.summary;
    auto impl = std::make_unique<Impl>(std::move(snapshot));
    if (impl->edit_.summary() != summary) {
      return CorruptData("snapshot", "has another mesh than its state hash says");
    }
    return impl;
  }

  [[nodiscard]] Result<RevisionDelta> ReadDelta(std::span<const std::byte> bytes) const {
    PLIANT_ASSIGN_OR_RETURN(RevisionDelta delta,
                            pliant::ReadDelta(bytes, committed_.followed, committed_.fields));
    if (delta.base != revision_) {
      return Error{ErrorCode::kRevisionMismatch,
                   "the revision record leads from revision " +
                       std::to_string(static_cast<std::int64_t>(delta.base)) +
                       "; the session is at " +
                       std::to_string(static_cast<std::int64_t>(revision_)),
                   "revision"};
    }
    return delta;
  }

  [[nodiscard]] const Mesh& mesh() const { return mesh_; }
  [[nodiscard]] const MetricField& field() const { return followed_.field(); }
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

  void RestoreFields() {
    fields_.Restore(committed_.fields ? std::span(*committed_.fields) : std::span<const Field>());
  }

  /// Every value, and the fields that are no more: what a copy of others needs.
  [[nodiscard]] FieldChanges AllFields(const SharedFields& before) const {
    std::vector<VertexId> vertices;
    for (const std::int32_t slot : CommittedSlots(mesh_, FieldLocation::kVertex)) {
      vertices.emplace_back(slot);
    }
    std::vector<TriangleId> triangles;
    for (const std::int32_t slot : CommittedSlots(mesh_, FieldLocation::kTriangle)) {
      triangles.emplace_back(slot);
    }
    FieldChanges changes{.changed = fields_.At(vertices, triangles), .dropped_names = {}};
    if (before == nullptr) return changes;
    for (const Field& field : *before) {
      if (fields_.Find(field.name) == nullptr) changes.dropped_names.push_back(field.name);
    }
    return changes;
  }

  static Error NoRevision() {
    return {ErrorCode::kRevisionNotFound, "the session has no revision yet; commit one first",
            "revision"};
  }

  static bool Ended(StopReason reason) {
    return reason == StopReason::kConverged || reason == StopReason::kVertexLimit;
  }

  /// The levels of the first build follow the metric that it began with, in the mesh's records too.
  void LeaveNestedBuild() {
    if (nested_) nested_->Finish(helpers_);
    nested_.reset();
  }

  /// The metric takes over what vertices carried along with them. Put off until someone needs it:
  /// a metric that is sent together with a motion makes it superfluous.
  Status LetMetricFollow() {
    if (carriers_.empty()) return {};
    const std::vector<VertexId> carriers = std::exchange(carriers_, {});
    std::vector<Metric> tensors;
    tensors.reserve(carriers.size());
    for (const VertexId vertex : carriers) tensors.push_back(mesh_.metric(vertex));
    PLIANT_ASSIGN_OR_RETURN(const WantedTensors wanted, followed_.Carry(carriers, tensors));
    if (!wanted.vertices.empty()) Apply(wanted);
    return {};
  }

  /// Limits the metric on the mesh as it is. Nodes that the raw metric kept busy until they were
  /// old get their visits back: it is another metric now.
  Status Limit() {
    PLIANT_ASSIGN_OR_RETURN(const WantedTensors wanted, followed_.Limit());
    Apply(wanted);
    return {};
  }

  /// Takes over tensors that differ by more than the tolerance, and wakes their nodes. Smaller
  /// changes leave the old tensor in place, so that many of them add up and are seen at last.
  void Apply(const WantedTensors& wanted) {
    loop_.BeginUpdate(SettingsOf(options_));
    for (std::size_t i = 0; i < wanted.vertices.size(); ++i) {
      if (!followed_.Differs(mesh_.metric(wanted.vertices[i]), wanted.tensors[i])) continue;
      edit_.SetMetric(wanted.vertices[i], wanted.tensors[i]);
      loop_.Wake(wanted.vertices[i]);
    }
  }

  const Options options_;
  Helpers helpers_;
  Mesh mesh_;
  MeshEdit edit_;
  PliantLoop loop_;
  const BoundingBox box_;
  const Numbering numbering_;
  FollowedMetric followed_;
  FieldSet fields_;
  std::vector<VertexId> carriers_;     // Their tensors are not in the followed field yet.
  std::optional<NestedBuild> nested_;  // While the first mesh is built from coarse to fine.
  Revision revision_ = Revision::kNone;
  Committed committed_;
  // Of the commit before, for TakeUndo.
  Revision previous_revision_ = Revision::kNone;
  Committed previous_;
};

Remesher::Remesher(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Remesher::~Remesher() = default;

Result<std::unique_ptr<Remesher>> Remesher::Wrap(Result<std::unique_ptr<Impl>> impl) {
  if (!impl.ok()) return impl.error();
  return std::unique_ptr<Remesher>(new Remesher(std::move(impl).value()));
}

Result<std::unique_ptr<Remesher>> Remesher::Create(const Domain& domain, const MetricSpec& metric,
                                                   const Options& options) {
  return Wrap(Impl::MakeFromSpec(PlanDomain(domain), Numbering::kClosesGaps, metric, options));
}

Result<std::unique_ptr<Remesher>> Remesher::Create(const MeshData& mesh, const MetricSpec& metric,
                                                   const Options& options) {
  return Wrap(Impl::MakeFromSpec(PlanImport(mesh), Numbering::kKeeps, metric, options));
}

Result<std::unique_ptr<Remesher>> Remesher::Create(const Domain& domain,
                                                   std::unique_ptr<MetricField> field,
                                                   const Options& options) {
  return Wrap(
      Impl::Make(PlanDomain(domain), Numbering::kClosesGaps, std::move(field), nullptr, options));
}

Result<std::unique_ptr<Remesher>> Remesher::Create(const MeshData& mesh,
                                                   std::unique_ptr<MetricField> field,
                                                   const Options& options) {
  return Wrap(Impl::Make(PlanImport(mesh), Numbering::kKeeps, std::move(field), nullptr, options));
}

Status Remesher::SetMetric(const MetricSpec& metric) { return impl_->SetSpec(metric); }
Status Remesher::SetField(std::unique_ptr<MetricField> field) {
  return impl_->SetField(std::move(field), nullptr);
}
Status Remesher::SetTensors(std::span<const VertexId> vertices, std::span<const Metric> tensors) {
  return impl_->SetTensors(vertices, tensors);
}
Status Remesher::Apply(MeshChange& change) { return impl_->Change(change); }
Result<Progress> Remesher::Step(const Budget& budget) { return impl_->Step(budget); }
void Remesher::UseHelpers(const Helpers& helpers) { impl_->UseHelpers(helpers); }
std::vector<Trouble> Remesher::FindTroubles() const { return impl_->FindTroubles(); }
MeshDiff Remesher::Commit() { return impl_->Commit(); }
MeshDiff Remesher::CommitAndTransfer() { return impl_->CommitAndTransfer(); }
Status Remesher::SetFields(const FieldUpdate& update) { return impl_->SetFields(update); }
void Remesher::Rollback() { impl_->Rollback(); }
MeshDiff Remesher::Snapshot() const { return impl_->Snapshot(); }
std::optional<RevisionDelta> Remesher::TakeUndo() { return impl_->TakeUndo(); }
RevisionDelta Remesher::InverseOf(const RevisionDelta& delta) const {
  return impl_->InverseOf(delta);
}
Result<MeshDiff> Remesher::Apply(const RevisionDelta& delta, Revision revision) {
  return impl_->Apply(delta, revision);
}
Result<Bytes> Remesher::Save() const { return impl_->Save(); }
Result<std::unique_ptr<Remesher>> Remesher::Load(std::span<const std::byte> bytes) {
  return Wrap(Impl::Load(bytes));
}
Result<RevisionDelta> Remesher::ReadDelta(std::span<const std::byte> bytes) const {
  return impl_->ReadDelta(bytes);
}
const Mesh& Remesher::mesh() const { return impl_->mesh(); }
const MetricField& Remesher::field() const { return impl_->field(); }
bool Remesher::building() const { return impl_->building(); }
Revision Remesher::revision() const { return impl_->revision(); }
const Options& Remesher::options() const { return impl_->options(); }
const FieldSet& Remesher::fields() const { return impl_->fields(); }

}  // namespace pliant
