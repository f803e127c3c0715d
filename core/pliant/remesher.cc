#include "core/pliant/remesher.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "core/delaunay/import_mesh.h"
#include "core/mesh/export_mesh.h"
#include "core/mesh/mesh_edit.h"
#include "core/mesh/star.h"
#include "core/metric/background_field.h"
#include "core/metric/gradation.h"
#include "core/metric/overlay_field.h"
#include "core/pliant/check_options.h"
#include "core/pliant/nested_build.h"

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

/// Tensors at few vertices are laid over the field that is there, until the layers have so many
/// triangles (one part in kOverlayShare of the mesh) or are so many that one new background mesh
/// is cheaper to ask.
constexpr std::size_t kOverlayShare = 8;
constexpr std::size_t kOverlaysMax = 16;

/// Passes of gradation in one update, the first before the loop runs.
constexpr int kLimitRounds = 3;

Status CheckGradation(const GradationOptions& gradation) {
  const auto check = [](const char* name, double value, double low) -> Status {
    if (value == 0 || (value >= low && value <= 10)) return {};
    std::ostringstream message;
    message << "metric." << name << " is " << value << "; expected 0 (off) or " << low << " to 10";
    return Error{ErrorCode::kOutOfRange, message.str(), std::string("metric.") + name};
  };
  PLIANT_RETURN_IF_ERROR(check("gradation", gradation.gradation, 1));
  return check("rotation", gradation.rotation, 0.1);
}

