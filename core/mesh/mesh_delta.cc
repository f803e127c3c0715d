#include "core/mesh/mesh_delta.h"

#include <algorithm>
#include <array>
#include <span>
#include <tuple>
#include <type_traits>

namespace pliant {
namespace {

template <class IdType, class Record>
std::size_t BytesOf(const RecordsAt<IdType, Record>& at) {
  // Room to spare is memory that nobody has written to: see RecordLog::Take.
  return at.ids.size() * sizeof(IdType) + at.records.size() * sizeof(Record);
}

/// Where both have a record, the second one's stands.
template <class IdType, class Record>
RecordsAt<IdType, Record> MergeAt(const RecordsAt<IdType, Record>& first,
                                  const RecordsAt<IdType, Record>& second) {
  RecordsAt<IdType, Record> merged;
  merged.slots = second.slots;
  merged.ids.reserve(first.ids.size() + second.ids.size());
  merged.records.reserve(first.ids.size() + second.ids.size());
  const auto take = [&merged](const RecordsAt<IdType, Record>& from, std::size_t i) {
    merged.ids.push_back(from.ids[i]);
    merged.records.push_back(from.records[i]);
  };
  std::size_t i = 0;
  for (std::size_t j = 0; j < second.ids.size(); ++j) {
    while (i < first.ids.size() && first.ids[i] < second.ids[j]) take(first, i++);
    if (i < first.ids.size() && first.ids[i] == second.ids[j]) ++i;
    take(second, j);
  }
  while (i < first.ids.size()) take(first, i++);
  return merged;
}

SegmentsAt MergeSegments(const SegmentsAt& first, const SegmentsAt& second) {
  SegmentsAt merged;
  merged.slots = second.slots;
  const auto take = [&merged](const SegmentsAt& from, std::size_t i) {
    if (from.indices[i] >= merged.slots) return;
    merged.indices.push_back(from.indices[i]);
    merged.records.push_back(from.records[i]);
  };
  std::size_t i = 0;
  for (std::size_t j = 0; j < second.indices.size(); ++j) {
    while (i < first.indices.size() && first.indices[i] < second.indices[j]) take(first, i++);
    if (i < first.indices.size() && first.indices[i] == second.indices[j]) ++i;
    take(second, j);
  }
  while (i < first.indices.size()) take(first, i++);
  return merged;
}

/// One column: the value that `get` takes from each record.
template <class Record, class Get>
void PutEach(std::span<const Record> records, ByteWriter& writer, Get get) {
  using Value = std::decay_t<decltype(get(records[0]))>;
  std::vector<Value> values;
  values.reserve(records.size());
  for (const Record& record : records) values.push_back(get(record));
  writer.PutColumn(values);
}

/// A column that was read, and how its values enter the records.
template <class Value, class Set>
struct Column {
  std::vector<Value> values;
  Set set;
};

/// Its counterpart; fails unless the column has a value for each record.
template <class Value, class Records, class Set>
Column<Value, Set> TakeEach(ByteReader& reader, const Records& records, Set set) {
  Column<Value, Set> column{reader.TakeColumn<Value>(), set};
  if (column.values.size() != records.size()) reader.Fail();
  return column;
}

/// Writes columns into records, a few records at a time: a record is larger than its share of any
/// column, so that whole columns one after the other would bring all records from memory each time.
template <class Records, class Columns>
void Fill(const ByteReader& reader, const Columns& columns, Records& records) {
  constexpr std::size_t kBlock = 512;
  if (!reader.ok()) return;
  for (std::size_t begin = 0; begin < records.size(); begin += kBlock) {
    const std::size_t end = std::min(records.size(), begin + kBlock);
    const auto fill = [&](const auto& column) {
      for (std::size_t i = begin; i < end; ++i) column.set(records[i], column.values[i]);
    };
    std::apply([&](const auto&... each) { (fill(each), ...); }, columns);
  }
}

// Flags of a vertex, in bits.
std::uint8_t FlagsOf(const VertexRecord& record) {
  return static_cast<std::uint8_t>((record.live ? 1 : 0) | (record.fixed ? 2 : 0) |
                                   (record.pinched ? 4 : 0) | (record.visit.active ? 8 : 0) |
                                   (record.visit.cold ? 16 : 0) | (record.visit.tired ? 32 : 0) |
                                   (record.visit.mended ? 64 : 0) | (record.frozen ? 128 : 0));
}

void SetFlags(VertexRecord& record, std::uint8_t flags) {
  record.live = record.committed = (flags & 1) != 0;
  record.fixed = (flags & 2) != 0;
  record.pinched = (flags & 4) != 0;
  record.visit.active = (flags & 8) != 0;
  record.visit.cold = (flags & 16) != 0;
  record.visit.tired = (flags & 32) != 0;
  record.visit.mended = (flags & 64) != 0;
  record.frozen = (flags & 128) != 0;
}

template <class Record>
std::uint8_t Life(const Record& record) {
  return static_cast<std::uint8_t>((record.live ? 1 : 0) | (record.frozen ? 2 : 0));
}
template <class Record>
void SetLife(Record& record, std::uint8_t life) {
  record.live = record.committed = (life & 1) != 0;
  record.frozen = (life & 2) != 0;
}

void PutRecords(std::span<const VertexRecord> records, ByteWriter& writer) {
  writer.Put(static_cast<std::uint64_t>(records.size()));
  using R = VertexRecord;
  PutEach(records, writer, [](const R& r) { return r.position.x; });
  PutEach(records, writer, [](const R& r) { return r.position.y; });
  PutEach(records, writer, [](const R& r) { return r.metric.m11; });
  PutEach(records, writer, [](const R& r) { return r.metric.m12; });
  PutEach(records, writer, [](const R& r) { return r.metric.m22; });
  PutEach(records, writer, [](const R& r) { return r.triangle.value(); });
  PutEach(records, writer, [](const R& r) { return r.edge.value(); });
  PutEach(records, writer, [](const R& r) { return r.visit.drift_x; });
  PutEach(records, writer, [](const R& r) { return r.visit.drift_y; });
  PutEach(records, writer, [](const R& r) { return r.visit.epoch; });
  PutEach(records, writer, [](const R& r) { return r.visit.age; });
  PutEach(records, writer, [](const R& r) { return r.visit.hop; });
  PutEach(records, writer, FlagsOf);
}

template <class Records>
void TakeVertexRecords(ByteReader& reader, Records& records) {
  using R = VertexRecord;
  // Braces, because they keep the order of what stands in them.
  const std::tuple columns{
      TakeEach<double>(reader, records, [](R& r, double v) { r.position.x = v; }),
      TakeEach<double>(reader, records, [](R& r, double v) { r.position.y = v; }),
      TakeEach<double>(reader, records, [](R& r, double v) { r.metric.m11 = v; }),
      TakeEach<double>(reader, records, [](R& r, double v) { r.metric.m12 = v; }),
      TakeEach<double>(reader, records, [](R& r, double v) { r.metric.m22 = v; }),
      TakeEach<std::int32_t>(reader, records, [](R& r, auto v) { r.triangle = TriangleId(v); }),
      TakeEach<std::int32_t>(reader, records, [](R& r, auto v) { r.edge = EdgeId(v); }),
      TakeEach<float>(reader, records, [](R& r, float v) { r.visit.drift_x = v; }),
      TakeEach<float>(reader, records, [](R& r, float v) { r.visit.drift_y = v; }),
      TakeEach<std::uint32_t>(reader, records, [](R& r, auto v) { r.visit.epoch = v; }),
      TakeEach<std::uint8_t>(reader, records, [](R& r, auto v) { r.visit.age = v; }),
      TakeEach<std::uint8_t>(reader, records, [](R& r, auto v) { r.visit.hop = v; }),
      TakeEach<std::uint8_t>(reader, records, SetFlags)};
  Fill(reader, columns, records);
}

void PutRecords(std::span<const TriangleRecord> records, ByteWriter& writer) {
  writer.Put(static_cast<std::uint64_t>(records.size()));
  using R = TriangleRecord;
  for (std::size_t k = 0; k < 3; ++k) {
    PutEach(records, writer, [k](const R& r) { return r.vertices[k].value(); });
    PutEach(records, writer, [k](const R& r) { return r.neighbors[k].value(); });
  }
  PutEach(records, writer, [](const R& r) { return r.region; });
  PutEach(records, writer, [](const R& r) { return r.constrained; });
  PutEach(records, writer, Life<R>);
}

template <class Records>
void TakeTriangleRecords(ByteReader& reader, Records& records) {
  using R = TriangleRecord;
  const auto vertex = [&](std::size_t k) {
    return TakeEach<std::int32_t>(reader, records,
                                  [k](R& r, auto v) { r.vertices[k] = VertexId(v); });
  };
  const auto neighbor = [&](std::size_t k) {
    return TakeEach<std::int32_t>(reader, records,
                                  [k](R& r, auto v) { r.neighbors[k] = TriangleId(v); });
  };
  const std::tuple columns{
      vertex(0),
      neighbor(0),
      vertex(1),
      neighbor(1),
      vertex(2),
      neighbor(2),
      TakeEach<std::int32_t>(reader, records, [](R& r, auto v) { r.region = v; }),
      TakeEach<std::uint8_t>(reader, records, [](R& r, auto v) { r.constrained = v; }),
      TakeEach<std::uint8_t>(reader, records, SetLife<R>)};
  Fill(reader, columns, records);
}

void PutRecords(std::span<const EdgeRecord> records, ByteWriter& writer) {
  writer.Put(static_cast<std::uint64_t>(records.size()));
  using R = EdgeRecord;
  for (std::size_t k = 0; k < 2; ++k) {
    PutEach(records, writer, [k](const R& r) { return r.vertices[k].value(); });
    PutEach(records, writer, [k](const R& r) { return r.parameters[k]; });
    PutEach(records, writer, [k](const R& r) { return r.next[k].value(); });
  }
  PutEach(records, writer, [](const R& r) { return r.triangle.value(); });
  PutEach(records, writer, [](const R& r) { return r.tag; });
  PutEach(records, writer, [](const R& r) { return r.segment; });
  PutEach(records, writer, Life<R>);
}

template <class Records>
void TakeEdgeRecords(ByteReader& reader, Records& records) {
  using R = EdgeRecord;
  const auto vertex = [&](std::size_t k) {
    return TakeEach<std::int32_t>(reader, records,
                                  [k](R& r, auto v) { r.vertices[k] = VertexId(v); });
  };
  const auto parameter = [&](std::size_t k) {
    return TakeEach<double>(reader, records, [k](R& r, double v) { r.parameters[k] = v; });
  };
  const auto next = [&](std::size_t k) {
    return TakeEach<std::int32_t>(reader, records, [k](R& r, auto v) { r.next[k] = EdgeId(v); });
  };
  const std::tuple columns{
      vertex(0),
      parameter(0),
      next(0),
      vertex(1),
      parameter(1),
      next(1),
      TakeEach<std::int32_t>(reader, records, [](R& r, auto v) { r.triangle = TriangleId(v); }),
      TakeEach<std::int32_t>(reader, records, [](R& r, auto v) { r.tag = v; }),
      TakeEach<std::int32_t>(reader, records, [](R& r, auto v) { r.segment = v; }),
      TakeEach<std::uint8_t>(reader, records, SetLife<R>)};
  Fill(reader, columns, records);
}

void PutSegments(std::span<const SegmentRecord> segments, ByteWriter& writer) {
  PutEach(segments, writer, [](const SegmentRecord& segment) { return segment.a.value(); });
  PutEach(segments, writer, [](const SegmentRecord& segment) { return segment.b.value(); });
}

std::vector<SegmentRecord> TakeSegments(ByteReader& reader) {
  std::vector<SegmentRecord> segments;
  for (const std::int32_t a : reader.TakeColumn<std::int32_t>()) {
    segments.push_back({VertexId(a), VertexId()});
  }
  const std::tuple columns{TakeEach<std::int32_t>(
      reader, segments, [](SegmentRecord& segment, auto b) { segment.b = VertexId(b); })};
  Fill(reader, columns, segments);
  return segments;
}

/// Every record as its columns say, or none if the reader fails.
template <class Records>
Records TakeAll(ByteReader& reader) {
  // A record of any kind takes more bytes than this, so that a wrong count is found before memory
  // is taken for it.
  constexpr std::size_t kRecordBytesMin = 24;
  const auto count = reader.Take<std::uint64_t>();
  if (!reader.ok() || count > reader.size_left() / kRecordBytesMin) {
    reader.Fail();
    return {};
  }
  Records records(static_cast<std::size_t>(count));
  using Record = typename Records::value_type;
  if constexpr (std::is_same_v<Record, VertexRecord>) {
    TakeVertexRecords(reader, records);
  } else if constexpr (std::is_same_v<Record, TriangleRecord>) {
    TakeTriangleRecords(reader, records);
  } else {
    TakeEdgeRecords(reader, records);
  }
  if (!reader.ok()) records.clear();
  return records;
}

template <class IdType, class Record>
void PutChanges(const RecordsAt<IdType, Record>& at, ByteWriter& writer) {
  writer.Put(at.slots);
  PutEach(std::span<const IdType>(at.ids), writer, [](IdType id) { return id.value(); });
  PutRecords(std::span<const Record>(at.records), writer);
}

template <class IdType, class Record>
void TakeChanges(ByteReader& reader, RecordsAt<IdType, Record>& at) {
  at.slots = reader.Take<std::int32_t>();
  for (const std::int32_t id : reader.TakeColumn<std::int32_t>()) {
    if (id < 0 || (!at.ids.empty() && id <= at.ids.back().value())) reader.Fail();
    at.ids.emplace_back(id);
  }
  at.records = TakeAll<MeshVector<Record>>(reader);
  if (at.slots < 0 || at.records.size() != at.ids.size()) reader.Fail();
  for (std::size_t i = 0; i < at.records.size() && reader.ok(); ++i) {
    if (at.records[i].live && at.ids[i].value() >= at.slots) reader.Fail();
  }
}

/// DeltaSlots of each kind, and what an id may therefore be.
struct DeltaSlots {
  std::int32_t vertices = 0;
  std::int32_t triangles = 0;
  std::int32_t edges = 0;

