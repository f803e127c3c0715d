#include "core/mesh/merge_fields.h"

#include <algorithm>
#include <span>
#include <utility>

namespace pliant {
namespace {

const FieldChange* FindField(const FieldChanges& changes, const std::string& name) {
  const auto found = std::ranges::find(changes.changed, name, &FieldChange::name);
  return found == changes.changed.end() ? nullptr : &*found;
}

template <class Id>
bool HasSlot(const std::vector<Id>& ids, std::int32_t slot) {
  return std::binary_search(ids.begin(), ids.end(), Id(slot));
}

bool IsRemoved(const MeshDiff& diff, FieldLocation location, std::int32_t slot) {
  return location == FieldLocation::kVertex ? HasSlot(diff.removed_vertices, slot)
                                            : HasSlot(diff.removed_triangles, slot);
}

void Append(const FieldChange& from, std::size_t row, FieldChange& to) {
  to.rows.slots.push_back(from.rows.slots[row]);
  const auto values =
      std::span(from.rows.values).subspan(row * from.column_count, from.column_count);
  to.rows.values.insert(to.rows.values.end(), values.begin(), values.end());
}

/// @pre both have the same location and shape
FieldChange MergeRows(const FieldChange& first, const MeshDiff& second, const FieldChange& later) {
  FieldChange merged{later.name, later.location, later.column_count, {}};
  std::size_t i = 0;
  for (std::size_t k = 0; k <= later.rows.slots.size(); ++k) {
    const bool at_end = k == later.rows.slots.size();
    for (; i < first.rows.slots.size(); ++i) {
      const std::int32_t slot = first.rows.slots[i];
      if (!at_end && slot > later.rows.slots[k]) break;
      const bool overwritten = !at_end && slot == later.rows.slots[k];
      if (!overwritten && !IsRemoved(second, first.location, slot)) Append(first, i, merged);
    }
    if (!at_end) Append(later, k, merged);
  }
  return merged;
}

}  // namespace

FieldChanges MergeFields(const MeshDiff& first, const MeshDiff& second) {
  FieldChanges merged;
  for (const FieldChange& field : first.fields.changed) {
    const FieldChange* later = FindField(second.fields, field.name);
    if (later == nullptr) {
      if (std::ranges::count(second.fields.dropped_names, field.name) > 0) continue;
      const FieldChange nothing{field.name, field.location, field.column_count, {}};
      merged.changed.push_back(MergeRows(field, second, nothing));
    } else if (later->location != field.location || later->column_count != field.column_count) {
      merged.changed.push_back(*later);
    } else {
      merged.changed.push_back(MergeRows(field, second, *later));
    }
  }
  for (const FieldChange& later : second.fields.changed) {
    if (FindField(first.fields, later.name) == nullptr) merged.changed.push_back(later);
  }
  std::ranges::sort(merged.changed, {}, &FieldChange::name);
  // What is dropped goes before anything is written: a field that comes back has all its values.
  merged.dropped_names = second.fields.dropped_names;
  merged.dropped_names.insert(merged.dropped_names.end(), first.fields.dropped_names.begin(),
                              first.fields.dropped_names.end());
  std::ranges::sort(merged.dropped_names);
  const auto last = std::unique(merged.dropped_names.begin(), merged.dropped_names.end());
  merged.dropped_names.erase(last, merged.dropped_names.end());
  return merged;
}

}  // namespace pliant
