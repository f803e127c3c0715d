#include "core/pliant/revision_delta.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/metric/saved_field.h"
#include "core/metric/saved_spec.h"
#include "core/pliant/saved_options.h"

namespace pliant {
namespace {

/// Bits of a metric state. Part of the format: add, never renumber.
constexpr std::uint8_t kUsualHold = 1;
constexpr std::uint8_t kLimitsDue = 2;
constexpr std::uint8_t kFunctionsOfBase = 4;
constexpr std::uint8_t kFunctionsWritten = 8;

constexpr Seal kDeltaSeal{.kind = 0x44524c50, .version = 6};  // "PLRD"
constexpr char kDeltaName[] = "revision record";

/// Where a field comes from when it is read.
enum class FieldOrigin : std::uint8_t { kBase = 0, kVertices = 1, kWritten = 2 };

/// A specification that FollowedMetric remembers.
std::optional<MetricSpec> TakeFormula(ByteReader& reader) {
  std::optional<MetricSpec> spec = TakeSpec(reader);
  if (spec && !IsFormula(*spec)) reader.Fail();
  return spec;
}

RevisionDelta MergeTwo(const RevisionDelta& first, const RevisionDelta& second) {
  return {.base = first.base,
          .revision = second.revision,
          .mesh = Merge(first.mesh, second.mesh),
          .metric = second.metric,
          .base_metric = first.base_metric,
          .raw = Merge(first.raw, second.raw),
          .loop = second.loop,
          .fields = second.fields,
          .base_fields = first.base_fields};
}

}  // namespace

std::size_t RevisionDelta::bytes() const {
  std::size_t bytes =
      sizeof(RevisionDelta) + mesh.bytes() + raw.bytes() + loop.queue.size() * sizeof(VertexId);
  if (metric.source != nullptr && metric.source != base_metric.source) {
    bytes += metric.source->bytes();
  }
  if (metric.functions != nullptr && metric.functions != base_metric.functions) {
    bytes += metric.functions->bytes();
  }
  if (fields != base_fields) bytes += BytesOf(fields);
  return bytes;
}

RevisionDelta Merge(std::span<const RevisionDelta* const> deltas) {
  PLIANT_CHECK(!deltas.empty());
  if (deltas.size() == 1) return *deltas.front();
  const std::size_t half = deltas.size() / 2;
  return MergeTwo(Merge(deltas.first(half)), Merge(deltas.subspan(half)));
}

Result<Bytes> WriteDelta(const RevisionDelta& delta) {
  ByteWriter writer;
  writer.Put(static_cast<std::int64_t>(delta.base));
  writer.Put(static_cast<std::int64_t>(delta.revision));
  WriteMeshDelta(delta.mesh, writer);
  PLIANT_RETURN_IF_ERROR(WriteMetricState(delta.metric, delta.base_metric, writer));
  WriteRawTensors(delta.raw, writer);
  WriteLoopState(delta.loop, writer);
  const bool same_fields = delta.fields == delta.base_fields;
  writer.Put(static_cast<std::uint8_t>(same_fields ? FieldOrigin::kBase : FieldOrigin::kWritten));
  if (!same_fields) WriteFields(delta.fields, writer);
  return SealBytes(kDeltaSeal, std::move(writer).Take());
}

Result<RevisionDelta> ReadDelta(std::span<const std::byte> bytes, const FollowedMetric::State& base,
                                const SharedFields& base_fields) {
  PLIANT_ASSIGN_OR_RETURN(const std::span<const std::byte> payload,
                          OpenSeal(bytes, kDeltaSeal, kDeltaName));
  ByteReader reader(payload);
  RevisionDelta delta;
  delta.base = Revision(reader.Take<std::int64_t>());
  delta.revision = Revision(reader.Take<std::int64_t>());
  delta.mesh = ReadMeshDelta(reader);
  delta.metric = ReadMetricState(reader, base);
  delta.raw = ReadRawTensors(reader);
  delta.base_metric = base;
  delta.loop = ReadLoopState(reader, delta.mesh.vertices.slots);
  delta.base_fields = base_fields;
  delta.fields = base_fields;
  if (static_cast<FieldOrigin>(reader.Take<std::uint8_t>()) != FieldOrigin::kBase) {
    delta.fields = ReadFields(reader, delta.mesh.vertices.slots, delta.mesh.triangles.slots);
  }
  if (!reader.AtEnd())
    return CorruptData(kDeltaName, "does not hold what its checksum vouches for");
  return delta;
}

Status WriteMetricState(const FollowedMetric::State& state, const FollowedMetric::State& base,
                        ByteWriter& writer) {
  const FieldOrigin origin = state.source == nullptr       ? FieldOrigin::kVertices
                             : state.source == base.source ? FieldOrigin::kBase
                                                           : FieldOrigin::kWritten;
  writer.Put(static_cast<std::uint8_t>(origin));
  if (origin == FieldOrigin::kWritten) PLIANT_RETURN_IF_ERROR(state.source->Save(writer));
  PutSpec(state.spec ? &*state.spec : nullptr, writer);
  PutBounds(state.bounds, writer);
  PutGradation(state.limits, writer);
  const bool is_of_base = MetricFunctions::AreSame(state.functions.get(), base.functions.get());
  const std::uint8_t functions = state.functions == nullptr ? 0
                                 : is_of_base               ? kFunctionsOfBase
                                                            : kFunctionsWritten;
  writer.Put(static_cast<std::uint8_t>((state.usual_hold ? kUsualHold : 0) |
                                       (state.limits_due ? kLimitsDue : 0) | functions));
  writer.Put(static_cast<std::int32_t>(state.limit_rounds_left));
  if (functions == kFunctionsWritten) state.functions->Save(writer);
  return {};
}

FollowedMetric::State ReadMetricState(ByteReader& reader, const FollowedMetric::State& base) {
  FollowedMetric::State state;
  switch (static_cast<FieldOrigin>(reader.Take<std::uint8_t>())) {
    case FieldOrigin::kBase:
      state.source = base.source;
      if (state.source == nullptr) reader.Fail();
      break;
    case FieldOrigin::kVertices:
      break;
    case FieldOrigin::kWritten:
      state.source = ReadField(reader);
      break;
    default:
      reader.Fail();
  }
  state.spec = TakeFormula(reader);
  state.bounds = TakeBounds(reader);
  state.limits = TakeGradation(reader);
  if (!FollowedMetric::Check(MetricLimits{state.bounds, state.limits}).ok()) reader.Fail();
  const auto flags = reader.Take<std::uint8_t>();
  const int functions = flags & (kFunctionsOfBase | kFunctionsWritten);
  if (flags >= 2 * kFunctionsWritten || functions == (kFunctionsOfBase | kFunctionsWritten)) {
    reader.Fail();
  }
  state.usual_hold = (flags & kUsualHold) != 0;
  state.limits_due = (flags & kLimitsDue) != 0;
  if (state.limits_due && (state.source == nullptr || !state.limits.any())) reader.Fail();
  state.limit_rounds_left = reader.Take<std::int32_t>();
  if (state.limit_rounds_left < 0 || state.limit_rounds_left > 100) reader.Fail();
  if (functions == kFunctionsOfBase) state.functions = base.functions;
  if (functions == kFunctionsWritten) state.functions = MetricFunctions::Read(reader);
  // They stand beside tensors at vertices.
  const bool should_have = functions != 0;
  if (should_have != (state.functions != nullptr)) reader.Fail();
  if (state.functions != nullptr && state.source != nullptr) reader.Fail();
  return state;
}

void WriteRawTensors(const RawTensors& raw, ByteWriter& writer) {
  writer.Put(static_cast<std::uint8_t>(raw.all ? 1 : 0));
  std::vector<std::int32_t> slots;
  std::vector<double> entries;
  for (const VertexId vertex : raw.vertices) slots.push_back(vertex.value());
  for (const Metric& m : raw.tensors) entries.insert(entries.end(), {m.m11, m.m12, m.m22});
  writer.PutColumn(slots);
  writer.PutColumn(entries);
}

RawTensors ReadRawTensors(ByteReader& reader) {
  RawTensors raw;
  raw.all = reader.Take<std::uint8_t>() != 0;
  const auto slots = reader.TakeColumn<std::int32_t>();
  const auto entries = reader.TakeColumn<double>();
  if (entries.size() != 3 * slots.size()) reader.Fail();
  for (std::size_t i = 0; i < slots.size() && reader.ok(); ++i) {
    const Metric tensor{entries[3 * i], entries[3 * i + 1], entries[3 * i + 2]};
    const bool ascends = slots[i] > (i == 0 ? -1 : slots[i - 1]);
    if (!ascends || !IsFinite(tensor) || !IsPositiveDefinite(tensor)) reader.Fail();
    raw.vertices.emplace_back(slots[i]);
    raw.tensors.push_back(tensor);
  }
  return raw;
}

namespace {

void PutNodes(std::span<const VertexId> nodes, ByteWriter& writer) {
  std::vector<std::int32_t> slots;
  slots.reserve(nodes.size());
  for (const VertexId node : nodes) slots.push_back(node.value());
  writer.PutColumn(slots);
}

std::vector<VertexId> TakeNodes(ByteReader& reader, std::int32_t vertex_slots) {
  std::vector<VertexId> nodes;
  for (const std::int32_t node : reader.TakeColumn<std::int32_t>()) {
    if (node < 0 || node >= vertex_slots) reader.Fail();
    nodes.emplace_back(node);
  }
  return nodes;
}

}  // namespace

void WriteLoopState(const PliantLoop::State& state, ByteWriter& writer) {
  WriteOptions(state.options, writer);
  PutNodes(state.queue.entries(), writer);
  for (const std::uint64_t word : state.rng.state()) writer.Put(word);
  writer.Put(state.epoch);
  writer.Put(state.visits_in_update);
  writer.Put(state.settings.alpha);
  writer.Put(state.settings.speed_threshold);
  writer.Put(state.settings.neighbor_threshold);
  writer.Put(state.settings.age_cooling);
  writer.Put(state.settings.age_max);
  writer.Put(static_cast<std::uint8_t>(state.mending));
  writer.Put(state.mender.warm_since);
  PutNodes(state.mender.moved, writer);
  PutNodes(std::span(state.mender.waiting).subspan(state.mender.next), writer);
  PutNodes(state.mender.next_round, writer);
  PutNodes(state.mender.poor, writer);
  const InsertionAllowance::State& allowance = state.allowance.state();
  writer.Put(allowance.used);
  writer.Put(allowance.granted);
  writer.Put(static_cast<std::uint8_t>(allowance.exhausted ? 1 : 0));
}

PliantLoop::State ReadLoopState(ByteReader& reader, std::int32_t vertex_slots) {
  PliantLoop::State state;
  state.options = ReadOptions(reader);
  for (const VertexId node : TakeNodes(reader, vertex_slots)) state.queue.Push(node);
  std::array<std::uint64_t, 4> words;
  for (std::uint64_t& word : words) word = reader.Take<std::uint64_t>();
  state.rng = Rng::At(words);
  state.epoch = reader.Take<std::uint32_t>();
  state.visits_in_update = reader.Take<std::int64_t>();
  state.settings.alpha = reader.Take<double>();
  state.settings.speed_threshold = reader.Take<double>();
  state.settings.neighbor_threshold = reader.Take<double>();
  state.settings.age_cooling = reader.Take<std::int32_t>();
  state.settings.age_max = reader.Take<std::int32_t>();
  const LoopSettings& settings = state.settings;
  if (settings.age_cooling < 0 || settings.age_cooling >= settings.age_max ||
      settings.age_max > 250) {
    reader.Fail();
  }
  const auto mending = reader.Take<std::uint8_t>();
  if (mending > static_cast<std::uint8_t>(PliantLoop::Mending::kDone)) reader.Fail();
  state.mending = static_cast<PliantLoop::Mending>(mending);
  state.mender.warm_since = reader.Take<std::uint32_t>();
  state.mender.moved = TakeNodes(reader, vertex_slots);
  state.mender.waiting = TakeNodes(reader, vertex_slots);
  state.mender.next_round = TakeNodes(reader, vertex_slots);
  state.mender.poor = TakeNodes(reader, vertex_slots);
  InsertionAllowance::State allowance;
  allowance.used = reader.Take<std::int64_t>();
  allowance.granted = reader.Take<std::int64_t>();
  allowance.exhausted = reader.Take<std::uint8_t>() != 0;
  if (allowance.used < 0 || allowance.granted < 0) reader.Fail();
  state.allowance = InsertionAllowance::At(allowance);
  return state;
}

}  // namespace pliant
