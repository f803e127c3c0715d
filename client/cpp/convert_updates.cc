#include "client/cpp/convert_updates.h"

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "client/cpp/convert.h"

namespace pliant::client {
namespace {

using wire::ColumnReader;
using wire::ColumnWriter;

v1::ImpossibleMotion WireOf(ImpossibleMotion on_impossible) {
  return on_impossible == ImpossibleMotion::kStop ? v1::IMPOSSIBLE_MOTION_STOP
                                                  : v1::IMPOSSIBLE_MOTION_REFUSE;
}

void WriteShape(const PathShape& shape, v1::TagMotion& motion) {
  std::visit(Overloaded{
                 [&](const Translation& translation) {
                   motion.mutable_translation()->set_x(translation.by.x);
                   motion.mutable_translation()->set_y(translation.by.y);
                 },
                 [&](const Rotation& rotation) {
                   v1::Rotation& to = *motion.mutable_rotation();
                   to.set_center_x(rotation.center.x);
                   to.set_center_y(rotation.center.y);
                   to.set_angle_rad(rotation.angle_rad);
                 },
                 [&](const AffineMap& map) {
                   v1::Affine& to = *motion.mutable_affine();
                   to.set_a11(map.a11);
                   to.set_a12(map.a12);
                   to.set_a21(map.a21);
                   to.set_a22(map.a22);
                   to.set_b1(map.b.x);
                   to.set_b2(map.b.y);
                 },
                 [&](const PolynomialPath& path) {
                   for (const Vec2 coefficient : path.coefficients) {
                     motion.mutable_path()->add_x(coefficient.x);
                     motion.mutable_path()->add_y(coefficient.y);
                   }
                 },
             },
             shape);
}

/// Rows of one to three numbers.
v1::Array Values(std::span<const double> values, std::size_t column_count, ColumnWriter& columns) {
  const auto rows = [&](auto row) {
    using Row = decltype(row);
    return std::span(reinterpret_cast<const Row*>(values.data()),
                     values.size() / std::tuple_size_v<Row>);
  };
  if (column_count == 2) return columns.Write<double, 2>(rows(std::array<double, 2>{}));
  if (column_count == 3) return columns.Write<double, 3>(rows(std::array<double, 3>{}));
  return columns.Write<double, 1>(values);
}

template <std::size_t kColumns>
Result<std::vector<double>> ReadFlat(const v1::Array& array, ColumnReader& columns) {
  using Row = std::array<double, kColumns>;
  PLIANT_ASSIGN_OR_RETURN(const std::vector<Row> rows,
                          (columns.Read<double, kColumns, Row>(array, "fields.values")));
  std::vector<double> values;
  for (const Row& row : rows) values.insert(values.end(), row.begin(), row.end());
  return values;
}

Result<FieldChange> ReadField(const v1::FieldValues& wire, ColumnReader& columns) {
  FieldChange field{.name = wire.name(),
                    .location = wire.location() == v1::FIELD_LOCATION_TRIANGLE
                                    ? FieldLocation::kTriangle
                                    : FieldLocation::kVertex,
                    .column_count = 1,
                    .rows = {}};
  if (wire.values().shape_size() == 2) {
    field.column_count = static_cast<std::size_t>(wire.values().shape(1));
  }
  PLIANT_ASSIGN_OR_RETURN(field.rows.slots,
                          (columns.Read<std::int32_t, 1, std::int32_t>(wire.ids(), "fields.ids")));
  PLIANT_ASSIGN_OR_RETURN(field.rows.values,
                          field.column_count == 2   ? ReadFlat<2>(wire.values(), columns)
                          : field.column_count == 3 ? ReadFlat<3>(wire.values(), columns)
                                                    : ReadFlat<1>(wire.values(), columns));
  if (field.rows.values.size() != field.rows.slots.size() * field.column_count) {
    return Error{.code = ErrorCode::kArrayLength,
                 .message = "the server sent a field with another number of values than of ids",
                 .field = "fields.values"};
  }
  return field;
}

}  // namespace

v1::BoundaryUpdate ToWire(const MotionRequest& motion, Revision revision, ColumnWriter& columns) {
  v1::BoundaryUpdate message;
  if (!motion.vertices.empty()) {
    v1::VertexPositions& vertices = *message.mutable_vertices();
    vertices.set_revision(static_cast<std::int64_t>(revision));
    *vertices.mutable_vertex_ids() = Numbers(std::span(motion.vertices), columns);
    *vertices.mutable_positions() =
        columns.Write<double, 2>(std::span<const Vec2>(motion.positions));
  }
  for (const TagMotion& tags : motion.tags) {
    v1::TagMotion& to = *message.add_tags();
    to.mutable_tags()->Add(tags.tags.begin(), tags.tags.end());
    WriteShape(tags.shape, to);
  }
  message.set_on_impossible(WireOf(motion.on_impossible));
  if (motion.follow_length > 0) message.set_metric_follow_length(motion.follow_length);
  return message;
}

v1::NodeUpdate ToWire(const NodePositions& nodes, ColumnWriter& columns) {
  v1::NodeUpdate message;
  v1::VertexPositions& vertices = *message.mutable_vertices();
  vertices.set_revision(static_cast<std::int64_t>(nodes.revision));
  if (!nodes.vertices.empty()) *vertices.mutable_vertex_ids() = Numbers(nodes.vertices, columns);
  *vertices.mutable_positions() = columns.Write<double, 2>(nodes.positions);
  message.set_on_impossible(WireOf(nodes.on_impossible));
  return message;
}

v1::MetricDisplacement DisplacementToWire(std::span<const VertexId> vertices,
                                          std::span<const Vec2> by, Revision revision,
                                          ColumnWriter& columns) {
  v1::MetricDisplacement message;
  message.set_revision(static_cast<std::int64_t>(revision));
  *message.mutable_vertex_ids() = Numbers(vertices, columns);
  *message.mutable_displacements() = columns.Write<double, 2>(by);
  return message;
}

v1::FieldUpdate ToWire(const FieldUpdate& fields, Revision revision, ColumnWriter& columns) {
  v1::FieldUpdate message;
  message.set_revision(static_cast<std::int64_t>(revision));
  for (const FieldValues& values : fields.values) {
    v1::FieldValues& to = *message.add_values();
    to.set_name(values.name);
    to.set_location(values.location == FieldLocation::kVertex ? v1::FIELD_LOCATION_VERTEX
                                                              : v1::FIELD_LOCATION_TRIANGLE);
    if (values.ids) {
      *to.mutable_ids() = Numbers(std::span<const std::int32_t>(*values.ids), columns);
    }
    *to.mutable_values() = Values(values.values, values.column_count, columns);
  }
  if (fields.transfer) {
    message.set_transfer(*fields.transfer == TransferKind::kLinear    ? v1::TRANSFER_LINEAR
                         : *fields.transfer == TransferKind::kBounded ? v1::TRANSFER_BOUNDED
                                                                      : v1::TRANSFER_CONSERVATIVE);
  }
  for (const std::string& name : fields.dropped_names) message.add_dropped_names(name);
  return message;
}

v1::ConstraintUpdate ToWire(const Constraints& constraints, Revision revision,
                            ColumnWriter& columns) {
  v1::ConstraintUpdate message;
  message.set_revision(static_cast<std::int64_t>(revision));
  if (!constraints.vertices.empty()) {
    *message.mutable_frozen_vertices() =
        Numbers(std::span<const VertexId>(constraints.vertices), columns);
  }
  if (!constraints.edges.empty()) {
    *message.mutable_frozen_edges() = Numbers(std::span<const EdgeId>(constraints.edges), columns);
  }
  message.mutable_frozen_regions()->Add(constraints.regions.begin(), constraints.regions.end());
  AddRestrictions(constraints.permissions, message);
  return message;
}

v1::SessionOptions AllToWire(const Options& options) {
  v1::SessionOptions message;
  message.set_smoothing(ToWire(options.smoothing));
  message.set_step(options.step);
  message.set_speed_threshold(options.speed_threshold);
  message.set_age_cooling(options.age_cooling);
  message.set_age_max(options.age_max);
  message.set_hops_max(options.hops_max);
  message.set_metric_tolerance(options.metric_tolerance);
  message.set_boundary_tolerance(options.boundary_tolerance);
  message.set_visits_per_vertex_max(options.visits_per_vertex_max);
  if (options.vertices_max != Options().vertices_max) {
    message.set_vertices_max(options.vertices_max);
  }
  return message;
}

Result<FieldChanges> FieldsFromWire(
    const google::protobuf::RepeatedPtrField<v1::FieldValues>& fields, ColumnReader& columns) {
  FieldChanges changes;
  for (const v1::FieldValues& wire : fields) {
    if (wire.location() == v1::FIELD_LOCATION_UNSPECIFIED) {
      changes.dropped_names.push_back(wire.name());
      continue;
    }
    PLIANT_ASSIGN_OR_RETURN(FieldChange field, ReadField(wire, columns));
    changes.changed.push_back(std::move(field));
  }
  return changes;
}

Result<TransferRows> FromWire(const v1::TransferRows& wire, ColumnReader& columns) {
  using Sources = std::array<VertexId, 3>;
  using Weights = std::array<double, 3>;
  TransferRows rows;
  PLIANT_ASSIGN_OR_RETURN(rows.vertex_ids, (columns.Read<std::int32_t, 1, VertexId>(
                                               wire.vertex_ids(), "transfer.vertex_ids")));
  PLIANT_ASSIGN_OR_RETURN(
      const std::vector<Sources> sources,
      (columns.Read<std::int32_t, 3, Sources>(wire.sources(), "transfer.sources")));
  PLIANT_ASSIGN_OR_RETURN(const std::vector<Weights> weights,
                          (columns.Read<double, 3, Weights>(wire.weights(), "transfer.weights")));
  if (sources.size() != rows.vertex_ids.size() || weights.size() != rows.vertex_ids.size()) {
    return Error{.code = ErrorCode::kArrayLength,
                 .message = "the server sent transfer rows of different lengths",
                 .field = "transfer"};
  }
  for (std::size_t i = 0; i < sources.size(); ++i) rows.rows.push_back({sources[i], weights[i]});
  return rows;
}

}  // namespace pliant::client
