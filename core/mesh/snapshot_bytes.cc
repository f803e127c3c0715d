#include "core/mesh/snapshot_bytes.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include "core/base/check.h"
#include "core/base/row_bytes.h"
#include "core/mesh/mesh_delta.h"

namespace pliant {
namespace {

constexpr Seal kSeal{.kind = 0x534d4c50, .version = 1};  // "PLMS"
constexpr const char* kName = "snapshot";

FieldChange TakeField(ByteReader& reader) {
  FieldChange field;
  field.name = reader.TakeText();
  const auto location = reader.Take<std::uint8_t>();
  if (location > static_cast<std::uint8_t>(FieldLocation::kTriangle)) reader.Fail();
  field.location = static_cast<FieldLocation>(location);
  field.column_count = reader.Take<std::uint8_t>();
  field.rows.slots = reader.TakeColumn<std::int32_t>();
  field.rows.values = reader.TakeColumn<double>();
  if (field.rows.values.size() != field.rows.slots.size() * field.column_count) reader.Fail();
  return field;
}

template <class SomeId>
bool Ascend(const std::vector<SomeId>& ids) {
  return std::adjacent_find(ids.begin(), ids.end(), std::greater_equal<>()) == ids.end() &&
         (ids.empty() || ids.front() >= SomeId(0));
}

// Which slots the ascending ids name.
template <class SomeId>
class LiveSlots {
 public:
  explicit LiveSlots(const std::vector<SomeId>& ids)
      : is_live_(ids.empty() ? 0 : ids.back().index() + 1, std::uint8_t{0}) {
    for (const SomeId id : ids) is_live_[id.index()] = 1;
  }
  [[nodiscard]] bool Has(std::int32_t slot) const {
    return slot >= 0 && static_cast<std::size_t>(slot) < is_live_.size() &&
           is_live_[static_cast<std::size_t>(slot)] != 0;
  }
  template <std::size_t kCount>
  [[nodiscard]] bool HasAll(const std::vector<std::array<SomeId, kCount>>& rows) const {
    return std::all_of(rows.begin(), rows.end(), [this](const auto& row) {
      return std::all_of(row.begin(), row.end(), [this](SomeId id) { return Has(id.value()); });
    });
  }

 private:
  std::vector<std::uint8_t> is_live_;
};

bool FieldsFit(const MeshDiff& mesh, const LiveSlots<VertexId>& vertices) {
  const LiveSlots<TriangleId> triangles(mesh.triangle_ids);
  return std::all_of(
      mesh.fields.changed.begin(), mesh.fields.changed.end(), [&](const FieldChange& field) {
        return std::all_of(field.rows.slots.begin(), field.rows.slots.end(),
                           [&](std::int32_t slot) {
                             return field.location == FieldLocation::kVertex ? vertices.Has(slot)
                                                                             : triangles.Has(slot);
                           });
      });
}

// What is wrong with columns that were read in full; empty if nothing is.
std::string FindFault(const MeshDiff& mesh) {
  if (mesh.vertex_positions.size() != mesh.vertex_ids.size() ||
      mesh.triangle_vertices.size() != mesh.triangle_ids.size() ||
      mesh.triangle_regions.size() != mesh.triangle_ids.size() ||
      mesh.edge_vertices.size() != mesh.edge_ids.size() ||
      mesh.edge_tags.size() != mesh.edge_ids.size() ||
      mesh.metrics.size() != mesh.metric_vertex_ids.size()) {
    return "columns of one kind of element have different lengths";
  }
  if (!Ascend(mesh.vertex_ids) || !Ascend(mesh.triangle_ids) || !Ascend(mesh.edge_ids) ||
      !Ascend(mesh.metric_vertex_ids)) {
    return "ids do not ascend";
  }
  const LiveSlots<VertexId> vertices(mesh.vertex_ids);
  const bool metric_fits = std::all_of(mesh.metric_vertex_ids.begin(), mesh.metric_vertex_ids.end(),
                                       [&](VertexId id) { return vertices.Has(id.value()); });
  if (!metric_fits || !vertices.HasAll(mesh.triangle_vertices) ||
      !vertices.HasAll(mesh.edge_vertices) || !FieldsFit(mesh, vertices)) {
    return "an id names an element that is not there";
  }
  return "";
}

}  // namespace

Bytes WriteMeshSnapshot(const MeshDiff& snapshot) {
  PLIANT_CHECK(snapshot.base_revision == Revision::kNone && snapshot.removed_vertices.empty());
  ByteWriter writer;
  writer.Put(static_cast<std::int64_t>(snapshot.revision));
  WriteSummary(snapshot.summary, writer);
  PutRows<std::int32_t>(snapshot.vertex_ids, writer);
  PutRows<double>(snapshot.vertex_positions, writer);
  PutRows<std::int32_t>(snapshot.triangle_ids, writer);
  PutRows<std::int32_t>(snapshot.triangle_vertices, writer);
  writer.PutColumn(snapshot.triangle_regions);
  PutRows<std::int32_t>(snapshot.edge_ids, writer);
  PutRows<std::int32_t>(snapshot.edge_vertices, writer);
  writer.PutColumn(snapshot.edge_tags);
  PutRows<std::int32_t>(snapshot.metric_vertex_ids, writer);
  PutRows<double>(snapshot.metrics, writer);
  writer.Put(static_cast<std::uint32_t>(snapshot.fields.changed.size()));
  for (const FieldChange& field : snapshot.fields.changed) {
    writer.PutText(field.name);
    writer.Put(static_cast<std::uint8_t>(field.location));
    writer.Put(static_cast<std::uint8_t>(field.column_count));
    writer.PutColumn(field.rows.slots);
    writer.PutColumn(field.rows.values);
  }
  return SealBytes(kSeal, std::move(writer).Take());
}

Result<MeshDiff> ReadMeshSnapshot(std::span<const std::byte> bytes) {
  PLIANT_ASSIGN_OR_RETURN(const std::span<const std::byte> payload, OpenSeal(bytes, kSeal, kName));
  ByteReader reader(payload);
  MeshDiff mesh;
  mesh.revision = Revision(reader.Take<std::int64_t>());
  mesh.summary = ReadSummary(reader);
  mesh.vertex_ids = TakeRows<std::int32_t, VertexId>(reader);
  mesh.vertex_positions = TakeRows<double, Vec2>(reader);
  mesh.triangle_ids = TakeRows<std::int32_t, TriangleId>(reader);
  mesh.triangle_vertices = TakeRows<std::int32_t, std::array<VertexId, 3>>(reader);
  mesh.triangle_regions = reader.TakeColumn<std::int32_t>();
  mesh.edge_ids = TakeRows<std::int32_t, EdgeId>(reader);
  mesh.edge_vertices = TakeRows<std::int32_t, std::array<VertexId, 2>>(reader);
  mesh.edge_tags = reader.TakeColumn<std::int32_t>();
  mesh.metric_vertex_ids = TakeRows<std::int32_t, VertexId>(reader);
  mesh.metrics = TakeRows<double, Metric>(reader);
  const auto field_count = reader.Take<std::uint32_t>();
  for (std::uint32_t i = 0; i < field_count && reader.ok(); ++i) {
    mesh.fields.changed.push_back(TakeField(reader));
  }
  if (!reader.AtEnd()) return CorruptData(kName, "it is not as long as its columns say");
  if (const std::string fault = FindFault(mesh); !fault.empty()) return CorruptData(kName, fault);
  return mesh;
}

}  // namespace pliant