  [[nodiscard]] bool MayBe(VertexId id) const { return id.value() >= -1 && id.value() < vertices; }
  [[nodiscard]] bool MayBe(TriangleId id) const {
    return id.value() >= -1 && id.value() < triangles;
  }
  [[nodiscard]] bool MayBe(EdgeId id) const { return id.value() >= -1 && id.value() < edges; }

  [[nodiscard]] bool Fit(const VertexRecord& r) const {
    return MayBe(r.triangle) && MayBe(r.edge) && (!r.live || r.triangle.valid());
  }
  [[nodiscard]] bool Fit(const TriangleRecord& r) const {
    bool fit = r.constrained < 8;
    for (std::size_t k = 0; k < 3; ++k) {
      fit = fit && MayBe(r.vertices[k]) && MayBe(r.neighbors[k]);
      fit = fit && (!r.live || r.vertices[k].valid());
    }
    return fit;
  }
  [[nodiscard]] bool Fit(const EdgeRecord& r) const {
    bool fit = MayBe(r.triangle) && r.segment >= -1;
    for (std::size_t k = 0; k < 2; ++k) fit = fit && MayBe(r.vertices[k]) && MayBe(r.next[k]);
    return fit && (!r.live || (r.vertices[0].valid() && r.vertices[1].valid() &&
                               r.triangle.valid() && r.segment >= 0));
  }
  [[nodiscard]] bool Fit(const SegmentRecord& r) const {
    return (r.a.valid() || !r.b.valid()) && MayBe(r.a) && MayBe(r.b);
  }
  [[nodiscard]] bool Fit(const SegmentsAt& at) const {
    bool fit = at.slots >= 0 && at.indices.size() == at.records.size() && FitAll(at.records);
    for (std::size_t i = 0; i < at.indices.size(); ++i) {
      fit = fit && at.indices[i] >= 0 && at.indices[i] < at.slots;
      fit = fit && (i == 0 || at.indices[i] > at.indices[i - 1]);
    }
    return fit;
  }
  template <class Records>
  [[nodiscard]] bool FitAll(const Records& records) const {
    for (const auto& record : records) {
      if (!Fit(record)) return false;
    }
    return true;
  }
};

}  // namespace

std::size_t MeshDelta::bytes() const {
  return sizeof(MeshDelta) + BytesOf(vertices) + BytesOf(triangles) + BytesOf(edges) +
         segments.indices.size() * (sizeof(std::int32_t) + sizeof(SegmentRecord));
}

MeshDelta Merge(const MeshDelta& first, const MeshDelta& second) {
  return {MergeAt(first.vertices, second.vertices),
          MergeAt(first.triangles, second.triangles),
          MergeAt(first.edges, second.edges),
          MergeSegments(first.segments, second.segments),
          first.base,
          second.summary};
}

void WriteMeshDelta(const MeshDelta& delta, ByteWriter& writer) {
  PutChanges(delta.vertices, writer);
  PutChanges(delta.triangles, writer);
  PutChanges(delta.edges, writer);
  writer.Put(delta.segments.slots);
  writer.PutColumn(delta.segments.indices);
  PutSegments(delta.segments.records, writer);
  WriteSummary(delta.base, writer);
  WriteSummary(delta.summary, writer);
}

MeshDelta ReadMeshDelta(ByteReader& reader) {
  MeshDelta delta;
  TakeChanges(reader, delta.vertices);
  TakeChanges(reader, delta.triangles);
  TakeChanges(reader, delta.edges);
  delta.segments.slots = reader.Take<std::int32_t>();
  delta.segments.indices = reader.TakeColumn<std::int32_t>();
  delta.segments.records = TakeSegments(reader);
  delta.base = ReadSummary(reader);
  delta.summary = ReadSummary(reader);
  const DeltaSlots slots{delta.vertices.slots, delta.triangles.slots, delta.edges.slots};
  if (!slots.FitAll(delta.vertices.records) || !slots.FitAll(delta.triangles.records) ||
      !slots.FitAll(delta.edges.records) || !slots.Fit(delta.segments)) {
    reader.Fail();
  }
  return delta;
}

void WriteSummary(const MeshSummary& summary, ByteWriter& writer) {
  writer.Put(summary.vertex_count);
  writer.Put(summary.triangle_count);
  writer.Put(summary.edge_count);
  writer.Put(summary.state_hash);
}

MeshSummary ReadSummary(ByteReader& reader) {
  MeshSummary summary;
  summary.vertex_count = reader.Take<std::int32_t>();
  summary.triangle_count = reader.Take<std::int32_t>();
  summary.edge_count = reader.Take<std::int32_t>();
  summary.state_hash = reader.Take<std::uint64_t>();
  return summary;
}

void WriteMesh(const Mesh& mesh, ByteWriter& writer) {
  PutRecords(mesh.vertex_records(), writer);
  PutRecords(mesh.triangle_records(), writer);
  PutRecords(mesh.edge_records(), writer);
  PutSegments(mesh.segments(), writer);
}

MeshState ReadMesh(ByteReader& reader) {
  MeshState state;
  state.vertices = TakeAll<MeshVector<VertexRecord>>(reader);
  state.triangles = TakeAll<MeshVector<TriangleRecord>>(reader);
  state.edges = TakeAll<std::vector<EdgeRecord>>(reader);
  state.segments = TakeSegments(reader);
  const DeltaSlots slots{static_cast<std::int32_t>(state.vertices.size()),
                         static_cast<std::int32_t>(state.triangles.size()),
                         static_cast<std::int32_t>(state.edges.size())};
  bool fit = slots.FitAll(state.vertices) && slots.FitAll(state.triangles) &&
             slots.FitAll(state.edges) && slots.FitAll(state.segments);
  for (const EdgeRecord& edge : state.edges) {
    fit = fit && edge.segment < static_cast<std::int32_t>(state.segments.size());
  }
  if (!fit) reader.Fail();
  return state;
}

}  // namespace pliant
