#include "core/transfer/field_set.h"

#include <algorithm>
#include <utility>

#include "core/base/same_bits.h"
#include "core/transfer/cell_linear.h"
#include "core/transfer/cell_mass.h"
#include "core/transfer/check_fields.h"
#include "core/transfer/nodal_projection.h"

namespace pliant {
namespace {

bool SameRowBits(std::span<const double> a, std::span<const double> b) {
  return std::ranges::equal(a, b, [](double x, double y) { return SameBits(x, y); });
}

/// New values at new and moved vertices, kLinear or kBounded.
FieldRows TransferNodes(const TransferRows& rows, const Field& field) {
  FieldRows result;
  for (std::size_t i = 0; i < rows.vertex_ids.size(); ++i) {
    const TransferRow& row = rows.rows[i];
    result.slots.push_back(rows.vertex_ids[i].value());
    for (std::size_t column = 0; column < field.column_count; ++column) {
      const auto old_value = [&](VertexId source) { return field.row(source.index())[column]; };
      double value = ApplyRow(row, old_value);
      if (field.transfer == TransferKind::kBounded) {
        double low = old_value(row.sources[0]);
        double high = low;
        for (const VertexId source : row.sources) {
          if (!source.valid()) continue;
          low = std::min(low, old_value(source));
          high = std::max(high, old_value(source));
        }
        value = std::clamp(value, low, high);
      }
      result.values.push_back(value);
    }
  }
  return result;
}

/// New values of the conservative fields among `fields`, in their order: one pass over the overlaps
/// for all of them.
std::vector<FieldRows> TransferConservatively(const MeshTransfer& transfer,
                                              std::span<const Field> fields) {
  const TouchedRegion& region = transfer.region();
  std::vector<CellMass> cells;
  std::vector<NodalProjection> nodes;
  for (const Field& field : fields) {
    if (field.transfer != TransferKind::kConservative) continue;
    if (field.location == FieldLocation::kTriangle) {
      cells.emplace_back(field, region);
    } else {
      nodes.emplace_back(field, region, transfer.rows());
    }
  }
  if (cells.empty() && nodes.empty()) return {};
  OverlapComponents pieces(region);
  std::optional<NodalSystem> system;
  if (!nodes.empty()) system.emplace(MakeNodalSystem(transfer.old().mesh(), region));
  OverlapFinder finder(region, transfer.locator());
  for (std::size_t t = 0; t < region.after.triangles.size(); ++t) {
    const auto after = static_cast<std::int32_t>(t);
    finder.Find(after);
    pieces.AddOverlaps(after, finder);
    if (system) system->components.AddOverlaps(after, finder);
    for (CellMass& cell : cells) cell.Add(after, finder);
    for (NodalProjection& node : nodes) node.Add(after, finder);
  }
  pieces.Finish(transfer.locator());
  if (system) system->components.Finish(transfer.locator());

  std::vector<FieldRows> results;
  auto cell = cells.begin();
  auto node = nodes.begin();
  for (const Field& field : fields) {
    if (field.transfer != TransferKind::kConservative) continue;
    results.push_back(field.location == FieldLocation::kTriangle ? (cell++)->Finish(pieces)
                                                                 : (node++)->Finish(*system));
  }
  return results;
}

bool WasLive(const OldMesh& old, FieldLocation location, std::int32_t slot) {
  return location == FieldLocation::kVertex ? old.vertex(VertexId(slot)).live
                                            : old.triangle(TriangleId(slot)).live;
}

bool HasElement(const Mesh& mesh, FieldLocation location, std::int32_t slot) {
  return location == FieldLocation::kVertex ? mesh.vertex(VertexId(slot)).live
                                            : mesh.triangle(TriangleId(slot)).live;
}

}  // namespace

Status FieldSet::Stage(const Mesh& mesh, const FieldUpdate& update) {
  // Staged updates are written before this one, so that it meets the fields they make.
  std::vector<Field> shapes;
  for (const Field& field : fields_) {
    shapes.push_back({field.name, field.location, field.transfer, field.column_count, {}});
  }
  for (const FieldUpdate& staged : staged_) {
    std::erase_if(shapes, [&](const Field& field) {
      return std::ranges::count(staged.dropped_names, field.name) > 0 ||
             std::ranges::count(staged.values, field.name, &FieldValues::name) > 0;
    });
    for (const FieldValues& values : staged.values) {
      shapes.push_back({values.name, values.location, {}, values.column_count, {}});
    }
  }
  PLIANT_RETURN_IF_ERROR(CheckFieldUpdate(mesh, shapes, update));
  staged_.push_back(update);
  return {};
}

bool FieldSet::conserves() const {
  const auto is_conservative = [](const auto& of) {
    return of.transfer == TransferKind::kConservative;
  };
  return std::ranges::any_of(fields_, is_conservative) ||
         std::ranges::any_of(staged_, is_conservative);
}

const Field* FieldSet::Find(const std::string& name) const {
  const auto found = std::ranges::lower_bound(fields_, name, {}, &Field::name);
  return found != fields_.end() && found->name == name ? &*found : nullptr;
}

std::vector<FieldChange> FieldSet::At(std::span<const VertexId> vertices,
                                      std::span<const TriangleId> triangles) const {
  std::vector<FieldChange> all;
  for (const Field& field : fields_) {
    FieldChange change{field.name, field.location, field.column_count, {}};
    const auto add = [&](const auto& ids) {
      for (const auto id : ids) {
        const auto row = field.row(id.index());
        change.rows.slots.push_back(id.value());
        change.rows.values.insert(change.rows.values.end(), row.begin(), row.end());
      }
    };
    field.location == FieldLocation::kVertex ? add(vertices) : add(triangles);
    all.push_back(std::move(change));
  }
  return all;
}

FieldChanges FieldSet::Commit(const MeshTransfer& transfer) {
  std::vector<std::string> names_before;
  for (const Field& field : fields_) names_before.push_back(field.name);
  std::vector<Written> written;
  const Mesh& mesh = transfer.old().mesh();
  for (const FieldUpdate& update : staged_) Write(mesh, update, written);
  staged_.clear();
  if (!transfer.empty()) Carry(transfer, written);

  FieldChanges changes;
  for (const std::string& name : names_before) {
    if (Find(name) == nullptr) changes.dropped_names.push_back(name);
  }
  for (const Field& field : fields_) {
    std::vector<std::int32_t>& slots = WrittenOf(field.name, written).slots;
    std::ranges::sort(slots);
    slots.erase(std::unique(slots.begin(), slots.end()), slots.end());
    FieldChange change{field.name, field.location, field.column_count, {}};
    for (const std::int32_t slot : slots) {
      if (!HasElement(mesh, field.location, slot)) continue;
      const auto row = field.row(static_cast<std::size_t>(slot));
      change.rows.slots.push_back(slot);
      change.rows.values.insert(change.rows.values.end(), row.begin(), row.end());
    }
    if (!change.rows.slots.empty()) changes.changed.push_back(std::move(change));
  }
  return changes;
}

FieldSet::Written& FieldSet::WrittenOf(const std::string& name,
                                       std::vector<Written>& written) const {
  const auto found = std::ranges::find(written, name, &Written::name);
  if (found != written.end()) return *found;
  written.push_back({name, {}});
  return written.back();
}

void FieldSet::Write(const Mesh& mesh, const FieldUpdate& update, std::vector<Written>& written) {
  for (const std::string& name : update.dropped_names) {
    std::erase_if(fields_, [&](const Field& field) { return field.name == name; });
    std::erase_if(written, [&](const Written& rows) { return rows.name == name; });
  }
  for (const FieldValues& values : update.values) {
    auto field = std::ranges::lower_bound(fields_, values.name, {}, &Field::name);
    if (field == fields_.end() || field->name != values.name) {
      field = fields_.insert(field, Field{.name = values.name, .values = {}});
    }
    if (field->location != values.location) WrittenOf(values.name, written).slots.clear();
    field->location = values.location;
    field->column_count = values.column_count;
    if (update.transfer) field->transfer = *update.transfer;
    const std::vector<std::int32_t> slots =
        values.ids ? *values.ids : CommittedSlots(mesh, values.location);
    const auto slot_count = static_cast<std::size_t>(
        values.location == FieldLocation::kVertex ? mesh.vertex_slots() : mesh.triangle_slots());
    field->values.resize(slot_count * field->column_count);
    for (std::size_t i = 0; i < slots.size(); ++i) {
      const auto slot = static_cast<std::size_t>(slots[i]);
      std::copy_n(values.values.begin() + static_cast<std::ptrdiff_t>(i * values.column_count),
                  values.column_count,
                  field->values.begin() + static_cast<std::ptrdiff_t>(slot * values.column_count));
    }
    Written& rows = WrittenOf(values.name, written);
    rows.slots.insert(rows.slots.end(), slots.begin(), slots.end());
  }
}

void FieldSet::Carry(const MeshTransfer& transfer, std::vector<Written>& written) {
  const OldMesh& old = transfer.old();
  const Mesh& mesh = old.mesh();
  std::vector<FieldRows> conservative = TransferConservatively(transfer, fields_);
  auto next = conservative.begin();
  for (Field& field : fields_) {
    const bool on_vertices = field.location == FieldLocation::kVertex;
    FieldRows rows;
    if (field.transfer == TransferKind::kConservative) {
      rows = std::move(*next++);
    } else if (on_vertices) {
      rows = TransferNodes(transfer.rows(), field);
    } else {
      rows = TransferCells(old, transfer.region(), transfer.locator(), field);
    }
    const auto slot_count =
        static_cast<std::size_t>(on_vertices ? mesh.vertex_slots() : mesh.triangle_slots());
    field.values.resize(slot_count * field.column_count);
    std::vector<std::int32_t>& slots = WrittenOf(field.name, written).slots;
    for (std::size_t i = 0; i < rows.slots.size(); ++i) {
      const std::span<const double> now(rows.values.data() + i * field.column_count,
                                        field.column_count);
      const auto slot = static_cast<std::size_t>(rows.slots[i]);
      if (WasLive(old, field.location, rows.slots[i]) && SameRowBits(now, field.row(slot)))
        continue;
      std::ranges::copy(
          now, field.values.begin() + static_cast<std::ptrdiff_t>(slot * field.column_count));
      slots.push_back(rows.slots[i]);
    }
  }
}

}  // namespace pliant
