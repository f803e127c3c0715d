#include "server/record_values.h"

#include <array>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <utility>

#include "core/base/row_bytes.h"
#include "core/mesh/mesh_delta.h"
#include "core/metric/saved_field.h"
#include "core/metric/saved_spec.h"

namespace pliant::server {
namespace {

// Numbers of answers are part of the format.
enum class AnswerKind : std::uint8_t {
  kAccepted = 1,
  kRejected = 2,
  kAdvanced = 3,
  kSoftened = 4,  // kAdvanced with a count of softened corners, which came later.
};
/// Beside the kind: the update's fingerprint follows. Older answers have none.
constexpr std::uint8_t kHasFingerprint = 0x80;

void PutFlag(bool flag, ByteWriter& writer) { writer.Put(static_cast<std::uint8_t>(flag ? 1 : 0)); }
bool TakeFlag(ByteReader& reader) { return reader.Take<std::uint8_t>() != 0; }

template <class Enum>
void PutEnum(Enum value, ByteWriter& writer) {
  writer.Put(static_cast<std::uint8_t>(value));
}
template <class Enum>
Enum TakeEnum(ByteReader& reader, Enum last) {
  const auto value = reader.Take<std::uint8_t>();
  if (value > static_cast<std::uint8_t>(last)) reader.Fail();
  return static_cast<Enum>(value);
}

// By name, which never changes; numbers may.
void PutError(const Error& error, ByteWriter& writer) {
  writer.PutText(ErrorCodeName(error.code));
  writer.PutText(error.message);
  writer.PutText(error.field);
  writer.Put(error.index);
  writer.Put(error.other_index);
}

Error TakeError(ByteReader& reader) {
  Error error;
  const std::string name = reader.TakeText();
  for (int i = 0; i <= static_cast<int>(ErrorCode::kInternal); ++i) {
    if (ErrorCodeName(static_cast<ErrorCode>(i)) == name) error.code = static_cast<ErrorCode>(i);
  }
  error.message = reader.TakeText();
  error.field = reader.TakeText();
  error.index = reader.Take<std::int64_t>();
  error.other_index = reader.Take<std::int64_t>();
  return error;
}

void PutTrouble(const Trouble& trouble, ByteWriter& writer) {
  PutEnum(trouble.kind, writer);
  writer.Put(trouble.vertex_count);
  writer.Put(trouble.place_count);
  for (const double number : {trouble.center.x, trouble.center.y, trouble.box.low.x,
                              trouble.box.low.y, trouble.box.high.x, trouble.box.high.y,
                              trouble.q_min, trouble.length_min, trouble.length_max}) {
    writer.Put(number);
  }
}

Trouble TakeTrouble(ByteReader& reader) {
  Trouble trouble;
  trouble.kind = TakeEnum(reader, TroubleKind::kUnsettled);
  trouble.vertex_count = reader.Take<std::int64_t>();
  trouble.place_count = reader.Take<std::int64_t>();
  for (double* number : {&trouble.center.x, &trouble.center.y, &trouble.box.low.x,
                         &trouble.box.low.y, &trouble.box.high.x, &trouble.box.high.y,
                         &trouble.q_min, &trouble.length_min, &trouble.length_max}) {
    *number = reader.Take<double>();
  }
  return trouble;
}

constexpr std::array kCounts = {&LoopCounts::visits,
                                &LoopCounts::moves,
                                &LoopCounts::insertions,
                                &LoopCounts::deletions,
                                &LoopCounts::swaps,
                                &LoopCounts::cooled,
                                &LoopCounts::mended,
                                &LoopCounts::refused_at_limit,
                                &LoopCounts::refused_by_allowance};

/// What a report begins with; 2 came later than the others.
enum class ReportLayout : std::uint8_t { kNoLimits = 0, kLimits = 1, kSmoothed = 2 };

ReportLayout LayoutOf(const MetricReport& report) {
  if (!report.limits) return ReportLayout::kNoLimits;
  return report.smoothing_count > 0 ? ReportLayout::kSmoothed : ReportLayout::kLimits;
}

void PutReport(const MetricReport& report, ByteWriter& writer) {
  PutEnum(LayoutOf(report), writer);
  if (report.smoothing_count > 0) writer.Put(report.smoothing_count);
  for (const std::int64_t count : {report.geometry_count, report.rotation_count,
                                   report.gradation_count, report.changed_count}) {
    writer.Put(count);
  }
  writer.Put(report.size_ratio_max);
  writer.Put(report.worst.value());
  writer.Put(report.raw_complexity);
  writer.Put(report.limited_complexity);
}

MetricReport TakeReport(ByteReader& reader) {
  MetricReport report;
  const auto layout = TakeEnum(reader, ReportLayout::kSmoothed);
  report.limits = layout != ReportLayout::kNoLimits;
  if (layout == ReportLayout::kSmoothed) report.smoothing_count = reader.Take<std::int64_t>();
  for (std::int64_t* count : {&report.geometry_count, &report.rotation_count,
                              &report.gradation_count, &report.changed_count}) {
    *count = reader.Take<std::int64_t>();
  }
  report.size_ratio_max = reader.Take<double>();
  report.worst = VertexId(reader.Take<std::int32_t>());
  report.raw_complexity = reader.Take<double>();
  report.limited_complexity = reader.Take<double>();
  return report;
}

void PutAdvanced(const AdvancedEvent& advanced, ByteWriter& writer) {
  writer.Put(static_cast<std::int64_t>(advanced.base_revision));
  WriteSummary(advanced.summary, writer);
  PutEnum(advanced.progress.stop_reason, writer);
  writer.Put(advanced.progress.active_count);
  for (const auto count : kCounts) writer.Put(advanced.progress.counts.*count);
  PutReport(advanced.progress.metric, writer);
  writer.Put(static_cast<std::uint32_t>(advanced.troubles.size()));
  for (const Trouble& trouble : advanced.troubles) PutTrouble(trouble, writer);
  PutEnum(advanced.end, writer);
  PutFlag(advanced.motion_fraction.has_value(), writer);
  writer.Put(advanced.motion_fraction.value_or(0));
  writer.Put(static_cast<std::int64_t>(advanced.compute.count()));
  writer.Put(static_cast<std::int64_t>(advanced.elapsed.count()));
  if (advanced.softened_count > 0) writer.Put(advanced.softened_count);
}

AdvancedEvent TakeAdvanced(AnswerKind kind, ByteReader& reader) {
  AdvancedEvent advanced;
  advanced.base_revision = Revision(reader.Take<std::int64_t>());
  advanced.summary = ReadSummary(reader);
  advanced.progress.stop_reason = TakeEnum(reader, StopReason::kVisitLimit);
  advanced.progress.active_count = reader.Take<std::int64_t>();
  for (const auto count : kCounts) advanced.progress.counts.*count = reader.Take<std::int64_t>();
  advanced.progress.metric = TakeReport(reader);
  const auto trouble_count = reader.Take<std::uint32_t>();
  if (trouble_count > kTroublesMax + 8) reader.Fail();
  for (std::uint32_t i = 0; reader.ok() && i < trouble_count; ++i) {
    advanced.troubles.push_back(TakeTrouble(reader));
  }
  advanced.end = TakeEnum(reader, AdvanceEnd::kStaging);
  const bool has_fraction = TakeFlag(reader);
  const auto fraction = reader.Take<double>();
  if (has_fraction) advanced.motion_fraction = fraction;
  advanced.compute = std::chrono::microseconds(reader.Take<std::int64_t>());
  advanced.elapsed = std::chrono::microseconds(reader.Take<std::int64_t>());
  if (kind == AnswerKind::kSoftened) advanced.softened_count = reader.Take<std::int64_t>();
  return advanced;
}

AnswerKind KindOf(const SessionEvent& event) {
  if (std::holds_alternative<AcceptedEvent>(event.body)) return AnswerKind::kAccepted;
  if (std::holds_alternative<RejectedEvent>(event.body)) return AnswerKind::kRejected;
  const bool softened = std::get<AdvancedEvent>(event.body).softened_count > 0;
  return softened ? AnswerKind::kSoftened : AnswerKind::kAdvanced;
}

void PutAnswerKind(const SessionEvent& event, const Fingerprint& update, ByteWriter& writer) {
  const auto kind = static_cast<std::uint8_t>(KindOf(event));
  if (update.kind == UpdateKind::kUnknown) {
    writer.Put(kind);
    return;
  }
  writer.Put(static_cast<std::uint8_t>(kind | kHasFingerprint));
  PutEnum(update.kind, writer);
  writer.Put(update.hash);
}

Fingerprint TakeFingerprint(ByteReader& reader) {
  Fingerprint update;
  update.kind = TakeEnum(reader, UpdateKind::kAdvance);
  update.hash = reader.Take<std::uint64_t>();
  if (update.kind < UpdateKind::kMetric) reader.Fail();
  return update;
}

}  // namespace

void PutAnswer(const UpdateAnswer& answer, ByteWriter& writer) {
  const SessionEvent& event = answer.event;
  writer.Put(event.update_id);
  writer.Put(static_cast<std::int64_t>(event.revision));
  PutAnswerKind(event, answer.update, writer);
  if (const auto* accepted = std::get_if<AcceptedEvent>(&event.body)) {
    writer.Put(accepted->staged_count);
  } else if (const auto* rejected = std::get_if<RejectedEvent>(&event.body)) {
    PutError(rejected->error, writer);
  } else {
    PutAdvanced(std::get<AdvancedEvent>(event.body), writer);
  }
}

UpdateAnswer TakeAnswer(ByteReader& reader) {
  UpdateAnswer answer;
  SessionEvent& event = answer.event;
  event.update_id = reader.Take<std::int64_t>();
  event.revision = Revision(reader.Take<std::int64_t>());
  const auto kind = reader.Take<std::uint8_t>();
  if ((kind & kHasFingerprint) != 0) answer.update = TakeFingerprint(reader);
  const auto answer_kind = static_cast<AnswerKind>(kind & ~kHasFingerprint);
  switch (answer_kind) {
    case AnswerKind::kAccepted:
      event.body = AcceptedEvent{.staged_count = reader.Take<std::int32_t>()};
      break;
    case AnswerKind::kRejected:
      event.body = RejectedEvent{TakeError(reader)};
      break;
    case AnswerKind::kAdvanced:
    case AnswerKind::kSoftened:
      event.body = TakeAdvanced(answer_kind, reader);
      break;
    default:
      reader.Fail();
      return answer;
  }
  const UpdateKind update = answer.update.kind;
  if (update != UpdateKind::kUnknown && !CanAnswer(event, update)) reader.Fail();
  return answer;
}

std::shared_ptr<const MetricSpec> TakeSharedSpec(ByteReader& reader) {
  std::optional<MetricSpec> spec = TakeSpec(reader);
  return spec ? std::make_shared<const MetricSpec>(std::move(*spec)) : nullptr;
}

void PutTransferRows(const TransferRows& rows, ByteWriter& writer) {
  PutRows<std::int32_t>(rows.vertex_ids, writer);
  std::vector<std::int32_t> sources;
  std::vector<double> weights;
  for (const TransferRow& row : rows.rows) {
    for (const VertexId source : row.sources) sources.push_back(source.value());
    weights.insert(weights.end(), row.weights.begin(), row.weights.end());
  }
  writer.PutColumn(sources);
  writer.PutColumn(weights);
}

TransferRows TakeTransferRows(ByteReader& reader) {
  TransferRows rows;
  rows.vertex_ids = TakeRows<std::int32_t, VertexId>(reader);
  const auto sources = reader.TakeColumn<std::int32_t>();
  const auto weights = reader.TakeColumn<double>();
  if (sources.size() != 3 * rows.vertex_ids.size() || weights.size() != sources.size()) {
    reader.Fail();
    return {};
  }
  rows.rows.resize(rows.vertex_ids.size());
  for (std::size_t i = 0; i < sources.size(); ++i) {
    rows.rows[i / 3].sources[i % 3] = VertexId(sources[i]);
    rows.rows[i / 3].weights[i % 3] = weights[i];
  }
  return rows;
}

void PutFields(const FieldChanges& fields, ByteWriter& writer) {
  writer.Put(static_cast<std::uint32_t>(fields.changed.size()));
  for (const FieldChange& change : fields.changed) {
    writer.PutText(change.name);
    PutEnum(change.location, writer);
    writer.Put(static_cast<std::uint32_t>(change.column_count));
    writer.PutColumn(change.rows.slots);
    writer.PutColumn(change.rows.values);
  }
  writer.Put(static_cast<std::uint32_t>(fields.dropped_names.size()));
  for (const std::string& name : fields.dropped_names) writer.PutText(name);
}

FieldChanges TakeFields(ByteReader& reader) {
  FieldChanges fields;
  const auto changed_count = reader.Take<std::uint32_t>();
  for (std::uint32_t i = 0; reader.ok() && i < changed_count; ++i) {
    FieldChange& change = fields.changed.emplace_back();
    change.name = reader.TakeText();
    change.location = TakeEnum(reader, FieldLocation::kTriangle);
    change.column_count = reader.Take<std::uint32_t>();
    change.rows.slots = reader.TakeColumn<std::int32_t>();
    change.rows.values = reader.TakeColumn<double>();
    if (change.rows.values.size() != change.rows.slots.size() * change.column_count) reader.Fail();
  }
  const auto dropped_count = reader.Take<std::uint32_t>();
  for (std::uint32_t i = 0; reader.ok() && i < dropped_count; ++i) {
    fields.dropped_names.push_back(reader.TakeText());
  }
  return fields;
}

void PutDiff(const MeshDiff& diff, ByteWriter& writer) {
  writer.Put(static_cast<std::int64_t>(diff.base_revision));
  writer.Put(static_cast<std::int64_t>(diff.revision));
  const auto put = [&](const auto&... ids) { (PutRows<std::int32_t>(ids, writer), ...); };
  put(diff.removed_vertices, diff.removed_triangles, diff.removed_edges, diff.vertex_ids,
      diff.triangle_ids, diff.triangle_vertices, diff.triangle_regions, diff.edge_ids,
      diff.edge_vertices, diff.edge_tags, diff.created_vertices, diff.created_triangles,
      diff.created_edges, diff.metric_vertex_ids);
  PutRows<double>(diff.vertex_positions, writer);
  PutRows<double>(diff.metrics, writer);
  PutFlag(diff.transfer.has_value(), writer);
  if (diff.transfer) PutTransferRows(*diff.transfer, writer);
  PutFields(diff.fields, writer);
  WriteSummary(diff.summary, writer);
}

MeshDiff TakeDiff(ByteReader& reader) {
  MeshDiff diff;
  diff.base_revision = Revision(reader.Take<std::int64_t>());
  diff.revision = Revision(reader.Take<std::int64_t>());
  const auto take = [&](auto&... ids) {
    ((ids = TakeRows<std::int32_t, typename std::decay_t<decltype(ids)>::value_type>(reader)), ...);
  };
  take(diff.removed_vertices, diff.removed_triangles, diff.removed_edges, diff.vertex_ids,
       diff.triangle_ids, diff.triangle_vertices, diff.triangle_regions, diff.edge_ids,
       diff.edge_vertices, diff.edge_tags, diff.created_vertices, diff.created_triangles,
       diff.created_edges, diff.metric_vertex_ids);
  diff.vertex_positions = TakeRows<double, Vec2>(reader);
  diff.metrics = TakeRows<double, Metric>(reader);
  if (TakeFlag(reader)) diff.transfer = TakeTransferRows(reader);
  diff.fields = TakeFields(reader);
  diff.summary = ReadSummary(reader);
  const bool fits = diff.vertex_positions.size() == diff.vertex_ids.size() &&
                    diff.triangle_vertices.size() == diff.triangle_ids.size() &&
                    diff.triangle_regions.size() == diff.triangle_ids.size() &&
                    diff.edge_vertices.size() == diff.edge_ids.size() &&
                    diff.edge_tags.size() == diff.edge_ids.size() &&
                    diff.metrics.size() == diff.metric_vertex_ids.size();
  if (!fits) reader.Fail();
  return diff;
}

void PutBytes(std::span<const std::byte> bytes, ByteWriter& writer) {
  writer.PutColumn(
      std::span<const char>(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

Bytes TakeBytes(ByteReader& reader) {
  const std::vector<char> column = reader.TakeColumn<char>();
  const auto bytes = std::as_bytes(std::span(column));
  return Bytes(bytes.begin(), bytes.end());
}

void PutTime(Clock::WallTime time, ByteWriter& writer) {
  writer.Put(static_cast<std::int64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count()));
}

Clock::WallTime TakeTime(ByteReader& reader) {
  return Clock::WallTime(std::chrono::duration_cast<Clock::WallTime::duration>(
      std::chrono::nanoseconds(reader.Take<std::int64_t>())));
}

}  // namespace pliant::server
