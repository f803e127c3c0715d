#include "server/convert.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "server/convert_array.h"
#include "server/convert_fields.h"
#include "server/convert_mesh.h"
#include "server/convert_metric.h"
#include "server/convert_motion.h"
#include "server/convert_request.h"
#include "server/limits.h"

namespace pliant::server {
namespace {

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
  PLIANT_ASSIGN_OR_RETURN(input.history_bytes_max, ConvertHistoryBytesMax(create.options()));
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
