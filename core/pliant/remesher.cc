#include "core/pliant/remesher.h"

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "core/pliant/check_options.h"
#include "core/pliant/remesher_impl.h"

namespace pliant {
Remesher::Impl::Impl(const MeshPlan& plan, Numbering numbering, const Options& options)
    : options_(options),
      edit_(mesh_),
      loop_(edit_, options),
      box_(BoxOf(plan.positions)),
      numbering_(numbering),
      followed_(edit_, options.metric_tolerance),
      frozen_(FrozenElements{}) {
  BuildFromPlan(plan, edit_);
}

Remesher::Impl::Impl(SavedSession snapshot)
    : options_(snapshot.loop.options),
      edit_(mesh_),
      loop_(edit_, options_),
      box_(snapshot.box),
      numbering_(Numbering::kKeeps),
      followed_(edit_, options_.metric_tolerance),
      revision_(snapshot.revision),
      committed_{std::move(snapshot.metric), std::move(snapshot.loop), snapshot.fields} {
  edit_.Restore(std::move(snapshot.mesh), revision_);
  (void)followed_.GoTo(committed_.followed, snapshot.raw, {});
  loop_.Restore(committed_.loop);
  RestoreFields();
}

Result<std::unique_ptr<Remesher::Impl>> Remesher::Impl::Make(const Result<MeshPlan>& plan,
                                                             Numbering numbering,
                                                             std::unique_ptr<MetricField> field,
                                                             const Options& options) {
  PLIANT_RETURN_IF_ERROR(CheckOptions(options));
  if (!plan.ok()) return plan.error();
  auto impl = std::make_unique<Impl>(*plan, numbering, options);
  PLIANT_RETURN_IF_ERROR(impl->Start(std::move(field), nullptr));
  return impl;
}

Result<std::unique_ptr<Remesher::Impl>> Remesher::Impl::MakeFromSpec(const Result<MeshPlan>& plan,
                                                                     Numbering numbering,
                                                                     const MetricSpec& spec,
                                                                     const Options& options) {
  if (!plan.ok()) return plan.error();
  PLIANT_RETURN_IF_ERROR(FollowedMetric::Check(spec));
  PLIANT_ASSIGN_OR_RETURN(std::unique_ptr<MetricField> field,
                          MakeMetricField(spec, BoxOf(plan->positions)));
  PLIANT_RETURN_IF_ERROR(CheckOptions(options));
  auto impl = std::make_unique<Impl>(*plan, numbering, options);
  PLIANT_RETURN_IF_ERROR(impl->Start(std::move(field), &spec));
  return impl;
}

Remesher::Remesher(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Remesher::~Remesher() = default;

Result<std::unique_ptr<Remesher>> Remesher::Wrap(Result<std::unique_ptr<Impl>> impl) {
  if (!impl.ok()) return impl.error();
  return std::unique_ptr<Remesher>(new Remesher(std::move(impl).value()));
}

Result<std::unique_ptr<Remesher>> Remesher::Create(const Domain& domain, const MetricSpec& metric,
                                                   const Options& options) {
  return Wrap(
      Impl::MakeFromSpec(PlanDomain(domain), Impl::Numbering::kClosesGaps, metric, options));
}

Result<std::unique_ptr<Remesher>> Remesher::Create(const MeshData& mesh, const MetricSpec& metric,
                                                   const Options& options) {
  return Wrap(Impl::MakeFromSpec(PlanImport(mesh), Impl::Numbering::kKeeps, metric, options));
}

Result<std::unique_ptr<Remesher>> Remesher::Create(const Domain& domain,
                                                   std::unique_ptr<MetricField> field,
                                                   const Options& options) {
  return Wrap(
      Impl::Make(PlanDomain(domain), Impl::Numbering::kClosesGaps, std::move(field), options));
}

Result<std::unique_ptr<Remesher>> Remesher::Create(const MeshData& mesh,
                                                   std::unique_ptr<MetricField> field,
                                                   const Options& options) {
  return Wrap(Impl::Make(PlanImport(mesh), Impl::Numbering::kKeeps, std::move(field), options));
}

Status Remesher::SetMetric(const MetricSpec& metric) { return impl_->SetSpec(metric); }
Status Remesher::SetField(std::unique_ptr<MetricField> field) {
  return impl_->SetField(std::move(field), nullptr);
}
Status Remesher::SetTensors(std::span<const VertexId> vertices, std::span<const Metric> tensors) {
  return impl_->SetTensors(vertices, tensors, {});
}
Status Remesher::SetTensors(std::span<const VertexId> vertices, std::span<const Metric> tensors,
                            const MetricLimits& limits) {
  return impl_->SetTensors(vertices, tensors, {&limits});
}
Status Remesher::SetTensors(std::span<const VertexId> vertices, std::span<const Metric> tensors,
                            const MetricLimits& limits, const FunctionsSpec& functions) {
  return impl_->SetTensors(vertices, tensors, {&limits, &functions});
}
Status Remesher::SetFunctions(const FunctionsSpec& functions, const MetricLimits& limits) {
  return impl_->SetFunctions(functions, limits);
}
Status Remesher::SetLimits(const MetricLimits& limits) { return impl_->SetLimits(limits); }
Status Remesher::Apply(MeshChange& change) { return impl_->Change(change); }
Status Remesher::SetConstraints(const Constraints& constraints) {
  return impl_->SetConstraints(constraints);
}
Status Remesher::SetOptions(const Options& options) { return impl_->SetOptions(options); }
Result<Progress> Remesher::Step(const Budget& budget) { return impl_->Step(budget); }
void Remesher::ListenTo(const StopSignal* stop) { impl_->ListenTo(stop); }
void Remesher::UseHelpers(const Helpers& helpers) { impl_->UseHelpers(helpers); }
TroubleSearch Remesher::WhereTroublesMayBe() const { return impl_->WhereTroublesMayBe(); }

std::vector<Trouble> Remesher::FindTroubles(const TroubleSearch& search) const {
  return impl_->FindTroubles(search);
}

std::vector<Trouble> Remesher::FindTroubles() const { return FindTroubles(WhereTroublesMayBe()); }
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
std::shared_ptr<const MetricField> Remesher::raw_field() const { return impl_->raw_field(); }
MetricLimits Remesher::limits() const { return impl_->limits(); }
const FunctionsSpec* Remesher::functions() const { return impl_->functions(); }
const MetricReport& Remesher::metric_report() const { return impl_->metric_report(); }
bool Remesher::building() const { return impl_->building(); }
Revision Remesher::revision() const { return impl_->revision(); }
const Options& Remesher::options() const { return impl_->options(); }
const FieldSet& Remesher::fields() const { return impl_->fields(); }

}  // namespace pliant
