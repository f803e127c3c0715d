#include "core/pliant/followed_metric.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <utility>

#include "core/mesh/export_mesh.h"
#include "core/mesh/star.h"
#include "core/metric/background_field.h"
#include "core/metric/overlay_field.h"

namespace pliant {
namespace {

Error TensorError(ErrorCode code, const char* field, std::size_t index, const std::string& what) {
  return {code, "entry " + std::to_string(index) + " of " + field + " " + what, field,
          static_cast<std::int64_t>(index)};
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

}  // namespace

std::vector<VertexId> LiveVertices(const Mesh& mesh) {
  std::vector<VertexId> vertices;
  vertices.reserve(static_cast<std::size_t>(mesh.vertex_count()));
  for (std::int32_t v = 0; v < mesh.vertex_slots(); ++v) {
    if (mesh.vertex(VertexId(v)).live) vertices.emplace_back(v);
  }
  return vertices;
}

Status FollowedMetric::Check(const MetricSpec& spec) { return CheckGradation(spec.gradation); }

void FollowedMetric::Follow(std::shared_ptr<MetricField> field, const MetricSpec* spec) {
  state_.raw = std::move(field);
  state_.limited = state_.raw;
  state_.spec.reset();
  state_.bounds = spec == nullptr ? SizeBounds{} : spec->bounds;
  state_.gradation = spec == nullptr ? GradationOptions{} : spec->gradation;
  if (spec != nullptr && !std::holds_alternative<BackgroundMetric>(spec->source)) {
    state_.spec = *spec;
  }
  state_.limit_rounds_left = limits() ? kLimitRounds : 0;
}

Status FollowedMetric::CheckTensors(std::span<const VertexId> vertices,
                                    std::span<const Metric> tensors) const {
  if (vertices.size() != tensors.size()) {
    return Error{ErrorCode::kArrayLength,
                 "there are " + std::to_string(tensors.size()) + " tensors for " +
                     std::to_string(vertices.size()) + " vertices; send one for each",
                 "metric.tensors"};
  }
  std::vector<bool> seen(static_cast<std::size_t>(mesh_.vertex_slots()), false);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const VertexId vertex = vertices[i];
    if (!mesh_.IsLive(vertex)) {
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

Result<WantedTensors> FollowedMetric::SetTensors(std::span<const VertexId> vertices,
                                                 std::span<const Metric> tensors) {
  WantedTensors wanted;
  wanted.tensors.reserve(tensors.size());
  bool same = true;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    wanted.tensors.push_back(Bound(tensors[i], state_.bounds));
    same = same && !Differs(RawMetric(vertices[i]), wanted.tensors.back());
  }
  if (same) return WantedTensors{};
  PLIANT_ASSIGN_OR_RETURN(state_.raw, FieldWith(vertices, wanted.tensors));
  state_.spec.reset();
  if (limits()) {
    state_.limit_rounds_left = kLimitRounds;
    return Limit();
  }
  state_.limited = state_.raw;
  wanted.vertices.assign(vertices.begin(), vertices.end());
  return wanted;
}

Result<WantedTensors> FollowedMetric::Carry(std::span<const VertexId> vertices,
                                            std::span<const Metric> tensors) {
  PLIANT_ASSIGN_OR_RETURN(state_.raw, FieldWith(vertices, tensors));
  state_.spec.reset();
  if (limits()) {
    state_.limit_rounds_left = kLimitRounds;
    return Limit();
  }
  state_.limited = state_.raw;
  return WantedTensors{};
}

/// The raw metric with other tensors at some vertices: laid over it if they are few, else as one
/// background mesh.
Result<std::shared_ptr<MetricField>> FollowedMetric::FieldWith(std::span<const VertexId> vertices,
                                                               std::span<const Metric> tensors) {
  const auto* overlay = dynamic_cast<const OverlayField*>(state_.raw.get());
  const std::size_t laid_count = overlay == nullptr ? 0 : overlay->triangle_count();
  const bool few = kOverlayShare * (laid_count + 6 * vertices.size()) <
                   static_cast<std::size_t>(mesh_.triangle_count());
  if (few && (overlay == nullptr || overlay->layer_count() < kOverlaysMax) && !limits()) {
    PLIANT_ASSIGN_OR_RETURN(
        std::shared_ptr<MetricField> laid,
        OverlayField::Lay(state_.raw, TensorsAround(mesh_, vertices, tensors), state_.bounds));
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
                          BackgroundField::Make(background, state_.bounds));
  return whole;
}

/// The metric as it was sent, at a vertex.
Metric FollowedMetric::RawMetric(VertexId vertex) {
  if (!limits()) return mesh_.metric(vertex);
  return state_.raw->At(mesh_.position(vertex), edit_.Hint(vertex));
}

Result<WantedTensors> FollowedMetric::Limit() {
  --state_.limit_rounds_left;
  ExportedMesh exported = ExportMesh(mesh_);
  std::vector<Metric> raw;
  raw.reserve(exported.vertex_ids.size());
  for (const VertexId vertex : exported.vertex_ids) raw.push_back(RawMetric(vertex));
  PLIANT_RETURN_IF_ERROR(state_.raw->status());
  const auto count = static_cast<std::int32_t>(raw.size());
  LimitedMetrics limited = LimitMetrics(GraphOfTriangles(exported.data.triangles, count),
                                        exported.data.points, raw, state_.gradation);
  WantedTensors wanted{std::move(exported.vertex_ids), limited.tensors};
  const BackgroundMetric background{std::move(exported.data), std::move(limited.tensors)};
  PLIANT_ASSIGN_OR_RETURN(state_.limited, BackgroundField::Make(background, {}));
  return wanted;
}

}  // namespace pliant
