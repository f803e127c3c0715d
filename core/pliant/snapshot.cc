#include "core/pliant/snapshot.h"

#include <cmath>
#include <cstdint>
#include <utility>

#include "core/pliant/check_options.h"
#include "core/pliant/revision_delta.h"

namespace pliant {
namespace {

constexpr Seal kSnapshotSeal{.kind = 0x53534c50, .version = 2};  // "PLSS"
constexpr char kSnapshotName[] = "snapshot";

void WriteOptions(const Options& options, ByteWriter& writer) {
  writer.Put(static_cast<std::uint8_t>(options.variant));
  writer.Put(static_cast<std::uint8_t>(options.smoothing));
  const Permissions& may = options.permissions;
  writer.Put(
      static_cast<std::uint8_t>((may.insert ? 1 : 0) | (may.swap ? 2 : 0) | (may.move ? 4 : 0)));
  writer.Put(options.seed);
  writer.Put(options.step);
  writer.Put(options.speed_threshold);
  writer.Put(options.age_cooling);
  writer.Put(options.age_max);
  writer.Put(options.hops_max);
  writer.Put(options.metric_tolerance);
  writer.Put(options.vertices_max);
  writer.Put(options.visits_per_vertex_max);
}

Options ReadOptions(ByteReader& reader) {
  Options options;
  const auto variant = reader.Take<std::uint8_t>();
  const auto smoothing = reader.Take<std::uint8_t>();
  const auto may = reader.Take<std::uint8_t>();
  if (variant > static_cast<std::uint8_t>(Variant::kPaper) ||
      smoothing > static_cast<std::uint8_t>(Smoothing::kBubble) || may > 7) {
    reader.Fail();
  }
  options.variant = static_cast<Variant>(variant);
  options.smoothing = static_cast<Smoothing>(smoothing);
  options.permissions = {(may & 1) != 0, (may & 2) != 0, (may & 4) != 0};
  options.seed = reader.Take<std::uint64_t>();
  options.step = reader.Take<double>();
  options.speed_threshold = reader.Take<double>();
  options.age_cooling = reader.Take<std::int32_t>();
  options.age_max = reader.Take<std::int32_t>();
  options.hops_max = reader.Take<std::int32_t>();
  options.metric_tolerance = reader.Take<double>();
  options.vertices_max = reader.Take<std::int32_t>();
  options.visits_per_vertex_max = reader.Take<std::int32_t>();
  if (!CheckOptions(options).ok()) reader.Fail();
  return options;
}

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
  WriteOptions(parts.options, writer);
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
  snapshot.options = ReadOptions(reader);
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
