#include "server/convert_options.h"

#include <algorithm>
#include <string>
#include <utility>

#include "server/convert_array.h"
#include "server/convert_request.h"
#include "server/limits.h"

namespace pliant::server {
namespace {

Result<Variant> ConvertVariant(v1::Variant variant) {
  switch (variant) {
    case v1::VARIANT_NESTED:
      return Variant::kNested;
    case v1::VARIANT_COOLED:
      return Variant::kCooled;
    case v1::VARIANT_PAPER:
      return Variant::kPaper;
    default:
      return RangeError("options.variant is no known variant", "options.variant");
  }
}

Result<Smoothing> ConvertSmoothing(v1::Smoothing smoothing) {
  switch (smoothing) {
    case v1::SMOOTHING_PLIANT:
      return Smoothing::kPliant;
    case v1::SMOOTHING_LAPLACIAN:
      return Smoothing::kLaplacian;
    case v1::SMOOTHING_LENNARD_JONES:
      return Smoothing::kLennardJones;
    case v1::SMOOTHING_BUBBLE:
      return Smoothing::kBubble;
    default:
      return RangeError("options.smoothing is no known smoothing", "options.smoothing");
  }
}

Result<Permissions> ConvertRestrictions(const google::protobuf::RepeatedField<int>& restrictions,
                                        const std::string& field) {
  Permissions permissions;
  for (const int restriction : restrictions) {
    switch (restriction) {
      case v1::RESTRICTION_NO_INSERT:
        permissions.insert = false;
        break;
      case v1::RESTRICTION_NO_SWAP:
        permissions.swap = false;
        break;
      case v1::RESTRICTION_NO_MOVE:
        permissions.move = false;
        break;
      case v1::RESTRICTION_NO_SURFACE:
        permissions.surface = false;
        break;
      default:
        return RangeError(field + " has no known restriction", field);
    }
  }
  return permissions;
}

// What both have in common: restrictions aside, a session begins with the defaults changed.
Result<OptionsUpdate> ConvertSet(const v1::SessionOptions& wire, const RequestLimits& limits) {
  OptionsUpdate update;
  if (wire.has_variant()) {
    PLIANT_ASSIGN_OR_RETURN(update.variant, ConvertVariant(wire.variant()));
  }
  if (wire.has_smoothing()) {
    PLIANT_ASSIGN_OR_RETURN(update.smoothing, ConvertSmoothing(wire.smoothing()));
  }
  if (wire.has_seed()) update.seed = static_cast<std::uint64_t>(wire.seed());
  if (wire.has_step()) update.step = wire.step();
  if (wire.has_speed_threshold()) update.speed_threshold = wire.speed_threshold();
  if (wire.has_age_cooling()) update.age_cooling = wire.age_cooling();
  if (wire.has_age_max()) update.age_max = wire.age_max();
  if (wire.has_hops_max()) update.hops_max = wire.hops_max();
  if (wire.has_metric_tolerance()) update.metric_tolerance = wire.metric_tolerance();
  if (wire.has_boundary_tolerance()) update.boundary_tolerance = wire.boundary_tolerance();
  if (wire.has_visits_per_vertex_max()) {
    update.visits_per_vertex_max = wire.visits_per_vertex_max();
  }
  if (wire.has_vertices_max()) {
    if (wire.vertices_max() > limits.vertices_max) {
      return RangeError("options.vertices_max is " + std::to_string(wire.vertices_max()) +
                            "; this server allows " + std::to_string(limits.vertices_max),
                        "options.vertices_max");
    }
    update.vertices_max = wire.vertices_max();
  }
  return update;
}

}  // namespace

Result<Options> ConvertOptions(const v1::SessionOptions& wire, const RequestLimits& limits) {
  PLIANT_ASSIGN_OR_RETURN(const OptionsUpdate update, ConvertSet(wire, limits));
  Options options;
  options.vertices_max = std::min(options.vertices_max, limits.vertices_max);
  options = update.AppliedTo(options);
  PLIANT_ASSIGN_OR_RETURN(options.permissions,
                          ConvertRestrictions(wire.restrictions(), "options.restrictions"));
  return options;
}

Result<OptionsUpdate> ConvertOptionsUpdate(const v1::SessionOptions& wire,
                                           const RequestLimits& limits) {
  if (wire.restrictions_size() > 0) {
    return RangeError(
        "restrictions of a session are changed by `constraints`, which replace them as a whole",
        "options.restrictions");
  }
  if (wire.has_durability()) {
    return RangeError("the durability of a session is chosen when it is created",
                      "options.durability");
  }
  if (wire.has_history_bytes_max()) {
    return RangeError("how much history a session keeps is chosen when it is created",
                      "options.history_bytes_max");
  }
  return ConvertSet(wire, limits);
}

Result<std::optional<std::int64_t>> ConvertHistoryBytesMax(const v1::SessionOptions& wire) {
  if (!wire.has_history_bytes_max()) return std::optional<std::int64_t>();
  const std::int64_t bytes = wire.history_bytes_max();
  if (bytes >= 0 && bytes <= kKeptBytesMax) return std::optional(bytes);
  return RangeError("options.history_bytes_max is " + std::to_string(bytes) +
                        "; this server allows 0 to " + std::to_string(kKeptBytesMax),
                    "options.history_bytes_max");
}

Result<ConstraintsUpdate> ConvertConstraints(const v1::ConstraintUpdate& wire) {
  ConstraintsUpdate update;
  Constraints& constraints = update.constraints;
  PLIANT_ASSIGN_OR_RETURN(constraints.vertices, ReadRows<VertexId>(wire.frozen_vertices(),
                                                                   "constraints.frozen_vertices"));
  PLIANT_ASSIGN_OR_RETURN(constraints.edges,
                          ReadRows<EdgeId>(wire.frozen_edges(), "constraints.frozen_edges"));
  constraints.regions.assign(wire.frozen_regions().begin(), wire.frozen_regions().end());
  PLIANT_ASSIGN_OR_RETURN(constraints.permissions,
                          ConvertRestrictions(wire.restrictions(), "constraints.restrictions"));
  if (wire.revision() != 0) update.revision = Revision(wire.revision());
  if (!update.revision && !(constraints.vertices.empty() && constraints.edges.empty())) {
    return Error{ErrorCode::kRevisionMismatch,
                 "ids are those of one revision: say of which, in constraints.revision",
                 "constraints.revision"};
  }
  return update;
}

}  // namespace pliant::server