/// The triangles at some vertices as a background mesh: the given tensors there, the mesh's own at
/// the rim. @par Cost O(k log k) for k vertices
BackgroundMetric TensorsAround(const Mesh& mesh, std::span<const VertexId> vertices,
                               std::span<const Metric> tensors) {
  std::vector<TriangleId> triangles;
  Star star;
  for (const VertexId vertex : vertices) {
    for (const TriangleId fan : FansOf(mesh, vertex)) {
      star.Gather(mesh, vertex, fan);
      triangles.insert(triangles.end(), star.triangles().begin(), star.triangles().end());
    }
  }
  std::sort(triangles.begin(), triangles.end());
  triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
  std::vector<VertexId> corners;
  for (const TriangleId id : triangles) {
    const auto& v = mesh.triangle(id).vertices;
    corners.insert(corners.end(), v.begin(), v.end());
  }
  std::sort(corners.begin(), corners.end());
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());

  const auto dense = [&](VertexId vertex) {
    return static_cast<std::int32_t>(std::lower_bound(corners.begin(), corners.end(), vertex) -
                                     corners.begin());
  };
  BackgroundMetric around;
  for (const VertexId vertex : corners) {
    around.mesh.points.push_back(mesh.position(vertex));
    around.tensors.push_back(mesh.metric(vertex));
  }
  for (const TriangleId id : triangles) {
    const auto& v = mesh.triangle(id).vertices;
    around.mesh.triangles.push_back({dense(v[0]), dense(v[1]), dense(v[2])});
  }
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    around.tensors[static_cast<std::size_t>(dense(vertices[i]))] = tensors[i];
  }
  return around;
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
    PLIANT_RETURN_IF_ERROR(CheckGradation(spec.gradation));
    PLIANT_ASSIGN_OR_RETURN(std::unique_ptr<MetricField> field,
                            MakeMetricField(spec, BoxOf(plan->positions)));
    return Make(plan, numbering, std::move(field), &spec, options);
  }

  /// Gives every vertex its first metric and wakes it.
  Status Start(std::unique_ptr<MetricField> field, const MetricSpec* spec) {
    Follow(std::move(field), spec);
    following_.limited = following_.raw;
    if (options_.variant == Variant::kNested && numbering_ == Numbering::kClosesGaps &&
        options_.permissions == Permissions{}) {
      nested_.emplace(edit_, loop_, following_.raw, SettingsOf(options_));
    } else {
      loop_.BeginUpdate(SettingsOf(options_));
      for (const VertexId vertex : LiveVertices(mesh_)) {
        edit_.SetMetric(vertex, following_.raw->At(mesh_.position(vertex), edit_.Hint(vertex)));
        loop_.Wake(vertex);
      }
    }
    return following_.raw->status();
  }

  Status SetSpec(const MetricSpec& spec) {
    if (following_.spec.has_value() && *following_.spec == spec) return {};
    PLIANT_RETURN_IF_ERROR(CheckGradation(spec.gradation));
    PLIANT_ASSIGN_OR_RETURN(std::unique_ptr<MetricField> field, MakeMetricField(spec, box_));
    return SetField(std::move(field), &spec);
  }

  /// @param spec  what the field was made from; null for a field of the caller's own.
  Status SetField(std::unique_ptr<MetricField> field, const MetricSpec* spec) {
    const std::vector<VertexId> vertices = LiveVertices(mesh_);
    std::vector<Metric> tensors;
    tensors.reserve(vertices.size());
    for (const VertexId vertex : vertices) {
      tensors.push_back(field->At(mesh_.position(vertex), edit_.Hint(vertex)));
    }
    PLIANT_RETURN_IF_ERROR(field->status());
    LeaveNestedBuild();
    Follow(std::move(field), spec);
    if (following_.limits()) return Limit();
    following_.limited = following_.raw;
    Apply(vertices, tensors);
    return {};
  }

  Status SetTensors(std::span<const VertexId> given, std::span<const Metric> tensors) {
    const std::vector<VertexId> all = given.empty() ? LiveVertices(mesh_) : std::vector<VertexId>();
    const std::span<const VertexId> vertices = given.empty() ? std::span(all) : given;
    PLIANT_RETURN_IF_ERROR(CheckTensors(mesh_, vertices, tensors));
    LeaveNestedBuild();
    std::vector<Metric> bounded;
    bounded.reserve(tensors.size());
    bool same = true;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      bounded.push_back(Bound(tensors[i], following_.bounds));
      same = same && !Differs(RawMetric(vertices[i]), bounded.back());
    }
    if (same) return {};

    PLIANT_ASSIGN_OR_RETURN(following_.raw, FieldWith(vertices, bounded));
    following_.spec.reset();
    following_.limit_rounds_left = following_.limits() ? kLimitRounds : 0;
    if (following_.limits()) return Limit();
    following_.limited = following_.raw;
    Apply(vertices, bounded);
    return {};
  }

  /// The limits are laid on the mesh as it is when an update begins, which may be too coarse to
  /// know the metric; they are laid again on the mesh that comes out.
  Result<Progress> Step(Budget budget) {
    Progress progress;
    for (;;) {
      const std::int64_t visits_before = loop_.counts().visits;
      progress.stop_reason = loop_.Run(nested_ ? nested_->field() : *following_.limited, budget);
      PLIANT_RETURN_IF_ERROR(following_.raw->status());
      budget.visits_max -= loop_.counts().visits - visits_before;
      if (!Ended(progress.stop_reason)) break;
      if (nested_ && nested_->levels_left() > 0) {
        nested_->NextLevel();
        continue;
      }
      nested_.reset();
      if (following_.limit_rounds_left == 0) break;
      PLIANT_RETURN_IF_ERROR(Limit());
    }
    progress.active_count = loop_.active_count();
    progress.counts = loop_.counts();
    return progress;
  }

  MeshDiff Commit() {
    LeaveNestedBuild();
    PLIANT_CHECK(following_.raw->status().ok());
    if (revision_ == Revision::kNone && numbering_ == Numbering::kClosesGaps) {
      loop_.Renumber(edit_.Compact());
    }
    revision_ = Revision(static_cast<std::int64_t>(revision_) + 1);
    MeshDiff diff = edit_.Commit(revision_);
    loop_.ResetCounts();
    committed_ = {following_, loop_.Save()};
    return diff;
  }

  void Rollback() {
    PLIANT_CHECK(revision_ != Revision::kNone);
    edit_.Rollback();
    following_ = committed_.following;
    loop_.Restore(committed_.loop);
  }

  [[nodiscard]] const Mesh& mesh() const { return mesh_; }
  [[nodiscard]] const MetricField& field() const { return *following_.limited; }
  [[nodiscard]] Revision revision() const { return revision_; }
  [[nodiscard]] const Options& options() const { return options_; }

 private:
  /// The metric that the session follows.
  struct Following {
    std::shared_ptr<MetricField> raw;      // As it was sent, bounds applied.
    std::shared_ptr<MetricField> limited;  // What the loop sees: `raw` without gradation.
    std::optional<MetricSpec> spec;        // What `raw` was made from, if it can be compared.
    SizeBounds bounds;
    GradationOptions gradation;
    int limit_rounds_left = 0;

    [[nodiscard]] bool limits() const {
      return gradation.gradation != 0 || gradation.rotation != 0;
    }
  };

  /// What a rollback needs beyond the change log.
  struct Committed {
    Following following;
    PliantLoop::State loop;
  };

  /// The raw metric with other tensors at some vertices: laid over it if they are few, else as one
  /// background mesh.
  Result<std::shared_ptr<MetricField>> FieldWith(std::span<const VertexId> vertices,
                                                 std::span<const Metric> tensors) {
    const auto* overlay = dynamic_cast<const OverlayField*>(following_.raw.get());
    const std::size_t laid_count = overlay == nullptr ? 0 : overlay->triangle_count();
    const bool few = kOverlayShare * (laid_count + 6 * vertices.size()) <
                     static_cast<std::size_t>(mesh_.triangle_count());
    if (few && (overlay == nullptr || overlay->layer_count() < kOverlaysMax) &&
        !following_.limits()) {
      PLIANT_ASSIGN_OR_RETURN(
          std::shared_ptr<MetricField> laid,
          OverlayField::Lay(following_.raw, TensorsAround(mesh_, vertices, tensors),
                            following_.bounds));
      return laid;
    }
    const std::vector<VertexId> all = LiveVertices(mesh_);
    BackgroundMetric background{ExportMesh(mesh_).data, {}};
    background.tensors.reserve(all.size());
    for (const VertexId vertex : all) background.tensors.push_back(RawMetric(vertex));
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const auto dense = std::lower_bound(all.begin(), all.end(), vertices[i]) - all.begin();
      background.tensors[static_cast<std::size_t>(dense)] = tensors[i];
    }
    PLIANT_ASSIGN_OR_RETURN(std::shared_ptr<MetricField> whole,
                            BackgroundField::Make(background, following_.bounds));
    return whole;
  }

  static bool Ended(StopReason reason) {
    return reason == StopReason::kConverged || reason == StopReason::kVertexLimit;
  }

  /// @param spec  remembered to compare the next one with, unless it has a background mesh: that is
  ///              as large as the mesh, and comparing tensors at the vertices finds the same.
  void Follow(std::unique_ptr<MetricField> raw, const MetricSpec* spec) {
    following_.raw = std::move(raw);
    following_.spec.reset();
    following_.bounds = spec == nullptr ? SizeBounds{} : spec->bounds;
    following_.gradation = spec == nullptr ? GradationOptions{} : spec->gradation;
    if (spec != nullptr && !std::holds_alternative<BackgroundMetric>(spec->source)) {
      following_.spec = *spec;
    }
    following_.limit_rounds_left = following_.limits() ? kLimitRounds : 0;
  }

  /// The levels of the first build follow the metric that it began with, in the mesh's records too.
  void LeaveNestedBuild() {
    if (nested_) nested_->Finish();
    nested_.reset();
  }

  /// The metric as it was sent, at a vertex.
  [[nodiscard]] Metric RawMetric(VertexId vertex) {
    if (!following_.limits()) return mesh_.metric(vertex);
    return following_.raw->At(mesh_.position(vertex), edit_.Hint(vertex));
  }

  /// Limits the raw metric over the edges of the mesh and follows the result. Nodes that the raw
  /// metric kept busy until they were old get their visits back: it is another metric now.
  Status Limit() {
    --following_.limit_rounds_left;
    ExportedMesh exported = ExportMesh(mesh_);
    std::vector<Metric> raw;
    raw.reserve(exported.vertex_ids.size());
    for (const VertexId vertex : exported.vertex_ids) raw.push_back(RawMetric(vertex));
    PLIANT_RETURN_IF_ERROR(following_.raw->status());
    const auto count = static_cast<std::int32_t>(raw.size());
    LimitedMetrics limited = LimitMetrics(GraphOfTriangles(exported.data.triangles, count),
                                          exported.data.points, raw, following_.gradation);
    Apply(exported.vertex_ids, limited.tensors);
    const BackgroundMetric background{std::move(exported.data), std::move(limited.tensors)};
    PLIANT_ASSIGN_OR_RETURN(following_.limited, BackgroundField::Make(background, {}));
    return {};
  }

  [[nodiscard]] bool Differs(const Metric& old, const Metric& now) const {
    return !(now == old) && RelativeChange(old, now) > options_.metric_tolerance;
  }

  /// Takes over tensors that differ by more than the tolerance, and wakes their nodes. Smaller
  /// changes leave the old tensor in place, so that many of them add up and are seen at last.
  void Apply(std::span<const VertexId> vertices, std::span<const Metric> tensors) {
    loop_.BeginUpdate(SettingsOf(options_));
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      if (!Differs(mesh_.metric(vertices[i]), tensors[i])) continue;
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
  Following following_;
  std::optional<NestedBuild> nested_;  // While the first mesh is built from coarse to fine.
  Revision revision_ = Revision::kNone;
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

Result<Progress> Remesher::Step(const Budget& budget) { return impl_->Step(budget); }
MeshDiff Remesher::Commit() { return impl_->Commit(); }
void Remesher::Rollback() { impl_->Rollback(); }
const Mesh& Remesher::mesh() const { return impl_->mesh(); }
const MetricField& Remesher::field() const { return impl_->field(); }
Revision Remesher::revision() const { return impl_->revision(); }
const Options& Remesher::options() const { return impl_->options(); }

}  // namespace pliant
