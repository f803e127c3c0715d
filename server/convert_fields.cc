#include "server/convert_fields.h"

#include <array>
#include <cstring>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "server/convert_array.h"

namespace pliant::server {
namespace {

Error Refuse(ErrorCode code, const std::string& field, const std::string& what) {
  return {code, field + " " + what, field};
}

/// The numbers of an array of one, two or three columns.
struct Columns {
  std::size_t count = 1;
  std::vector<double> values;
};

template <std::size_t kCount>
Result<Columns> ReadColumns(const v1::Array& array, const std::string& field) {
  PLIANT_RETURN_IF_ERROR(CheckArray(array, v1::DTYPE_FLOAT64, kCount, field));
  Columns columns{.count = kCount,
                  .values = std::vector<double>(array.data().size() / sizeof(double))};
  if (!columns.values.empty()) {
    std::memcpy(columns.values.data(), array.data().data(), array.data().size());
  }
  return columns;
}

Result<Columns> ReadValues(const v1::Array& array, const std::string& field) {
  const std::int64_t column_count = array.shape_size() == 2 ? array.shape(1) : 1;
  if (column_count == 2) return ReadColumns<2>(array, field);
  if (column_count == 3) return ReadColumns<3>(array, field);
  return ReadColumns<1>(array, field);
}

void WriteDoubles(std::span<const double> values, std::size_t column_count, v1::Array& array) {
  array.set_dtype(v1::DTYPE_FLOAT64);
  array.add_shape(static_cast<std::int64_t>(values.size() / column_count));
  if (column_count > 1) array.add_shape(static_cast<std::int64_t>(column_count));
  array.set_data(values.data(), values.size_bytes());
}

Result<FieldLocation> ConvertLocation(v1::FieldLocation location, const std::string& field) {
  switch (location) {
    case v1::FIELD_LOCATION_VERTEX:
      return FieldLocation::kVertex;
    case v1::FIELD_LOCATION_TRIANGLE:
      return FieldLocation::kTriangle;
    default:
      return Refuse(ErrorCode::kOutOfRange, field,
                    "is no known location; there are FIELD_LOCATION_VERTEX and "
                    "FIELD_LOCATION_TRIANGLE");
  }
}

Result<TransferKind> ConvertTransfer(v1::Transfer transfer) {
  switch (transfer) {
    case v1::TRANSFER_LINEAR:
      return TransferKind::kLinear;
    case v1::TRANSFER_BOUNDED:
      return TransferKind::kBounded;
    case v1::TRANSFER_CONSERVATIVE:
      return TransferKind::kConservative;
    default:
      return Refuse(ErrorCode::kOutOfRange, "fields.transfer", "is no known kind of transfer");
  }
}

Result<FieldValues> ConvertValues(const v1::FieldValues& wire) {
  FieldValues values{.name = wire.name()};
  PLIANT_ASSIGN_OR_RETURN(values.location, ConvertLocation(wire.location(), "fields.location"));
  if (wire.has_ids()) {
    PLIANT_ASSIGN_OR_RETURN(values.ids, ReadRows<std::int32_t>(wire.ids(), "fields.ids"));
  }
  PLIANT_ASSIGN_OR_RETURN(Columns columns, ReadValues(wire.values(), "fields.values"));
  values.column_count = columns.count;
  values.values = std::move(columns.values);
  return values;
}

}  // namespace

Result<FieldsUpdate> ConvertFields(const v1::FieldUpdate& wire) {
  FieldsUpdate result{.revision = Revision(wire.revision()), .update = {}};
  if (static_cast<std::size_t>(wire.values_size()) > FieldSet::kFieldsMax ||
      static_cast<std::size_t>(wire.dropped_names_size()) > FieldSet::kFieldsMax) {
    return Refuse(ErrorCode::kTooLarge, "fields",
                  "names more than " + std::to_string(FieldSet::kFieldsMax) +
                      " fields, which is the most that a session has");
  }
  for (const v1::FieldValues& values : wire.values()) {
    PLIANT_ASSIGN_OR_RETURN(FieldValues converted, ConvertValues(values));
    result.update.values.push_back(std::move(converted));
  }
  if (wire.has_transfer()) {
    PLIANT_ASSIGN_OR_RETURN(result.update.transfer, ConvertTransfer(wire.transfer()));
  }
  result.update.dropped_names.assign(wire.dropped_names().begin(), wire.dropped_names().end());
  return result;
}

Result<SolutionRequest> ConvertSolution(const v1::SolutionMetric& wire) {
  SolutionRequest request{.name = wire.field().name()};
  if (wire.field().has_values()) {
    if (wire.field().has_ids()) {
      return Refuse(ErrorCode::kOutOfRange, "metric.solution.field.ids",
                    "must be absent: a metric needs the solution at all vertices");
    }
    PLIANT_ASSIGN_OR_RETURN(
        const FieldLocation location,
        ConvertLocation(wire.field().location(), "metric.solution.field.location"));
    if (location != FieldLocation::kVertex) {
      return Refuse(ErrorCode::kOutOfRange, "metric.solution.field.location",
                    "must be FIELD_LOCATION_VERTEX: curvature is told from nodal values");
    }
    PLIANT_ASSIGN_OR_RETURN(Columns columns,
                            ReadValues(wire.field().values(), "metric.solution.field.values"));
    request.column_count = columns.count;
    request.values = std::move(columns.values);
  } else if (request.name.empty()) {
    return Refuse(ErrorCode::kEmpty, "metric.solution.field",
                  "needs values at all vertices, or the name of a field of the session");
  }
  if (wire.has_norm_exponent()) request.target.norm_exponent = wire.norm_exponent();
  switch (wire.target_case()) {
    case v1::SolutionMetric::kComplexity:
      request.target.target = TargetComplexity{wire.complexity()};
      return request;
    case v1::SolutionMetric::kError:
      request.target.target = TargetError{wire.error()};
      return request;
    case v1::SolutionMetric::TARGET_NOT_SET:
      break;
  }
  return Refuse(ErrorCode::kEmpty, "metric.solution.target",
                "is not set; give a complexity or an error");
}

void WriteTransferRows(const TransferRows& rows, v1::TransferRows& wire) {
  std::vector<std::array<VertexId, 3>> sources;
  std::vector<double> weights;
  for (const TransferRow& row : rows.rows) {
    sources.push_back(row.sources);
    weights.insert(weights.end(), row.weights.begin(), row.weights.end());
  }
  WriteRows(std::span<const VertexId>(rows.vertex_ids), *wire.mutable_vertex_ids());
  WriteRows(std::span<const std::array<VertexId, 3>>(sources), *wire.mutable_sources());
  WriteDoubles(weights, 3, *wire.mutable_weights());
}

void WriteFields(const std::vector<FieldChange>& fields,
                 google::protobuf::RepeatedPtrField<v1::FieldValues>& wire) {
  for (const FieldChange& field : fields) {
    v1::FieldValues& values = *wire.Add();
    values.set_name(field.name);
    values.set_location(field.location == FieldLocation::kVertex ? v1::FIELD_LOCATION_VERTEX
                                                                 : v1::FIELD_LOCATION_TRIANGLE);
    WriteRows(std::span<const std::int32_t>(field.rows.slots), *values.mutable_ids());
    WriteDoubles(field.rows.values, field.column_count, *values.mutable_values());
  }
}

}  // namespace pliant::server
