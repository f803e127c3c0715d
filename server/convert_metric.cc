#include "server/convert_metric.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/metric/grid_metric.h"
#include "server/convert_array.h"
#include "server/convert_fields.h"
#include "server/convert_mesh.h"
#include "server/convert_motion.h"
#include "server/convert_request.h"
#include "server/limits.h"

namespace pliant::server {
namespace {

Status CheckExpression(const std::string& text, const std::string& field) {
  if (text.empty()) {
    return Error{ErrorCode::kEmpty, field + " is empty; an expression in x, y and t is needed",
                 field};
  }
  if (text.size() > kExpressionLengthMax) {
    return Error{ErrorCode::kTooLarge,
                 field + " has " + std::to_string(text.size()) + " characters; allowed are " +
                     std::to_string(kExpressionLengthMax),
                 field};
  }
  return {};
}

Result<std::vector<Metric>> ReadTensors(const v1::Array& array, std::size_t count) {
  PLIANT_ASSIGN_OR_RETURN(std::vector<Metric> tensors, ReadRows<Metric>(array, "metric.tensors"));
  if (tensors.size() != count) {
    return Error{ErrorCode::kArrayLength,
                 "metric.tensors has " + std::to_string(tensors.size()) + " rows; expected " +
                     std::to_string(count) + ", one for each vertex",
                 "metric.tensors"};
  }
  return tensors;
}

Result<BackgroundMetric> ConvertGrid(const v1::GridMetric& wire) {
  if (wire.column_count() < 0) {
    return RangeError("metric.grid.column_count is negative", "metric.grid.column_count");
  }
  GridMetric grid{.origin = {wire.origin_x(), wire.origin_y()},
                  .step = {wire.step_x(), wire.step_y()},
                  .column_count = static_cast<std::size_t>(wire.column_count()),
                  .tensors = {}};
  PLIANT_ASSIGN_OR_RETURN(grid.tensors, ReadRows<Metric>(wire.tensors(), "metric.grid.tensors"));
  return ToBackground(std::move(grid));
}

// A source that is a field over the plane; VertexMetric is not.
Result<PlainMetric> ConvertSource(const v1::MetricSource& wire) {
  switch (wire.source_case()) {
    case v1::MetricSource::kExpression: {
      const v1::ExpressionMetric& e = wire.expression();
      PLIANT_RETURN_IF_ERROR(CheckExpression(e.m11(), "metric.m11"));
      PLIANT_RETURN_IF_ERROR(CheckExpression(e.m12(), "metric.m12"));
      PLIANT_RETURN_IF_ERROR(CheckExpression(e.m22(), "metric.m22"));
      return PlainMetric(ExpressionMetric{e.m11(), e.m12(), e.m22()});
    }
    case v1::MetricSource::kSize:
      PLIANT_RETURN_IF_ERROR(CheckExpression(wire.size().size(), "metric.size"));
      return PlainMetric(SizeMetric{wire.size().size()});
    case v1::MetricSource::kBackground: {
      BackgroundMetric background;
      PLIANT_ASSIGN_OR_RETURN(background.mesh,
                              ConvertMesh(wire.background().mesh(), "metric.background.mesh"));
      PLIANT_ASSIGN_OR_RETURN(background.tensors, ReadTensors(wire.background().tensors(),
                                                              background.mesh.points.size()));
      return PlainMetric(std::move(background));
    }
    case v1::MetricSource::kVertices:
      return Error{ErrorCode::kProtocolOrder,
                   "tensors at vertices need vertices: create the session from a mesh, or give "
                   "another metric first and send tensors once there is a revision",
                   "metric.sources"};
    case v1::MetricSource::kGrid: {
      PLIANT_ASSIGN_OR_RETURN(BackgroundMetric background, ConvertGrid(wire.grid()));
      return PlainMetric(std::move(background));
    }
    case v1::MetricSource::kDistance:
      return NotYet("A metric by distance", "metric.sources");
    case v1::MetricSource::kSolution:
      return Error{ErrorCode::kProtocolOrder,
                   "a solution needs vertices: give another metric first and the solution once "
                   "there is a revision",
                   "metric.sources"};
    case v1::MetricSource::SOURCE_NOT_SET:
      break;
  }
  return Error{ErrorCode::kEmpty, "the metric source has no kind", "metric.sources"};
}

Result<MetricUpdate> ConvertLimits(const v1::MetricUpdate& wire) {
  MetricUpdate update;
  if (wire.has_time()) {
    if (!std::isfinite(wire.time())) {
      return Error{ErrorCode::kNotFinite, "metric.time is NaN or infinite", "metric.time"};
    }
    update.time = wire.time();
  }
  const v1::MetricLimits& limits = wire.limits();
  if (limits.has_size_min()) update.size_min = limits.size_min();
  if (limits.has_size_max()) update.size_max = limits.size_max();
  if (limits.has_anisotropy_max()) update.anisotropy_max = limits.anisotropy_max();
  if (limits.has_gradation()) update.gradation = limits.gradation();
  if (limits.has_rotation()) update.rotation = limits.rotation();
  if (limits.has_geometry()) update.geometry = limits.geometry();
  if (limits.has_gap_element_count()) update.gap_element_count = limits.gap_element_count();
  if (limits.has_smoothing_count()) update.smoothing_count = limits.smoothing_count();
  // Who chooses limits has chosen.
  if (limits.has_gradation() || limits.has_rotation()) update.automatic = false;
  if (limits.has_automatic()) update.automatic = limits.automatic();
  return update;
}

// Values at the vertices of a session's mesh.
bool IsAtVertices(const v1::MetricSource& source) {
  return source.has_vertices() || source.has_solution();
}

// Tensors at all points of the mesh that a session is created from.
Result<BackgroundMetric> ConvertFirstTensors(const v1::VertexMetric& wire, const MeshData& mesh) {
  if (wire.revision() != 0 || wire.has_vertex_ids()) {
    return RangeError(
        "at creation, tensors are those of all points of the mesh: leave out revision and "
        "vertex_ids",
        "metric.vertex_ids");
  }
  PLIANT_ASSIGN_OR_RETURN(std::vector<Metric> tensors,
                          ReadTensors(wire.tensors(), mesh.points.size()));
  return BackgroundMetric{mesh, std::move(tensors)};
}

Status CheckSourceCount(const v1::MetricUpdate& wire) {
  constexpr auto kPartsMax = static_cast<int>(IntersectedMetric::kPartsMax);
  if (wire.sources_size() <= kPartsMax) return {};
  return Error{ErrorCode::kTooLarge,
               std::to_string(wire.sources_size()) + " metric sources; allowed are " +
                   std::to_string(kPartsMax),
               "metric.sources"};
}

// The sources of which `takes` is true. `first_mesh` is what a session is created from, if it is a
// mesh: it knows tensors at vertices too.
template <class Takes>
Result<std::vector<PlainMetric>> ConvertSources(const v1::MetricUpdate& wire,
                                                const MeshData* first_mesh, Takes takes) {
  PLIANT_RETURN_IF_ERROR(CheckSourceCount(wire));
  std::vector<PlainMetric> parts;
  for (int i = 0; i < wire.sources_size(); ++i) {
    const v1::MetricSource& source = wire.sources(i);
    if (!takes(source)) continue;
    const auto convert = [&]() -> Result<PlainMetric> {
      if (!source.has_vertices() || first_mesh == nullptr) return ConvertSource(source);
      PLIANT_ASSIGN_OR_RETURN(BackgroundMetric tensors,
                              ConvertFirstTensors(source.vertices(), *first_mesh));
      return PlainMetric(std::move(tensors));
    };
    Result<PlainMetric> part = convert();
    if (!part.ok()) {
      Error error = part.error();
      error.message = "metric.sources[" + std::to_string(i) + "]: " + error.message;
      return error;
    }
    parts.push_back(std::move(*part));
  }
  return parts;
}

Result<VertexTensors> ConvertVertexMetric(const v1::VertexMetric& wire) {
  VertexTensors update;
  update.revision = Revision(wire.revision());
  if (!wire.has_vertex_ids()) {
    PLIANT_ASSIGN_OR_RETURN(update.tensors, ReadRows<Metric>(wire.tensors(), "metric.tensors"));
    return update;
  }
  PLIANT_ASSIGN_OR_RETURN(update.vertices,
                          ReadRows<VertexId>(wire.vertex_ids(), "metric.vertex_ids"));
  PLIANT_ASSIGN_OR_RETURN(update.tensors, ReadTensors(wire.tensors(), update.vertices->size()));
  return update;
}

// What is wanted, of one source.
Status ConvertOneSource(const v1::MetricSource& source, MetricUpdate& update) {
  if (source.has_vertices()) {
    PLIANT_ASSIGN_OR_RETURN(update.source, ConvertVertexMetric(source.vertices()));
  } else if (source.has_solution()) {
    PLIANT_ASSIGN_OR_RETURN(update.source, ConvertSolution(source.solution()));
  } else {
    PLIANT_ASSIGN_OR_RETURN(PlainMetric field, ConvertSource(source));
    std::visit([&](auto& value) { update.source = std::move(value); }, field);
  }
  return {};
}

// Of several: at most one of them has values at vertices, and the others are functions beside it.
Status ConvertManySources(const v1::MetricUpdate& wire, MetricUpdate& update) {
  const auto at_vertices = std::ranges::find_if(wire.sources(), IsAtVertices);
  PLIANT_ASSIGN_OR_RETURN(
      std::vector<PlainMetric> parts,
      ConvertSources(wire, nullptr, [](const auto& source) { return !IsAtVertices(source); }));
  if (at_vertices == wire.sources().end()) {
    update.source = IntersectedMetric{std::move(parts)};
    return {};
  }
  if (std::ssize(parts) + 1 < wire.sources_size()) {
    return NotYet("More than one of `vertices` and `solution` among the metric sources",
                  "metric.sources");
  }
  update.functions =
      FunctionsSpec{.parts = std::move(parts),
                    .before_count = static_cast<std::size_t>(at_vertices - wire.sources().begin())};
  return ConvertOneSource(*at_vertices, update);
}

}  // namespace

Result<MetricSpec> ConvertFirstMetric(const v1::CreateSession& create,
                                      const std::variant<Domain, MeshData>& start) {
  MetricSpec spec;
  const v1::MetricUpdate& metric = create.metric();
  if (metric.sources_size() == 0) {
    return Error{ErrorCode::kEmpty, "a session needs a metric: set metric.sources",
                 "metric.sources"};
  }
  if (create.metric().has_displacement()) return NotYet("A displacement", "metric.displacement");
  const MeshData* mesh = std::get_if<MeshData>(&start);
  if (metric.sources_size() > 1) {
    const auto all = [](const v1::MetricSource&) { return true; };
    PLIANT_ASSIGN_OR_RETURN(std::vector<PlainMetric> parts, ConvertSources(metric, mesh, all));
    spec.source = IntersectedMetric{std::move(parts)};
  } else if (metric.sources(0).has_vertices() && mesh != nullptr) {
    PLIANT_ASSIGN_OR_RETURN(spec.source, ConvertFirstTensors(metric.sources(0).vertices(), *mesh));
  } else {
    PLIANT_ASSIGN_OR_RETURN(PlainMetric source, ConvertSource(metric.sources(0)));
    std::visit([&](auto& value) { spec.source = std::move(value); }, source);
  }
  PLIANT_ASSIGN_OR_RETURN(const MetricUpdate limits, ConvertLimits(create.metric()));
  spec.time = limits.time.value_or(0);
  spec.bounds = {.size_min = limits.size_min.value_or(0),
                 .size_max = limits.size_max.value_or(0),
                 .anisotropy_max = limits.anisotropy_max.value_or(0)};
  spec.gradation = {.gradation = limits.gradation.value_or(0),
                    .rotation = limits.rotation.value_or(0),
                    .geometry = limits.geometry.value_or(0),
                    .gap_element_count = limits.gap_element_count.value_or(0),
                    .smoothing_count = limits.smoothing_count.value_or(0),
                    .automatic = limits.automatic.value_or(true)};
  return spec;
}

Result<MetricUpdate> ConvertMetricUpdate(const v1::MetricUpdate& wire) {
  PLIANT_ASSIGN_OR_RETURN(MetricUpdate update, ConvertLimits(wire));
  if (wire.has_displacement()) {
    if (std::ranges::any_of(wire.sources(), &v1::MetricSource::has_solution)) {
      return NotYet("A displacement together with a solution", "metric.displacement");
    }
    PLIANT_ASSIGN_OR_RETURN(update.displacement, ConvertDisplacement(wire.displacement()));
  }
  if (wire.sources_size() == 1) {
    PLIANT_RETURN_IF_ERROR(ConvertOneSource(wire.sources(0), update));
  } else if (wire.sources_size() > 1) {
    PLIANT_RETURN_IF_ERROR(ConvertManySources(wire, update));
  }
  return update;
}

}  // namespace pliant::server
