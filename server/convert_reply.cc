#include "server/convert_reply.h"

#include <chrono>
#include <span>
#include <variant>
#include <vector>

#include "core/base/check.h"
#include "server/convert_array.h"
#include "server/convert_fields.h"
#include "server/error_status.h"

namespace pliant::server {
namespace {

template <class T>
void Write(const std::vector<T>& rows, v1::Array& array) {
  WriteRows(std::span<const T>(rows), array);
}

void WriteMetrics(const MeshDiff& diff, v1::VertexMetrics& wire) {
  Write(diff.metric_vertex_ids, *wire.mutable_vertex_ids());
  Write(diff.metrics, *wire.mutable_tensors());
}

// Row of each live vertex slot; -1 elsewhere.
std::vector<std::int32_t> RowsOfSlots(const std::vector<VertexId>& vertex_ids) {
  if (vertex_ids.empty()) return {};
  std::vector<std::int32_t> rows(vertex_ids.back().index() + 1, -1);
  for (std::size_t i = 0; i < vertex_ids.size(); ++i) {
    rows[vertex_ids[i].index()] = static_cast<std::int32_t>(i);
  }
  return rows;
}

// The same elements with rows instead of slots. Ascending slots make ascending rows, so that the
// smallest corner stays first.
template <std::size_t kCount>
std::vector<std::array<VertexId, kCount>> Renumbered(
    std::vector<std::array<VertexId, kCount>> elements, const std::vector<std::int32_t>& rows) {
  for (std::array<VertexId, kCount>& vertices : elements) {
    for (VertexId& vertex : vertices) vertex = VertexId(rows[vertex.index()]);
  }
  return elements;
}

void WriteLengths(const LengthStatistics& lengths, v1::LengthStatistics& wire) {
  wire.set_min(lengths.min);
  wire.set_mean(lengths.mean);
  wire.set_max(lengths.max);
  wire.set_share_sqrt2(lengths.share_sqrt2);
  wire.set_share_125(lengths.share_125);
}

template <std::size_t kBins>
void WriteHistogram(const Histogram<kBins>& histogram, v1::Histogram& wire) {
  wire.set_low(0);
  wire.set_high(histogram.upper);
  wire.mutable_counts()->Add(histogram.counts.begin(), histogram.counts.end());
}

void WriteTime(std::chrono::system_clock::time_point time, google::protobuf::Timestamp& wire) {
  const auto ns =
      std::chrono::duration_cast<std::chrono::nanoseconds>(time.time_since_epoch()).count();
  wire.set_seconds(ns / 1'000'000'000);
  wire.set_nanos(static_cast<std::int32_t>(ns % 1'000'000'000));
}

v1::TroubleKind ToTroubleKind(TroubleKind kind) {
  switch (kind) {
    case TroubleKind::kGeometry:
      return v1::TROUBLE_KIND_GEOMETRY;
    case TroubleKind::kVertexLimit:
      return v1::TROUBLE_KIND_VERTEX_LIMIT;
    case TroubleKind::kCrossed:
      return v1::TROUBLE_KIND_CROSSED;
    case TroubleKind::kCurvature:
      return v1::TROUBLE_KIND_CURVATURE;
    case TroubleKind::kSizeJump:
      return v1::TROUBLE_KIND_SIZE_JUMP;
    case TroubleKind::kFrozen:
      return v1::TROUBLE_KIND_FROZEN;
    case TroubleKind::kUnsettled:
      break;
  }
  return v1::TROUBLE_KIND_UNSETTLED;
}

void Write(const Trouble& trouble, v1::Trouble& wire) {
  wire.set_kind(ToTroubleKind(trouble.kind));
  wire.set_vertex_count(trouble.vertex_count);
  wire.mutable_box()->set_x_min(trouble.box.low.x);
  wire.mutable_box()->set_y_min(trouble.box.low.y);
  wire.mutable_box()->set_x_max(trouble.box.high.x);
  wire.mutable_box()->set_y_max(trouble.box.high.y);
  wire.set_center_x(trouble.center.x);
  wire.set_center_y(trouble.center.y);
  wire.set_place_count(trouble.place_count);
  wire.set_q_min(trouble.q_min);
  wire.set_length_min(trouble.length_min);
  wire.set_length_max(trouble.length_max);
}

v1::StopReason ToStopReason(const AdvancedEvent& advanced) {
  switch (advanced.end) {
    case AdvanceEnd::kTimeBudget:
      return v1::STOP_REASON_TIME_BUDGET;
    case AdvanceEnd::kServerClosing:
      return v1::STOP_REASON_SERVER_CLOSING;
    case AdvanceEnd::kStaging:
      return v1::STOP_REASON_STAGING;
    case AdvanceEnd::kEngine:
      break;
  }
  switch (advanced.progress.stop_reason) {
    case StopReason::kConverged:
      return v1::STOP_REASON_CONVERGED;
    case StopReason::kVisitBudget:
      return v1::STOP_REASON_VISIT_BUDGET;
    case StopReason::kCancelled:
      return v1::STOP_REASON_CANCELLED;
    case StopReason::kVertexLimit:
      return v1::STOP_REASON_VERTEX_LIMIT;
    case StopReason::kVisitLimit:
      return v1::STOP_REASON_VISIT_LIMIT;
  }
  PLIANT_CHECK(false, "stop reason", static_cast<int>(advanced.progress.stop_reason));
}

// One overload per kind of event.
void WriteBody(const OpenedEvent& opened, const SessionEvent&, const WantedParts&,
               v1::EditResponse& response) {
  response.mutable_opened()->set_last_update_id(opened.last_update_id);
  response.mutable_opened()->set_active_count(opened.active_count);
  response.mutable_opened()->set_staged_count(opened.staged_count);
}

void WriteBody(const AcceptedEvent& accepted, const SessionEvent&, const WantedParts&,
               v1::EditResponse& response) {
  response.mutable_accepted()->set_staged_count(accepted.staged_count);
}

void WriteBody(const RejectedEvent& rejected, const SessionEvent&, const WantedParts&,
               v1::EditResponse& response) {
  *response.mutable_rejected()->mutable_error() = ToErrorDetail(rejected.error);
}

void WriteBody(const ProgressEvent& progress, const SessionEvent&, const WantedParts&,
               v1::EditResponse& response) {
  v1::Progress& wire = *response.mutable_progress();
  wire.set_active_count(progress.progress.active_count);
  wire.set_visit_count(progress.progress.counts.visits);
  wire.set_vertex_count(progress.vertex_count);
  wire.set_elapsed_ms(progress.elapsed.count());
}

void WriteBody(const DiffEvent& diff, const SessionEvent&, const WantedParts& parts,
               v1::EditResponse& response) {
  *response.mutable_diff() =
      ToMeshDiff(*diff.diff, {.applied_update_id = diff.applied_update_id, .parts = parts});
}

void WriteBody(const SnapshotEvent& snapshot, const SessionEvent&, const WantedParts& parts,
               v1::EditResponse& response) {
  *response.mutable_snapshot() = ToMeshSnapshot(
      *snapshot.snapshot, {.applied_update_id = snapshot.applied_update_id, .parts = parts});
}

/// The stages of the metric pipeline that changed something.
void WriteLimits(const MetricReport& report, v1::AdvanceResult& result) {
  const auto write = [&](v1::LimitStage stage, std::int64_t vertex_count) {
    if (vertex_count == 0) return;
    v1::LimitReport& wire = *result.add_limits();
    wire.set_stage(stage);
    wire.set_vertex_count(vertex_count);
    wire.set_ratio_max(report.size_ratio_max);
    wire.set_worst_vertex_id(report.worst.value());
    wire.set_complexity_before(report.raw_complexity);
    wire.set_complexity_after(report.limited_complexity);
  };
  write(v1::LIMIT_STAGE_SMOOTHING, report.smoothing_count);
  write(v1::LIMIT_STAGE_GEOMETRY, report.geometry_count);
  write(v1::LIMIT_STAGE_ROTATION, report.rotation_count);
  write(v1::LIMIT_STAGE_GRADATION, report.gradation_count);
}

void WriteBody(const AdvancedEvent& advanced, const SessionEvent& event, const WantedParts&,
               v1::EditResponse& response) {
  v1::AdvanceResult& wire = *response.mutable_advanced();
  wire.set_base_revision(static_cast<std::int64_t>(advanced.base_revision));
  wire.set_revision(static_cast<std::int64_t>(event.revision));
  wire.set_stop_reason(ToStopReason(advanced));
  wire.set_active_count(advanced.progress.active_count);
  *wire.mutable_counts() = ToMeshCounts(advanced.summary);
  wire.set_state_hash(advanced.summary.state_hash);
  wire.set_visit_count(advanced.progress.counts.visits);
  wire.set_move_count(advanced.progress.counts.moves);
  wire.set_insertion_count(advanced.progress.counts.insertions);
  wire.set_deletion_count(advanced.progress.counts.deletions);
  wire.set_swap_count(advanced.progress.counts.swaps);
  wire.set_cooled_count(advanced.progress.counts.cooled);
  wire.set_compute_us(advanced.compute.count());
  wire.set_elapsed_us(advanced.elapsed.count());
  for (const Trouble& trouble : advanced.troubles) Write(trouble, *wire.add_troubles());
  if (advanced.motion_fraction) wire.set_motion_fraction(*advanced.motion_fraction);
  wire.set_softened_count(advanced.softened_count);
  WriteLimits(advanced.progress.metric, wire);
  if (advanced.durable_revision) {
    wire.set_durable_revision(static_cast<std::int64_t>(*advanced.durable_revision));
  }
}

void WriteBody(const ClosingEvent& closing, const SessionEvent&, const WantedParts&,
               v1::EditResponse& response) {
  *response.mutable_closing()->mutable_error() = ToErrorDetail(closing.error);
}

void WriteBody(const BookmarkEvent&, const SessionEvent&, const WantedParts&, v1::EditResponse&) {
  PLIANT_CHECK(false, "an editor gets no bookmarks");
}

}  // namespace

v1::MeshDiff ToMeshDiff(const MeshDiff& diff, const ReplyContext& context) {
  v1::MeshDiff wire;
  wire.set_base_revision(static_cast<std::int64_t>(diff.base_revision));
  wire.set_revision(static_cast<std::int64_t>(diff.revision));
  wire.set_applied_update_id(context.applied_update_id);
  Write(diff.removed_vertices, *wire.mutable_removed_vertices());
  Write(diff.removed_triangles, *wire.mutable_removed_triangles());
  Write(diff.removed_edges, *wire.mutable_removed_edges());
  Write(diff.vertex_ids, *wire.mutable_vertex_ids());
  Write(diff.vertex_positions, *wire.mutable_vertex_positions());
  Write(diff.triangle_ids, *wire.mutable_triangle_ids());
  Write(diff.triangle_vertices, *wire.mutable_triangle_vertices());
  Write(diff.triangle_regions, *wire.mutable_triangle_tags());
  Write(diff.edge_ids, *wire.mutable_edge_ids());
  Write(diff.edge_vertices, *wire.mutable_edge_vertices());
  Write(diff.edge_tags, *wire.mutable_edge_tags());
  *wire.mutable_counts() = ToMeshCounts(diff.summary);
  wire.set_state_hash(diff.summary.state_hash);
  if (context.parts.metric) WriteMetrics(diff, *wire.mutable_metric());
  if (context.parts.transfer && diff.transfer) {
    WriteTransferRows(*diff.transfer, *wire.mutable_transfer());
  }
  if (context.parts.fields) {
    WriteFields(diff.fields.changed, *wire.mutable_fields());
    for (const std::string& name : diff.fields.dropped_names) wire.add_fields()->set_name(name);
  }
  return wire;
}

v1::MeshSnapshot ToMeshSnapshot(const MeshDiff& snapshot, const ReplyContext& context) {
  v1::MeshSnapshot wire;
  wire.set_revision(static_cast<std::int64_t>(snapshot.revision));
  wire.set_applied_update_id(context.applied_update_id);
  wire.set_numbering(context.numbering);
  Write(snapshot.vertex_ids, *wire.mutable_vertex_ids());
  Write(snapshot.vertex_positions, *wire.mutable_vertex_positions());
  Write(snapshot.triangle_ids, *wire.mutable_triangle_ids());
  Write(snapshot.triangle_regions, *wire.mutable_triangle_tags());
  Write(snapshot.edge_ids, *wire.mutable_edge_ids());
  Write(snapshot.edge_tags, *wire.mutable_edge_tags());
  if (context.numbering == v1::NUMBERING_DENSE) {
    const std::vector<std::int32_t> rows = RowsOfSlots(snapshot.vertex_ids);
    Write(Renumbered(snapshot.triangle_vertices, rows), *wire.mutable_triangle_vertices());
    Write(Renumbered(snapshot.edge_vertices, rows), *wire.mutable_edge_vertices());
  } else {
    Write(snapshot.triangle_vertices, *wire.mutable_triangle_vertices());
    Write(snapshot.edge_vertices, *wire.mutable_edge_vertices());
  }
  *wire.mutable_counts() = ToMeshCounts(snapshot.summary);
  wire.set_state_hash(snapshot.summary.state_hash);
  if (context.parts.metric) WriteMetrics(snapshot, *wire.mutable_metric());
  if (context.parts.fields) WriteFields(snapshot.fields.changed, *wire.mutable_fields());
  return wire;
}

v1::MeshCounts ToMeshCounts(const MeshSummary& summary) {
  v1::MeshCounts counts;
  counts.set_vertex_count(summary.vertex_count);
  counts.set_triangle_count(summary.triangle_count);
  counts.set_edge_count(summary.edge_count);
  return counts;
}

v1::QualityReport ToQualityReport(const Quality& quality) {
  v1::QualityReport wire;
  wire.set_basis(v1::METRIC_BASIS_LIMITED);
  wire.set_edge_count(quality.edge_count);
  wire.set_q_min(quality.q_min);
  wire.set_q_mean(quality.q_mean);
  wire.set_q_percentile_1(quality.q_percentile_1);
  WriteLengths(quality.averaged, *wire.mutable_averaged());
  WriteLengths(quality.integrated, *wire.mutable_integrated());
  WriteHistogram(quality.lengths, *wire.mutable_averaged()->mutable_histogram());
  WriteHistogram(quality.angles, *wire.mutable_angle_deg());
  wire.set_complexity(quality.complexity);
  return wire;
}

v1::EditResponse ToEditResponse(const SessionEvent& event, const WantedParts& parts) {
  v1::EditResponse response;
  response.set_update_id(event.update_id);
  response.set_revision(static_cast<std::int64_t>(event.revision));
  std::visit([&](const auto& body) { WriteBody(body, event, parts, response); }, event.body);
  return response;
}

v1::SubscribeResponse ToSubscribeResponse(const SessionEvent& event, const WantedParts& parts,
                                          v1::Numbering numbering) {
  v1::SubscribeResponse response;
  response.set_revision(static_cast<std::int64_t>(event.revision));
  if (const auto* diff = std::get_if<DiffEvent>(&event.body)) {
    *response.mutable_diff() =
        ToMeshDiff(*diff->diff, {.applied_update_id = diff->applied_update_id, .parts = parts});
  } else if (const auto* snapshot = std::get_if<SnapshotEvent>(&event.body)) {
    *response.mutable_snapshot() = ToMeshSnapshot(
        *snapshot->snapshot,
        {.applied_update_id = snapshot->applied_update_id, .parts = parts, .numbering = numbering});
  } else if (const auto* closing = std::get_if<ClosingEvent>(&event.body)) {
    *response.mutable_closing()->mutable_error() = ToErrorDetail(closing->error);
  } else {
    PLIANT_CHECK(std::holds_alternative<BookmarkEvent>(event.body));
    response.mutable_bookmark();
  }
  return response;
}

v1::Session ToSession(const SessionInfo& info) {
  v1::Session wire;
  wire.set_session_id(info.session_id);
  wire.set_revision(static_cast<std::int64_t>(info.revision));
  wire.set_state(info.running  ? v1::SESSION_STATE_RUNNING
                 : info.asleep ? v1::SESSION_STATE_ASLEEP
                               : v1::SESSION_STATE_IDLE);
  if (info.summary) {
    *wire.mutable_counts() = ToMeshCounts(*info.summary);
    wire.set_state_hash(info.summary->state_hash);
  }
  wire.set_active_count(info.active_count);
  wire.set_last_update_id(info.last_update_id);
  WriteTime(info.create_time, *wire.mutable_create_time());
  if (info.commit_time) WriteTime(*info.commit_time, *wire.mutable_commit_time());
  wire.mutable_saved_revisions()->Add(info.saved_revisions.begin(), info.saved_revisions.end());
  wire.set_memory_bytes(info.memory_bytes);
  if (info.history_bytes_max) wire.set_history_bytes_max(*info.history_bytes_max);
  wire.mutable_labels()->insert(info.labels.begin(), info.labels.end());
  return wire;
}

}  // namespace pliant::server
