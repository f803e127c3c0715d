#include "core/pliant/snapshot.h"

#include <cmath>
#include <cstdint>
#include <utility>

#include "core/pliant/revision_delta.h"

namespace pliant {
namespace {

constexpr Seal kSnapshotSeal{.kind = 0x53534c50, .version = 6};  // "PLSS"
constexpr char kSnapshotName[] = "snapshot";

BoundingBox ReadBox(ByteReader& reader) {
  BoundingBox box{};
  for (double* number : {&box.low.x, &box.low.y, &box.high.x, &box.high.y}) {
    *number = reader.Take<double>();
    if (!std::isfinite(*number)) reader.Fail();
  }
  return box;
}

}  // namespace

Result<Bytes> WriteSnapshot(const SnapshotParts& parts) {
  ByteWriter writer;
  for (const double number :
       {parts.box.low.x, parts.box.low.y, parts.box.high.x, parts.box.high.y}) {
    writer.Put(number);
  }
  writer.Put(static_cast<std::int64_t>(parts.revision));
  WriteSummary(parts.summary, writer);
  WriteMesh(parts.mesh, writer);
  PLIANT_RETURN_IF_ERROR(WriteMetricState(parts.metric, {}, writer));
  WriteRawTensors(parts.raw, writer);
  WriteLoopState(parts.loop, writer);
  WriteFields(parts.fields, writer);
  return SealBytes(kSnapshotSeal, std::move(writer).Take());
}

Result<SavedSession> ReadSnapshot(std::span<const std::byte> bytes) {
  PLIANT_ASSIGN_OR_RETURN(const std::span<const std::byte> payload,
                          OpenSeal(bytes, kSnapshotSeal, kSnapshotName));
  ByteReader reader(payload);
  SavedSession snapshot;
  snapshot.box = ReadBox(reader);
  snapshot.revision = Revision(reader.Take<std::int64_t>());
  if (snapshot.revision <= Revision::kNone) reader.Fail();
  snapshot.summary = ReadSummary(reader);
  snapshot.mesh = ReadMesh(reader);
  snapshot.metric = ReadMetricState(reader, {});
  snapshot.raw = ReadRawTensors(reader);
  const auto vertex_slots = static_cast<std::int32_t>(snapshot.mesh.vertices.size());
  const auto triangle_slots = static_cast<std::int32_t>(snapshot.mesh.triangles.size());
  snapshot.loop = ReadLoopState(reader, vertex_slots);
  snapshot.fields = ReadFields(reader, vertex_slots, triangle_slots);
  if (!reader.AtEnd()) {
    return CorruptData(kSnapshotName, "does not hold what its checksum vouches for");
  }
  return snapshot;
}

}  // namespace pliant
