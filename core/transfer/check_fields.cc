#include "core/transfer/check_fields.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <string_view>

namespace pliant {
namespace {

constexpr std::size_t kNameSizeMax = 64;

bool IsName(std::string_view name) {
  constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyz0123456789_";
  return !name.empty() && name.size() <= kNameSizeMax &&
         name.find_first_not_of(kLetters) == std::string_view::npos;
}

bool IsCommitted(const Mesh& mesh, FieldLocation location, std::int32_t slot) {
  if (slot < 0) return false;
  if (location == FieldLocation::kVertex) {
    return slot < mesh.vertex_slots() && mesh.vertex(VertexId(slot)).committed;
  }
  return slot < mesh.triangle_slots() && mesh.triangle(TriangleId(slot)).committed;
}

Error Refuse(ErrorCode code, const std::string& field, std::size_t index, const std::string& what) {
  return {code, "entry " + std::to_string(index) + " of " + field + " " + what, field,
          static_cast<std::int64_t>(index)};
}

Status CheckIds(const Mesh& mesh, const FieldValues& values) {
  const std::vector<std::int32_t>& ids = *values.ids;
  const char* element = values.location == FieldLocation::kVertex ? "vertex" : "triangle";
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (!IsCommitted(mesh, values.location, ids[i])) {
      return Refuse(
          ErrorCode::kIndexOutOfRange, "fields.ids", i,
          "is " + std::to_string(ids[i]) + ", which is no " + element + " of this revision");
    }
    if (i > 0 && ids[i] <= ids[i - 1]) {
      return Refuse(ErrorCode::kDuplicateId, "fields.ids", i,
                    "is " + std::to_string(ids[i]) + " after " + std::to_string(ids[i - 1]) +
                        "; ids must ascend, none twice");
    }
  }
  return {};
}

/// @param known  the field as it will be before these values are written; null if there is none.
Status CheckValues(const Mesh& mesh, const Field* known, const FieldValues& values) {
  if (!IsName(values.name)) {
    return Error{ErrorCode::kOutOfRange,
                 "'" + values.name + "' is no name of a field; 1 to 64 of a-z, 0-9 and _ are",
                 "fields.name"};
  }
  if (values.column_count < 1 || values.column_count > 3) {
    return Error{ErrorCode::kOutOfRange,
                 "field '" + values.name + "' has " + std::to_string(values.column_count) +
                     " values per element; 1, 2 (vectors) and 3 (symmetric tensors) are possible",
                 "fields.values"};
  }
  const bool is_new = known == nullptr || known->location != values.location ||
                      known->column_count != values.column_count;
  if (is_new && values.ids.has_value()) {
    return Error{ErrorCode::kEmpty,
                 "field '" + values.name +
                     "' is not there yet with this location and shape; send it at all elements "
                     "first, without ids",
                 "fields.ids"};
  }
  if (values.ids) PLIANT_RETURN_IF_ERROR(CheckIds(mesh, values));
  const std::size_t count =
      values.ids ? values.ids->size() : CommittedSlots(mesh, values.location).size();
  if (values.values.size() != count * values.column_count) {
    return Error{ErrorCode::kArrayLength,
                 "field '" + values.name + "' has " + std::to_string(values.values.size()) +
                     " values for " + std::to_string(count) + " elements of " +
                     std::to_string(values.column_count) + " values each",
                 "fields.values"};
  }
  for (std::size_t i = 0; i < values.values.size(); ++i) {
    if (!std::isfinite(values.values[i])) {
      return Refuse(ErrorCode::kNotFinite, "fields.values", i / values.column_count,
                    "is NaN or infinite");
    }
  }
  return {};
}

}  // namespace

Status CheckFieldUpdate(const Mesh& mesh, std::span<const Field> fields,
                        const FieldUpdate& update) {
  std::set<std::string> names;
  for (const Field& field : fields) names.insert(field.name);
  for (const std::string& name : update.dropped_names) {
    if (names.erase(name) == 0) {
      return Error{ErrorCode::kOutOfRange, "there is no field '" + name + "' to drop",
                   "fields.dropped_names"};
    }
  }
  std::set<std::string> sent;
  for (const FieldValues& values : update.values) {
    if (!sent.insert(values.name).second) {
      return Error{ErrorCode::kDuplicateId, "field '" + values.name + "' is sent twice",
                   "fields.name"};
    }
    const auto known = std::ranges::find(fields, values.name, &Field::name);
    const bool is_known = known != fields.end() && names.contains(values.name);
    PLIANT_RETURN_IF_ERROR(CheckValues(mesh, is_known ? &*known : nullptr, values));
    names.insert(values.name);
  }
  if (names.size() > FieldSet::kFieldsMax) {
    return Error{ErrorCode::kTooLarge,
                 "the session would have " + std::to_string(names.size()) + " fields; " +
                     std::to_string(FieldSet::kFieldsMax) + " are the most",
                 "fields.values"};
  }
  return {};
}

std::vector<std::int32_t> CommittedSlots(const Mesh& mesh, FieldLocation location) {
  const std::int32_t count =
      location == FieldLocation::kVertex ? mesh.vertex_slots() : mesh.triangle_slots();
  std::vector<std::int32_t> slots;
  for (std::int32_t slot = 0; slot < count; ++slot) {
    if (IsCommitted(mesh, location, slot)) slots.push_back(slot);
  }
  return slots;
}

}  // namespace pliant
