#include "core/pliant/remesher.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/delaunay/import_mesh.h"
#include "core/mesh/export_mesh.h"
#include "core/mesh/mesh_edit.h"
#include "core/pliant/check_options.h"

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

/// Live vertices, for a request that names none.
std::vector<VertexId> LiveVertices(const Mesh& mesh) {
  std::vector<VertexId> vertices;
  vertices.reserve(static_cast<std::size_t>(mesh.vertex_count()));
  for (std::int32_t v = 0; v < mesh.vertex_slots(); ++v) {
    if (mesh.vertex(VertexId(v)).live) vertices.emplace_back(v);
  }
  return vertices;
}

Error TensorError(ErrorCode code, const char* field, std::size_t index, const std::string& what) {
  return {code, "entry " + std::to_string(index) + " of " + field + " " + what, field,
          static_cast<std::int64_t>(index)};
}

Status CheckTensors(const Mesh& mesh, std::span<const VertexId> vertices,
                    std::span<const Metric> tensors) {
  if (vertices.size() != tensors.size()) {
    return Error{ErrorCode::kArrayLength,
                 "there are " + std::to_string(tensors.size()) + " tensors for " +
                     std::to_string(vertices.size()) + " vertices; send one for each",
                 "metric.tensors"};
  }
  std::vector<bool> seen(static_cast<std::size_t>(mesh.vertex_slots()), false);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const VertexId vertex = vertices[i];
    if (!mesh.IsLive(vertex)) {
      return TensorError(
          ErrorCode::kIndexOutOfRange, "metric.vertex_ids", i,
          "is " + std::to_string(vertex.value()) + ", which is no vertex of this revision");
    }
    if (seen[vertex.index()]) {
      return TensorError(ErrorCode::kDuplicateId, "metric.vertex_ids", i,
                         "names vertex " + std::to_string(vertex.value()) + " a second time");
    }
    seen[vertex.index()] = true;
    if (!IsFinite(tensors[i])) {
      return TensorError(ErrorCode::kNotFinite, "metric.tensors", i, "is NaN or infinite");
    }
    if (!IsPositiveDefinite(tensors[i])) {
      return TensorError(ErrorCode::kNotPositiveDefinite, "metric.tensors", i,
                         "is not positive definite; m11, m22 and m11 m22 - m12^2 must be > 0");
    }
  }
  return {};
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
        numbering_(numbering) {
    BuildFromPlan(plan, edit_);
  }

  static Result<std::unique_ptr<Impl>> Make(const Result<MeshPlan>& plan, Numbering numbering,
                                            std::unique_ptr<MetricField> field,
                                            const Options& options) {
    PLIANT_RETURN_IF_ERROR(CheckOptions(options));
    if (!plan.ok()) return plan.error();
    auto impl = std::make_unique<Impl>(*plan, numbering, options);
    PLIANT_RETURN_IF_ERROR(impl->Start(std::move(field)));
    return impl;
  }

  static Result<std::unique_ptr<Impl>> MakeFromSpec(const Result<MeshPlan>& plan,
                                                    Numbering numbering, const MetricSpec& spec,
                                                    const Options& options) {
    if (!plan.ok()) return plan.error();
    PLIANT_ASSIGN_OR_RETURN(std::unique_ptr<MetricField> field,
                            MakeMetricField(spec, BoxOf(plan->positions)));
    PLIANT_ASSIGN_OR_RETURN(std::unique_ptr<Impl> impl,
                            Make(plan, numbering, std::move(field), options));
    impl->RememberSpec(spec);
    return impl;
  }

  /// Gives every vertex its first metric and wakes it.
  Status Start(std::unique_ptr<MetricField> field) {
    loop_.BeginUpdate();
    update_open_ = true;
    for (const VertexId vertex : LiveVertices(mesh_)) {
      edit_.SetMetric(vertex, field->At(mesh_.position(vertex), edit_.Hint(vertex)));
      loop_.Wake(vertex);
    }
    field_ = std::move(field);
    return field_->status();
  }

  Status SetSpec(const MetricSpec& spec) {
    if (spec_.has_value() && *spec_ == spec) return {};
    PLIANT_ASSIGN_OR_RETURN(std::unique_ptr<MetricField> field, MakeMetricField(spec, box_));
    PLIANT_RETURN_IF_ERROR(SetField(std::move(field)));
    RememberSpec(spec);
    return {};
  }

  /// A specification to compare the next one with. One with a background mesh is as large as the
  /// mesh and not worth keeping: comparing tensors at the vertices finds the same.
  void RememberSpec(const MetricSpec& spec) {
    bounds_ = spec.bounds;
    spec_.reset();
    if (!std::holds_alternative<BackgroundMetric>(spec.source)) spec_ = spec;
  }

  Status SetField(std::unique_ptr<MetricField> field) {
    const std::vector<VertexId> vertices = LiveVertices(mesh_);
    std::vector<Metric> tensors;
    tensors.reserve(vertices.size());
    for (const VertexId vertex : vertices) {
      tensors.push_back(field->At(mesh_.position(vertex), edit_.Hint(vertex)));
    }
    PLIANT_RETURN_IF_ERROR(field->status());
    field_ = std::move(field);
    spec_.reset();
    Apply(vertices, tensors);
    return {};
  }

  Status SetTensors(std::span<const VertexId> given, std::span<const Metric> tensors) {
    const std::vector<VertexId> all = given.empty() ? LiveVertices(mesh_) : std::vector<VertexId>();
    const std::span<const VertexId> vertices = given.empty() ? std::span(all) : given;
    PLIANT_RETURN_IF_ERROR(CheckTensors(mesh_, vertices, tensors));
    std::vector<Metric> bounded;
    bounded.reserve(tensors.size());
    bool same = true;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      bounded.push_back(Bound(tensors[i], bounds_));
      same = same && bounded.back() == mesh_.metric(vertices[i]);
    }
    if (same) return {};

    ExportedMesh exported = ExportMesh(mesh_);
    BackgroundMetric background;
    std::vector<std::size_t> dense(static_cast<std::size_t>(mesh_.vertex_slots()), 0);
    for (std::size_t i = 0; i < exported.vertex_ids.size(); ++i) {
      dense[exported.vertex_ids[i].index()] = i;
      background.tensors.push_back(mesh_.metric(exported.vertex_ids[i]));
    }
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      background.tensors[dense[vertices[i].index()]] = bounded[i];
    }
    background.mesh = std::move(exported.data);
    MetricSpec spec;
    spec.source = std::move(background);
    spec.bounds = bounds_;
    PLIANT_ASSIGN_OR_RETURN(field_, MakeMetricField(spec, box_));
    spec_.reset();
    Apply(vertices, bounded);
    return {};
  }

  Result<Progress> Step(const Budget& budget) {
    Progress progress;
    progress.stop_reason = loop_.Run(*field_, budget);
    PLIANT_RETURN_IF_ERROR(field_->status());
    progress.active_count = loop_.active_count();
    progress.counts = loop_.counts();
    return progress;
  }

  MeshDiff Commit() {
    PLIANT_CHECK(field_->status().ok());
    if (revision_ == Revision::kNone && numbering_ == Numbering::kClosesGaps) {
      loop_.Renumber(edit_.Compact());
    }
    revision_ = Revision(static_cast<std::int64_t>(revision_) + 1);
    MeshDiff diff = edit_.Commit(revision_);
    loop_.ResetCounts();
    update_open_ = false;
    committed_ = {field_, spec_, bounds_, loop_.Save()};
    return diff;
  }

  void Rollback() {
    PLIANT_CHECK(revision_ != Revision::kNone);
    edit_.Rollback();
    field_ = committed_.field;
    spec_ = committed_.spec;
    bounds_ = committed_.bounds;
    loop_.Restore(committed_.loop);
    update_open_ = false;
  }

  [[nodiscard]] const Mesh& mesh() const { return mesh_; }
  [[nodiscard]] const MetricField& field() const { return *field_; }
  [[nodiscard]] Revision revision() const { return revision_; }
  [[nodiscard]] const Options& options() const { return options_; }

 private:
  /// What a rollback needs beyond the change log.
  struct Committed {
    std::shared_ptr<MetricField> field;
    std::optional<MetricSpec> spec;
    SizeBounds bounds;
    PliantLoop::State loop;
  };

  /// Takes over tensors that differ by more than the tolerance, and wakes their nodes. Smaller
  /// changes leave the old tensor in place, so that many of them add up and are seen at last.
  void Apply(std::span<const VertexId> vertices, std::span<const Metric> tensors) {
    if (!update_open_) loop_.BeginUpdate();
    update_open_ = true;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const Metric& old = mesh_.metric(vertices[i]);
      if (tensors[i] == old || RelativeChange(old, tensors[i]) <= options_.metric_tolerance) {
        continue;
      }
      edit_.SetMetric(vertices[i], tensors[i]);
      loop_.Wake(vertices[i]);
    }
  }

  const Options options_;
  Mesh mesh_;
  MeshEdit edit_;
  PliantLoop loop_;
  const BoundingBox box_;
  const Numbering numbering_;
  std::shared_ptr<MetricField> field_;
  std::optional<MetricSpec> spec_;  // What field_ was made from, if it can be compared.
  SizeBounds bounds_;
  Revision revision_ = Revision::kNone;
  bool update_open_ = false;
  Committed committed_;
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
  return Wrap(Impl::Make(PlanDomain(domain), Numbering::kClosesGaps, std::move(field), options));
}

Result<std::unique_ptr<Remesher>> Remesher::Create(const MeshData& mesh,
                                                   std::unique_ptr<MetricField> field,
                                                   const Options& options) {
  return Wrap(Impl::Make(PlanImport(mesh), Numbering::kKeeps, std::move(field), options));
}

Status Remesher::SetMetric(const MetricSpec& metric) { return impl_->SetSpec(metric); }

Status Remesher::SetField(std::unique_ptr<MetricField> field) {
  return impl_->SetField(std::move(field));
}

Status Remesher::SetTensors(std::span<const VertexId> vertices, std::span<const Metric> tensors) {
  return impl_->SetTensors(vertices, tensors);
}

Result<Progress> Remesher::Step(const Budget& budget) { return impl_->Step(budget); }
MeshDiff Remesher::Commit() { return impl_->Commit(); }
void Remesher::Rollback() { impl_->Rollback(); }
const Mesh& Remesher::mesh() const { return impl_->mesh(); }
const MetricField& Remesher::field() const { return impl_->field(); }
Revision Remesher::revision() const { return impl_->revision(); }
const Options& Remesher::options() const { return impl_->options(); }

}  // namespace pliant
