#include "server/convert.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "core/metric/grid_metric.h"
#include "server/convert_array.h"
#include "server/convert_fields.h"
#include "server/convert_mesh.h"
#include "server/convert_motion.h"
#include "server/convert_request.h"
#include "server/limits.h"

namespace pliant::server {
namespace {

// --- Metrics ----------------------------------------------------------------------------------

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

Result<IntersectedMetric> ConvertSources(const v1::MetricUpdate& wire) {
  constexpr auto kPartsMax = static_cast<int>(IntersectedMetric::kPartsMax);
  if (wire.sources_size() > kPartsMax) {
    return Error{ErrorCode::kTooLarge,
                 std::to_string(wire.sources_size()) + " metric sources; allowed are " +
                     std::to_string(kPartsMax),
                 "metric.sources"};
  }
  IntersectedMetric intersected;
  for (const v1::MetricSource& source : wire.sources()) {
    if (source.has_vertices() || source.has_solution()) {
      return NotYet("Tensors at vertices or a solution among several metric sources",
                    "metric.sources");
    }
    Result<PlainMetric> part = ConvertSource(source);
    if (!part.ok()) {
      Error error = part.error();
      error.message =
          "metric.sources[" + std::to_string(intersected.parts.size()) + "]: " + error.message;
      return error;
    }
    intersected.parts.push_back(std::move(*part));
  }
  return intersected;
}

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
    PLIANT_ASSIGN_OR_RETURN(spec.source, ConvertSources(metric));
  } else if (metric.sources(0).has_vertices() && mesh != nullptr) {
    const v1::VertexMetric& vertices = metric.sources(0).vertices();
    if (vertices.revision() != 0 || vertices.has_vertex_ids()) {
      return RangeError(
          "at creation, tensors are those of all points of the mesh: leave out revision and "
          "vertex_ids",
          "metric.vertex_ids");
    }
    PLIANT_ASSIGN_OR_RETURN(std::vector<Metric> tensors,
                            ReadTensors(vertices.tensors(), mesh->points.size()));
    spec.source = BackgroundMetric{*mesh, std::move(tensors)};
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

// --- Sessions ---------------------------------------------------------------------------------

Result<std::optional<Durability>> DurabilityOf(const v1::SessionOptions& wire) {
  if (!wire.has_durability()) return std::optional<Durability>();
  PLIANT_ASSIGN_OR_RETURN(const Durability durability,
                          ConvertDurability(wire.durability(), "options.durability"));
  return std::optional(durability);
}

}  // namespace

Result<SessionInput> ConvertCreate(const v1::CreateSession& create, const RequestLimits& limits) {
  SessionInput input;
  if (!create.session_id().empty()) PLIANT_RETURN_IF_ERROR(CheckSessionId(create.session_id()));
  input.session_id = create.session_id();
  input.labels.insert(create.labels().begin(), create.labels().end());
  PLIANT_RETURN_IF_ERROR(CheckLabels(input.labels));
  if (create.has_domain()) {
    PLIANT_ASSIGN_OR_RETURN(input.engine.start, ConvertDomain(create.domain()));
  } else if (create.has_mesh()) {
    PLIANT_ASSIGN_OR_RETURN(input.engine.start, ConvertMesh(create.mesh(), "mesh"));
  } else {
    return Error{ErrorCode::kEmpty, "a session starts from a domain or a mesh: set one", "domain"};
  }
  PLIANT_ASSIGN_OR_RETURN(input.engine.metric, ConvertFirstMetric(create, input.engine.start));
  PLIANT_ASSIGN_OR_RETURN(input.engine.options, ConvertOptions(create.options(), limits));
  PLIANT_ASSIGN_OR_RETURN(input.durability, DurabilityOf(create.options()));
  const std::size_t point_count =
      std::visit([](const auto& start) { return start.points.size(); }, input.engine.start);
  if (point_count > static_cast<std::size_t>(input.engine.options.vertices_max)) {
    return Error{ErrorCode::kTooLarge,
                 std::to_string(point_count) + " points; options.vertices_max is " +
                     std::to_string(input.engine.options.vertices_max),
                 create.has_domain() ? "domain.points" : "mesh.points"};
  }
  return input;
}

Result<Durability> ConvertDurability(v1::Durability durability, const std::string& field) {
  switch (durability) {
    case v1::DURABILITY_NONE:
      return Durability::kNone;
    case v1::DURABILITY_RELAXED:
      return Durability::kRelaxed;
    case v1::DURABILITY_STRICT:
      return Durability::kStrict;
    default:
      return RangeError(field + " is no known durability", field);
  }
}

Status CheckLabels(const std::map<std::string, std::string>& labels) {
  if (labels.size() > kLabelsMax) {
    return Error{
        ErrorCode::kTooLarge,
        std::to_string(labels.size()) + " labels; allowed are " + std::to_string(kLabelsMax),
        "labels"};
  }
  for (const auto& [key, value] : labels) {
    if (key.empty() || key.size() > kLabelLengthMax || value.size() > kLabelLengthMax) {
      return Error{ErrorCode::kTooLarge,
                   "a label's key has 1 to " + std::to_string(kLabelLengthMax) +
                       " bytes and its value at most as many",
                   "labels"};
    }
  }
  return {};
}

Status CheckSessionId(const std::string& session_id) {
  constexpr std::string_view kAllowed =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_.-";
  if (!session_id.empty() && session_id.size() <= kSessionIdLengthMax &&
      session_id.find_first_not_of(kAllowed) == std::string::npos) {
    return {};
  }
  return RangeError("a session id has 1 to " + std::to_string(kSessionIdLengthMax) +
                        " characters of A-Z a-z 0-9 _ . -",
                    "session_id");
}

Result<MetricUpdate> ConvertMetricUpdate(const v1::MetricUpdate& wire) {
  PLIANT_ASSIGN_OR_RETURN(MetricUpdate update, ConvertLimits(wire));
  if (wire.has_displacement()) {
    const auto is_at_vertices = [](const v1::MetricSource& source) {
      return source.has_vertices() || source.has_solution();
    };
    if (std::ranges::any_of(wire.sources(), is_at_vertices)) {
      return NotYet("A displacement together with values at vertices", "metric.displacement");
    }
    PLIANT_ASSIGN_OR_RETURN(update.displacement, ConvertDisplacement(wire.displacement()));
  }
  if (wire.sources_size() == 0) return update;
  const v1::MetricSource& source = wire.sources(0);
  if (wire.sources_size() > 1) {
    PLIANT_ASSIGN_OR_RETURN(update.source, ConvertSources(wire));
  } else if (source.has_vertices()) {
    PLIANT_ASSIGN_OR_RETURN(update.source, ConvertVertexMetric(source.vertices()));
  } else if (source.has_solution()) {
    PLIANT_ASSIGN_OR_RETURN(update.source, ConvertSolution(source.solution()));
  } else {
    PLIANT_ASSIGN_OR_RETURN(PlainMetric field, ConvertSource(source));
    std::visit([&](auto& value) { update.source = std::move(value); }, field);
  }
  return update;
}

namespace {

// A year: beyond it adding to a point in time could overflow.
constexpr std::int64_t kMsMax = std::int64_t{366} * 24 * 3600 * 1000;

Result<std::chrono::milliseconds> IntervalOf(std::int64_t ms, std::int64_t ms_min,
                                             const char* field) {
  if (ms >= ms_min && ms <= kMsMax) return std::chrono::milliseconds(ms);
  return RangeError(std::string(field) + " is " + std::to_string(ms) + "; it must be from " +
                        std::to_string(ms_min) + " to " + std::to_string(kMsMax) +
                        " (a year), or absent for none",
                    field);
}

}  // namespace

Result<AdvanceSpec> ConvertAdvance(const v1::Advance& advance) {
  AdvanceSpec spec;
  if (advance.has_budget_visits()) {
    if (advance.budget_visits() <= 0) {
      return RangeError("advance.budget_visits is " + std::to_string(advance.budget_visits()) +
                            "; it must be positive, or absent for no limit",
                        "advance.budget_visits");
    }
    spec.visits_max = advance.budget_visits();
  }
  if (advance.has_budget_ms()) {
    if (advance.budget_ms() <= 0 || advance.budget_ms() > kMsMax) {
      return RangeError("advance.budget_ms is " + std::to_string(advance.budget_ms()) +
                            "; it must be positive and at most a year, or absent for no limit",
                        "advance.budget_ms");
    }
    spec.time_max = std::chrono::milliseconds(advance.budget_ms());
  }
  if (advance.has_progress_interval_ms()) {
    PLIANT_ASSIGN_OR_RETURN(spec.progress_interval,
                            IntervalOf(advance.progress_interval_ms(), kProgressIntervalMsMin,
                                       "advance.progress_interval_ms"));
  }
  if (advance.has_commit_interval_ms()) {
    PLIANT_ASSIGN_OR_RETURN(spec.commit_interval,
                            IntervalOf(advance.commit_interval_ms(), kCommitIntervalMsMin,
                                       "advance.commit_interval_ms"));
  }
  return spec;
}

namespace {

template <class Update>
decltype(UpdateCommand::body) ValueOrBad(Result<Update> update) {
  if (!update.ok()) return BadUpdate{update.error()};
  return std::move(update).value();
}

}  // namespace

UpdateCommand ConvertUpdate(const v1::EditRequest& request, const RequestLimits& limits) {
  UpdateCommand command;
  command.update_id = request.update_id();
  switch (request.command_case()) {
    case v1::EditRequest::kMetric:
      command.body = ValueOrBad(ConvertMetricUpdate(request.metric()));
      break;
    case v1::EditRequest::kAdvance:
      if (auto advance = ConvertAdvance(request.advance()); advance.ok()) {
        command.body = *advance;
      } else {
        command.body = BadAdvance{advance.error()};
      }
      break;
    case v1::EditRequest::kDiscard:
      command.body = DiscardUpdate{};
      break;
    case v1::EditRequest::kBoundary:
      command.body = ValueOrBad(ConvertBoundaryUpdate(request.boundary()));
      break;
    case v1::EditRequest::kNodes:
      command.body = ValueOrBad(ConvertNodeUpdate(request.nodes()));
      break;
    case v1::EditRequest::kDomain:
      command.body = ValueOrBad(ConvertDomainUpdate(request.domain()));
      break;
    case v1::EditRequest::kFields:
      command.body = ValueOrBad(ConvertFields(request.fields()));
      break;
    case v1::EditRequest::kConstraints:
      command.body = ValueOrBad(ConvertConstraints(request.constraints()));
      break;
    case v1::EditRequest::kOptions:
      command.body = ValueOrBad(ConvertOptionsUpdate(request.options(), limits));
      break;
    case v1::EditRequest::kRollback:
      if (request.rollback().to_revision() > 0) {
        command.body = RollbackUpdate{Revision(request.rollback().to_revision())};
      } else {
        command.body = BadUpdate{
            RangeError("rollback.to_revision must be at least 1", "rollback.to_revision")};
      }
      break;
    case v1::EditRequest::kOpen:
    case v1::EditRequest::kChunk:
    case v1::EditRequest::kCancel:
    case v1::EditRequest::kAcknowledge:
    case v1::EditRequest::COMMAND_NOT_SET:
      PLIANT_CHECK(false, "command", static_cast<int>(request.command_case()));
  }
  return command;
}

Result<WantedParts> ConvertParts(const google::protobuf::RepeatedField<int>& parts) {
  WantedParts wanted;
  for (const int part : parts) {
    switch (part) {
      case v1::MESH_PART_METRIC:
        wanted.metric = true;
        break;
      case v1::MESH_PART_FIELDS:
        wanted.fields = true;
        break;
      case v1::MESH_PART_TRANSFER:
        wanted.transfer = true;
        break;
      case v1::MESH_PART_RAW_METRIC:
        return NotYet(v1::MeshPart_Name(static_cast<v1::MeshPart>(part)), "parts");
      default:
        return RangeError("parts has no known part", "parts");
    }
  }
  return wanted;
}

Result<OpenCommand> ConvertOpen(const v1::OpenEdit& open) {
  PLIANT_RETURN_IF_ERROR(CheckSessionId(open.session_id()));
  if (open.mirror_revision() < 0) {
    return RangeError("open.mirror_revision is negative", "open.mirror_revision");
  }
  OpenCommand command{.mirror_revision = Revision(open.mirror_revision())};
  if (!open.has_mirror_mode()) return command;
  switch (open.mirror_mode()) {
    case v1::MIRROR_MODE_FULL:
      break;
    case v1::MIRROR_MODE_NONE:
      command.mirror = Mirror::kNone;
      break;
    case v1::MIRROR_MODE_POSITIONS:
      return NotYet("MIRROR_MODE_POSITIONS", "open.mirror_mode");
    default:
      return RangeError("open.mirror_mode is no known mode", "open.mirror_mode");
  }
  return command;
}

}  // namespace pliant::server
