// FollowedMetric, the part that refuses what cannot be followed.

#include <algorithm>
#include <functional>
#include <sstream>
#include <string>

#include "core/mesh/place_map.h"
#include "core/metric/tensor_smoothing.h"
#include "core/pliant/followed_metric.h"

namespace pliant {
namespace {

Error TensorError(ErrorCode code, const char* field, std::size_t index, const std::string& what) {
  return {code, "entry " + std::to_string(index) + " of " + field + " " + what, field,
          static_cast<std::int64_t>(index)};
}

Status CheckGradation(const GradationOptions& gradation) {
  const auto check = [](const char* name, double value, double low, double high) -> Status {
    if (value == 0 || (value >= low && value <= high)) return {};
    std::ostringstream message;
    message << "metric.limits." << name << " is " << value << "; expected 0 (off) or " << low
            << " to " << high;
    return Error{ErrorCode::kOutOfRange, message.str(), std::string("metric.limits.") + name};
  };
  PLIANT_RETURN_IF_ERROR(check("gradation", gradation.gradation, 1, 10));
  PLIANT_RETURN_IF_ERROR(check("rotation", gradation.rotation, 0.1, 10));
  PLIANT_RETURN_IF_ERROR(check("geometry", gradation.geometry, 0.1, 10));
  PLIANT_RETURN_IF_ERROR(check("gap_element_count", gradation.gap_element_count, 0.5, 100));
  constexpr std::int32_t kPassesMax = TensorSmoothing::kPassesMax;
  if (gradation.smoothing_count >= 0 && gradation.smoothing_count <= kPassesMax) return {};
  return Error{ErrorCode::kOutOfRange,
               "metric.limits.smoothing_count is " + std::to_string(gradation.smoothing_count) +
                   "; expected 0 (off) to " + std::to_string(kPassesMax),
               "metric.limits.smoothing_count"};
}

/// Refuses a vertex that is named twice.
Status CheckDuplicates(const Mesh& mesh, std::span<const VertexId> vertices,
                       const StopSignal* stop) {
  if (std::ranges::adjacent_find(vertices, std::greater_equal()) == vertices.end()) return {};
  PlaceMap seen(mesh.vertex_slots());
  seen.Reserve(vertices.size());
  StopPoll stopped(stop);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (stopped()) return Stopped();
    if (!seen.Add(vertices[i], 0)) {
      return TensorError(ErrorCode::kDuplicateId, "metric.vertex_ids", i,
                         "names vertex " + std::to_string(vertices[i].value()) + " a second time");
    }
  }
  return {};
}

}  // namespace

Status FollowedMetric::Check(const MetricSpec& spec) { return CheckGradation(spec.gradation); }

Status FollowedMetric::Check(const MetricLimits& limits) {
  PLIANT_RETURN_IF_ERROR(CheckBounds(limits.bounds));
  return CheckGradation(limits.gradation);
}

Status CheckTensorsAt(const Mesh& mesh, std::span<const VertexId> vertices,
                      std::span<const Metric> tensors, const StopSignal* stop) {
  if (vertices.size() != tensors.size()) {
    return Error{ErrorCode::kArrayLength,
                 "there are " + std::to_string(tensors.size()) + " tensors for " +
                     std::to_string(vertices.size()) + " vertices; send one for each",
                 "metric.tensors"};
  }
  StopPoll stopped(stop);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (stopped()) return Stopped();
    if (!mesh.IsLive(vertices[i])) {
      return TensorError(
          ErrorCode::kIndexOutOfRange, "metric.vertex_ids", i,
          "is " + std::to_string(vertices[i].value()) + ", which is no vertex of this revision");
    }
    if (!IsFinite(tensors[i])) {
      return TensorError(ErrorCode::kNotFinite, "metric.tensors", i, "is NaN or infinite");
    }
    if (!IsPositiveDefinite(tensors[i])) {
      return TensorError(ErrorCode::kNotPositiveDefinite, "metric.tensors", i,
                         "is not positive definite; m11, m22 and m11 m22 - m12^2 must be > 0");
    }
  }
  return CheckDuplicates(mesh, vertices, stop);
}

Status FollowedMetric::CheckAtVertices(const MetricFunctions& functions,
                                       const StopSignal* stop) const {
  const std::vector<VertexId> vertices = LiveVertices(mesh_);
  for (std::size_t begin = 0; begin < vertices.size(); begin += StopPoll::kPeriod) {
    if (stop != nullptr && stop->asked()) return Stopped();
    const std::size_t end = std::min<std::size_t>(begin + StopPoll::kPeriod, vertices.size());
    std::vector<Vec2> points;
    std::vector<Metric> tensors;
    for (std::size_t i = begin; i < end; ++i) {
      points.push_back(mesh_.position(vertices[i]));
      tensors.push_back(mesh_.metric(vertices[i]));
    }
    functions.MeetEach(points, tensors);
  }
  return functions.status();
}

}  // namespace pliant
