#include "server/convert_motion.h"

#include <string>
#include <utility>
#include <vector>

#include "server/convert_array.h"
#include "server/convert_mesh.h"
#include "server/limits.h"

namespace pliant::server {
namespace {

Result<ImpossibleMotion> ConvertImpossible(int wire, const std::string& field) {
  switch (wire) {
    case v1::IMPOSSIBLE_MOTION_REFUSE:
      return ImpossibleMotion::kRefuse;
    case v1::IMPOSSIBLE_MOTION_STOP:
      return ImpossibleMotion::kStop;
    default:
      return Error{ErrorCode::kOutOfRange, field + " is no known choice", field};
  }
}

Status ConvertPositions(const v1::VertexPositions& wire, MotionUpdate& update) {
  const std::string field = update.field + ".vertices";
  update.revision = Revision(wire.revision());
  PLIANT_ASSIGN_OR_RETURN(update.request.positions,
                          ReadRows<Vec2>(wire.positions(), field + ".positions"));
  if (!wire.has_vertex_ids()) {
    update.names_all = true;
    return {};
  }
  PLIANT_ASSIGN_OR_RETURN(update.request.vertices,
                          ReadRows<VertexId>(wire.vertex_ids(), field + ".vertex_ids"));
  if (update.request.vertices.size() != update.request.positions.size()) {
    return Error{ErrorCode::kArrayLength,
                 field + ".positions has " + std::to_string(update.request.positions.size()) +
                     " rows; expected " + std::to_string(update.request.vertices.size()) +
                     ", one for each vertex",
                 field + ".positions"};
  }
  return {};
}

Result<PathShape> ConvertShape(const v1::TagMotion& wire) {
  switch (wire.motion_case()) {
    case v1::TagMotion::kTranslation:
      return PathShape(Translation{{wire.translation().x(), wire.translation().y()}});
    case v1::TagMotion::kRotation:
      return PathShape(Rotation{{wire.rotation().center_x(), wire.rotation().center_y()},
                                wire.rotation().angle_rad()});
    case v1::TagMotion::kAffine: {
      const v1::Affine& map = wire.affine();
      return PathShape(AffineMap{map.a11(), map.a12(), map.a21(), map.a22(), {map.b1(), map.b2()}});
    }
    case v1::TagMotion::kPath: {
      const v1::PolynomialPath& path = wire.path();
      if (path.x_size() != path.y_size()) {
        return Error{ErrorCode::kArrayLength,
                     "boundary.tags.path has " + std::to_string(path.x_size()) + " x and " +
                         std::to_string(path.y_size()) + " y; expected as many",
                     "boundary.tags"};
      }
      PolynomialPath shape;
      for (int k = 0; k < path.x_size(); ++k) shape.coefficients.push_back({path.x(k), path.y(k)});
      return PathShape(std::move(shape));
    }
    case v1::TagMotion::MOTION_NOT_SET:
      break;
  }
  return Error{ErrorCode::kEmpty, "a motion by tag has no kind", "boundary.tags"};
}

}  // namespace

Result<MotionUpdate> ConvertBoundaryUpdate(const v1::BoundaryUpdate& wire) {
  MotionUpdate update{.field = "boundary"};
  if (wire.has_vertices()) PLIANT_RETURN_IF_ERROR(ConvertPositions(wire.vertices(), update));
  if (static_cast<std::size_t>(wire.tags_size()) > kTagMotionsMax) {
    return Error{ErrorCode::kTooLarge,
                 "boundary.tags has " + std::to_string(wire.tags_size()) +
                     " motions; allowed are " + std::to_string(kTagMotionsMax),
                 "boundary.tags"};
  }
  for (const v1::TagMotion& motion : wire.tags()) {
    PLIANT_ASSIGN_OR_RETURN(PathShape shape, ConvertShape(motion));
    update.request.tags.push_back({{motion.tags().begin(), motion.tags().end()}, std::move(shape)});
  }
  if (!wire.has_vertices() && wire.tags().empty()) {
    return Error{ErrorCode::kEmpty, "boundary moves nothing: give vertices or tags", "boundary"};
  }
  if (wire.has_on_impossible()) {
    PLIANT_ASSIGN_OR_RETURN(update.request.on_impossible,
                            ConvertImpossible(wire.on_impossible(), "boundary.on_impossible"));
  }
  update.request.follow_length = wire.metric_follow_length();
  return update;
}

Result<MotionUpdate> ConvertNodeUpdate(const v1::NodeUpdate& wire) {
  MotionUpdate update{.field = "nodes"};
  if (!wire.has_vertices()) {
    return Error{ErrorCode::kEmpty, "nodes moves nothing: give vertices", "nodes.vertices"};
  }
  PLIANT_RETURN_IF_ERROR(ConvertPositions(wire.vertices(), update));
  if (wire.has_on_impossible()) {
    PLIANT_ASSIGN_OR_RETURN(update.request.on_impossible,
                            ConvertImpossible(wire.on_impossible(), "nodes.on_impossible"));
  }
  return update;
}

Result<DomainUpdate> ConvertDomainUpdate(const v1::DomainUpdate& wire) {
  PLIANT_ASSIGN_OR_RETURN(Domain domain, ConvertDomain(wire.domain()));
  return DomainUpdate{std::move(domain)};
}

Result<DisplacementUpdate> ConvertDisplacement(const v1::MetricDisplacement& wire) {
  const std::string field = "metric.displacement";
  DisplacementUpdate update{.revision = Revision(wire.revision())};
  PLIANT_ASSIGN_OR_RETURN(update.vertices,
                          ReadRows<VertexId>(wire.vertex_ids(), field + ".vertex_ids"));
  PLIANT_ASSIGN_OR_RETURN(update.by,
                          ReadRows<Vec2>(wire.displacements(), field + ".displacements"));
  if (update.vertices.size() != update.by.size()) {
    return Error{ErrorCode::kArrayLength,
                 field + ".displacements has " + std::to_string(update.by.size()) +
                     " rows; expected " + std::to_string(update.vertices.size()) +
                     ", one for each vertex",
                 field + ".displacements"};
  }
  return update;
}

}  // namespace pliant::server
