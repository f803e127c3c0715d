#include "client/cpp/convert.h"

#include <google/protobuf/util/time_util.h>

#include <bit>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "client/cpp/convert_updates.h"

namespace pliant::client {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using wire::ColumnReader;
using wire::ColumnWriter;

using Pair = std::array<std::int32_t, 2>;
using Triple = std::array<std::int32_t, 3>;

v1::Array Points(std::span<const Vec2> rows, ColumnWriter& columns) {
  return columns.Write<double, 2>(rows);
}
v1::Array Tensors(std::span<const Metric> rows, ColumnWriter& columns) {
  return columns.Write<double, 3>(rows);
}
template <class T>
std::span<const T> View(const std::vector<T>& rows) {
  return rows;
}

void SetSource(const ExpressionMetric& metric, v1::MetricSource& source,
               ColumnWriter& /*columns*/) {
  source.mutable_expression()->set_m11(metric.m11);
  source.mutable_expression()->set_m12(metric.m12);
  source.mutable_expression()->set_m22(metric.m22);
}

/// The counts are 64 bits wide on the wire for the sake of larger meshes to come.
std::int32_t Narrow(std::int64_t count) {
  constexpr std::int64_t kMax = std::numeric_limits<std::int32_t>::max();
  return static_cast<std::int32_t>(count < 0 ? -1 : count > kMax ? kMax : count);
}

MeshSummary SummaryFrom(const v1::MeshCounts& counts, std::uint64_t state_hash) {
  return {.vertex_count = Narrow(counts.vertex_count()),
          .triangle_count = Narrow(counts.triangle_count()),
          .edge_count = Narrow(counts.edge_count()),
          .state_hash = state_hash};
}

/// The columns that diffs and snapshots share, under the same names.
template <class Message>
Status ReadElements(const Message& message, ColumnReader& columns, MeshDiff& diff) {
  PLIANT_ASSIGN_OR_RETURN(diff.vertex_ids, (columns.Read<std::int32_t, 1, VertexId>(
                                               message.vertex_ids(), "vertex_ids")));
  PLIANT_ASSIGN_OR_RETURN(
      diff.vertex_positions,
      (columns.Read<double, 2, Vec2>(message.vertex_positions(), "vertex_positions")));
  PLIANT_ASSIGN_OR_RETURN(diff.triangle_ids, (columns.Read<std::int32_t, 1, TriangleId>(
                                                 message.triangle_ids(), "triangle_ids")));
  PLIANT_ASSIGN_OR_RETURN(diff.triangle_vertices,
                          (columns.Read<std::int32_t, 3, std::array<VertexId, 3>>(
                              message.triangle_vertices(), "triangle_vertices")));
  PLIANT_ASSIGN_OR_RETURN(diff.triangle_regions, (columns.Read<std::int32_t, 1, std::int32_t>(
                                                     message.triangle_tags(), "triangle_tags")));
  PLIANT_ASSIGN_OR_RETURN(diff.edge_ids,
                          (columns.Read<std::int32_t, 1, EdgeId>(message.edge_ids(), "edge_ids")));
  PLIANT_ASSIGN_OR_RETURN(diff.edge_vertices,
                          (columns.Read<std::int32_t, 2, std::array<VertexId, 2>>(
                              message.edge_vertices(), "edge_vertices")));
  PLIANT_ASSIGN_OR_RETURN(diff.edge_tags, (columns.Read<std::int32_t, 1, std::int32_t>(
                                              message.edge_tags(), "edge_tags")));
  PLIANT_ASSIGN_OR_RETURN(diff.metrics, (columns.Read<double, 3, Metric>(message.metric().tensors(),
                                                                         "metric.tensors")));
  if (message.metric().has_vertex_ids()) {
    PLIANT_ASSIGN_OR_RETURN(diff.metric_vertex_ids,
                            (columns.Read<std::int32_t, 1, VertexId>(message.metric().vertex_ids(),
                                                                     "metric.vertex_ids")));
  }
  diff.revision = Revision{message.revision()};
  diff.summary = SummaryFrom(message.counts(), message.state_hash());
  return {};
}

/// Without ids the tensors belong to all live vertices: in a diff from nothing, the listed ones.
void NameAllMetricVertices(const v1::VertexMetrics& metric, MeshDiff& diff) {
  if (!metric.has_vertex_ids() && metric.has_tensors()) diff.metric_vertex_ids = diff.vertex_ids;
}

template <std::size_t kBins>
Status ReadHistogram(const v1::Histogram& histogram, Histogram<kBins>& to) {
  if (histogram.counts_size() != static_cast<int>(kBins) || histogram.low() != 0) {
    return Error{.code = ErrorCode::kArrayLength,
                 .message = "a histogram has " + std::to_string(histogram.counts_size()) +
                            " bins from " + std::to_string(histogram.low()) + " on, expected " +
                            std::to_string(kBins) +
                            " from 0 on; the server is of another version than this client",
                 .field = "quality.histogram"};
  }
  to.upper = histogram.high();
  for (std::size_t i = 0; i < kBins; ++i) to.counts[i] = histogram.counts(static_cast<int>(i));
  return {};
}

LengthStatistics LengthsFrom(const v1::LengthStatistics& lengths) {
  return {.mean = lengths.mean(),
          .min = lengths.min(),
          .max = lengths.max(),
          .share_sqrt2 = lengths.share_sqrt2(),
          .share_125 = lengths.share_125()};
}

AdvanceStop StopFrom(v1::StopReason reason) {
  switch (reason) {
    case v1::STOP_REASON_VISIT_BUDGET:
      return AdvanceStop::kVisitBudget;
    case v1::STOP_REASON_TIME_BUDGET:
      return AdvanceStop::kTimeBudget;
    case v1::STOP_REASON_CANCELLED:
      return AdvanceStop::kCancelled;
    case v1::STOP_REASON_VERTEX_LIMIT:
      return AdvanceStop::kVertexLimit;
    case v1::STOP_REASON_VISIT_LIMIT:
      return AdvanceStop::kVisitLimit;
    case v1::STOP_REASON_SERVER_CLOSING:
      return AdvanceStop::kServerClosing;
    case v1::STOP_REASON_STAGING:
      return AdvanceStop::kStaging;
    default:
      return AdvanceStop::kConverged;
  }
}

TroubleKind TroubleKindFrom(v1::TroubleKind kind) {
  switch (kind) {
    case v1::TROUBLE_KIND_GEOMETRY:
      return TroubleKind::kGeometry;
    case v1::TROUBLE_KIND_VERTEX_LIMIT:
      return TroubleKind::kVertexLimit;
    case v1::TROUBLE_KIND_CROSSED:
      return TroubleKind::kCrossed;
    case v1::TROUBLE_KIND_CURVATURE:
      return TroubleKind::kCurvature;
    case v1::TROUBLE_KIND_SIZE_JUMP:
      return TroubleKind::kSizeJump;
    case v1::TROUBLE_KIND_FROZEN:
      return TroubleKind::kFrozen;
    default:  // Also kinds that a newer server knows.
      return TroubleKind::kUnsettled;
  }
}

/// The reports of the stages as one; a stage that changed nothing has none.
MetricReport MetricReportFrom(const v1::AdvanceResult& result) {
  MetricReport report;
  for (const v1::LimitReport& limit : result.limits()) {
    report.limits = true;
    report.size_ratio_max = limit.ratio_max();
    report.worst = VertexId(limit.worst_vertex_id());
    report.raw_complexity = limit.complexity_before();
    report.limited_complexity = limit.complexity_after();
    if (limit.stage() == v1::LIMIT_STAGE_SMOOTHING) report.smoothing_count = limit.vertex_count();
    if (limit.stage() == v1::LIMIT_STAGE_GEOMETRY) report.geometry_count = limit.vertex_count();
    if (limit.stage() == v1::LIMIT_STAGE_ROTATION) report.rotation_count = limit.vertex_count();
    if (limit.stage() == v1::LIMIT_STAGE_GRADATION) report.gradation_count = limit.vertex_count();
  }
  return report;
}

Trouble TroubleFrom(const v1::Trouble& trouble) {
  return {.kind = TroubleKindFrom(trouble.kind()),
          .vertex_count = trouble.vertex_count(),
          .place_count = trouble.place_count(),
          .center = {trouble.center_x(), trouble.center_y()},
          .box = {{trouble.box().x_min(), trouble.box().y_min()},
                  {trouble.box().x_max(), trouble.box().y_max()}},
          .q_min = trouble.q_min(),
          .length_min = trouble.length_min(),
          .length_max = trouble.length_max()};
}

}  // namespace

v1::Domain ToWire(const Domain& domain, ColumnWriter& columns) {
  std::vector<Pair> segments;
  std::vector<std::int32_t> segment_tags;
  segments.reserve(domain.segments.size());
  segment_tags.reserve(domain.segments.size());
  for (const Segment& segment : domain.segments) {
    segments.push_back({segment.a, segment.b});
    segment_tags.push_back(segment.tag);
  }
  std::vector<Vec2> region_points;
  std::vector<std::int32_t> region_tags;
  for (const RegionSeed& seed : domain.regions) {
    region_points.push_back(seed.point);
    region_tags.push_back(seed.tag);
  }
  v1::Domain message;
  *message.mutable_points() = Points(domain.points, columns);
  *message.mutable_segments() = columns.Write<std::int32_t, 2>(View(segments));
  *message.mutable_segment_tags() = Numbers(View(segment_tags), columns);
  if (!domain.holes.empty()) *message.mutable_holes() = Points(domain.holes, columns);
  if (!region_points.empty()) {
    *message.mutable_region_points() = Points(region_points, columns);
    *message.mutable_region_tags() = Numbers(View(region_tags), columns);
  }
  return message;
}

v1::MeshInput ToWire(const MeshData& mesh, ColumnWriter& columns) {
  v1::MeshInput message;
  *message.mutable_points() = Points(mesh.points, columns);
  *message.mutable_triangles() = columns.Write<std::int32_t, 3>(View(mesh.triangles));
  if (!mesh.triangle_tags.empty()) {
    *message.mutable_triangle_tags() = Numbers(View(mesh.triangle_tags), columns);
  }
  if (!mesh.edges.empty()) {
    *message.mutable_edges() = columns.Write<std::int32_t, 2>(View(mesh.edges));
  }
  if (!mesh.edge_tags.empty()) {
    *message.mutable_edge_tags() = Numbers(View(mesh.edge_tags), columns);
  }
  return message;
}

v1::MetricLimits ToWire(const MetricLimits& limits) {
  v1::MetricLimits message;
  message.set_size_min(limits.bounds.size_min);
  message.set_size_max(limits.bounds.size_max);
  message.set_anisotropy_max(limits.bounds.anisotropy_max);
  message.set_gradation(limits.gradation.gradation);
  message.set_rotation(limits.gradation.rotation);
  message.set_geometry(limits.gradation.geometry);
  message.set_gap_element_count(limits.gradation.gap_element_count);
  message.set_smoothing_count(limits.gradation.smoothing_count);
  message.set_automatic(limits.gradation.automatic);
  return message;
}

namespace {

void SetSource(const SizeMetric& size, v1::MetricSource& source, ColumnWriter& /*columns*/) {
  source.mutable_size()->set_size(size.size);
}

void SetSource(const BackgroundMetric& background, v1::MetricSource& source,
               ColumnWriter& columns) {
  v1::BackgroundMetric& to = *source.mutable_background();
  *to.mutable_mesh() = ToWire(background.mesh, columns);
  *to.mutable_tensors() = Tensors(background.tensors, columns);
}

void SetSource(const VertexTensors& update, v1::MetricSource& source, ColumnWriter& columns) {
  v1::VertexMetric& vertices = *source.mutable_vertices();
  vertices.set_revision(static_cast<std::int64_t>(update.revision));
  if (!update.vertices.empty() || update.none) {
    *vertices.mutable_vertex_ids() = Numbers(update.vertices, columns);
  }
  *vertices.mutable_tensors() = Tensors(update.tensors, columns);
}

}  // namespace

v1::MetricUpdate ToWire(const MetricSpec& metric, ColumnWriter& columns) {
  v1::MetricUpdate message;
  const auto add = [&](const auto& source) { SetSource(source, *message.add_sources(), columns); };
  std::visit(
      Overloaded{
          [&](const IntersectedMetric& intersected) {
            for (const PlainMetric& part : intersected.parts) std::visit(add, part);
          },
          add,
      },
      metric.source);
  message.set_time(metric.time);
  *message.mutable_limits() = ToWire(MetricLimits{metric.bounds, metric.gradation});
  return message;
}

v1::MetricUpdate ToWire(const VertexTensors& update, ColumnWriter& columns) {
  v1::MetricUpdate message;
  const FunctionsSpec* const functions = update.functions;
  const std::size_t count = functions == nullptr ? 0 : functions->parts.size();
  for (std::size_t i = 0; i <= count; ++i) {
    if (functions == nullptr || i == functions->before_count) {
      SetSource(update, *message.add_sources(), columns);
    }
    if (i == count) break;
    std::visit([&](const auto& part) { SetSource(part, *message.add_sources(), columns); },
               functions->parts[i]);
  }
  if (functions != nullptr) message.set_time(functions->time);
  return message;
}

v1::Smoothing ToWire(Smoothing smoothing) {
  switch (smoothing) {
    case Smoothing::kPliant:
      break;
    case Smoothing::kLaplacian:
      return v1::SMOOTHING_LAPLACIAN;
    case Smoothing::kLennardJones:
      return v1::SMOOTHING_LENNARD_JONES;
    case Smoothing::kBubble:
      return v1::SMOOTHING_BUBBLE;
  }
  return v1::SMOOTHING_PLIANT;
}

v1::SessionOptions ToWire(const Options& options) {
  const Options defaults;
  v1::SessionOptions message;
  if (options.seed != defaults.seed) message.set_seed(std::bit_cast<std::int64_t>(options.seed));
  switch (options.variant) {
    case Variant::kNested:
      break;
    case Variant::kCooled:
      message.set_variant(v1::VARIANT_COOLED);
      break;
    case Variant::kPaper:
      message.set_variant(v1::VARIANT_PAPER);
      break;
  }
  if (options.smoothing != defaults.smoothing) message.set_smoothing(ToWire(options.smoothing));
  const auto set = [&](auto member, auto setter) {
    if (options.*member != defaults.*member) (message.*setter)(options.*member);
  };
  set(&Options::step, &v1::SessionOptions::set_step);
  set(&Options::speed_threshold, &v1::SessionOptions::set_speed_threshold);
  set(&Options::age_cooling, &v1::SessionOptions::set_age_cooling);
  set(&Options::age_max, &v1::SessionOptions::set_age_max);
  set(&Options::hops_max, &v1::SessionOptions::set_hops_max);
  set(&Options::metric_tolerance, &v1::SessionOptions::set_metric_tolerance);
  set(&Options::boundary_tolerance, &v1::SessionOptions::set_boundary_tolerance);
  set(&Options::vertices_max, &v1::SessionOptions::set_vertices_max);
  set(&Options::visits_per_vertex_max, &v1::SessionOptions::set_visits_per_vertex_max);
  AddRestrictions(options.permissions, message);
  return message;
}

v1::Advance ToWire(const AdvanceOptions& options) {
  v1::Advance message;
  if (options.visits_max) message.set_budget_visits(*options.visits_max);
  if (options.time_max) message.set_budget_ms(options.time_max->count());
  if (options.commit_interval) message.set_commit_interval_ms(options.commit_interval->count());
  return message;
}

Result<MeshDiff> FromWire(const v1::MeshDiff& message, ColumnReader& columns) {
  MeshDiff diff;
  PLIANT_RETURN_IF_ERROR(ReadElements(message, columns, diff));
  diff.base_revision = Revision{message.base_revision()};
  PLIANT_ASSIGN_OR_RETURN(
      diff.removed_vertices,
      (columns.Read<std::int32_t, 1, VertexId>(message.removed_vertices(), "removed_vertices")));
  PLIANT_ASSIGN_OR_RETURN(diff.removed_triangles,
                          (columns.Read<std::int32_t, 1, TriangleId>(message.removed_triangles(),
                                                                     "removed_triangles")));
  PLIANT_ASSIGN_OR_RETURN(diff.removed_edges, (columns.Read<std::int32_t, 1, EdgeId>(
                                                  message.removed_edges(), "removed_edges")));
  if (message.has_transfer()) {
    PLIANT_ASSIGN_OR_RETURN(diff.transfer, FromWire(message.transfer(), columns));
  }
  PLIANT_ASSIGN_OR_RETURN(diff.fields, FieldsFromWire(message.fields(), columns));
  if (diff.base_revision == Revision::kNone) NameAllMetricVertices(message.metric(), diff);
  return diff;
}

Result<MeshDiff> FromWire(const v1::MeshSnapshot& message, ColumnReader& columns) {
  if (message.numbering() == v1::NUMBERING_DENSE) {
    return Error{.code = ErrorCode::kInternal,
                 .message = "the server sent dense numbers where slots were asked for",
                 .field = "snapshot.numbering"};
  }
  MeshDiff diff;
  PLIANT_RETURN_IF_ERROR(ReadElements(message, columns, diff));
  PLIANT_ASSIGN_OR_RETURN(diff.fields, FieldsFromWire(message.fields(), columns));
  NameAllMetricVertices(message.metric(), diff);
  return diff;
}

Result<Quality> FromWire(const v1::QualityReport& report) {
  Quality quality;
  quality.vertex_count = report.counts().vertex_count();
  quality.triangle_count = report.counts().triangle_count();
  quality.edge_count = report.edge_count();
  quality.q_mean = report.q_mean();
  quality.q_min = report.q_min();
  quality.q_percentile_1 = report.q_percentile_1();
  quality.integrated = LengthsFrom(report.integrated());
  quality.averaged = LengthsFrom(report.averaged());
  quality.complexity = report.complexity();
  PLIANT_RETURN_IF_ERROR(ReadHistogram(report.angle_deg(), quality.angles));
  PLIANT_RETURN_IF_ERROR(ReadHistogram(report.averaged().histogram(), quality.lengths));
  return quality;
}

AdvanceReport FromWire(const v1::AdvanceResult& result) {
  std::optional<double> motion_fraction;
  if (result.has_motion_fraction()) motion_fraction = result.motion_fraction();
  std::optional<Revision> durable_revision;
  if (result.has_durable_revision()) durable_revision = Revision{result.durable_revision()};
  std::vector<Trouble> troubles;
  for (const v1::Trouble& trouble : result.troubles()) troubles.push_back(TroubleFrom(trouble));
  return {.base_revision = Revision{result.base_revision()},
          .revision = Revision{result.revision()},
          .stop = StopFrom(result.stop_reason()),
          .active_count = result.active_count(),
          .summary = SummaryFrom(result.counts(), result.state_hash()),
          .visits = result.visit_count(),
          .moves = result.move_count(),
          .insertions = result.insertion_count(),
          .deletions = result.deletion_count(),
          .swaps = result.swap_count(),
          .cooled_count = result.cooled_count(),
          .softened_count = result.softened_count(),
          .motion_fraction = motion_fraction,
          .durable_revision = durable_revision,
          .troubles = std::move(troubles),
          .metric = MetricReportFrom(result),
          .compute_time = microseconds(result.compute_us()),
          .elapsed_time = microseconds(result.elapsed_us())};
}

AdvanceProgress FromWire(const v1::Progress& progress) {
  return {.active_count = progress.active_count(),
          .visits = progress.visit_count(),
          .vertex_count = progress.vertex_count(),
          .elapsed = milliseconds(progress.elapsed_ms())};
}

std::chrono::system_clock::time_point FromWire(const google::protobuf::Timestamp& time) {
  using google::protobuf::util::TimeUtil;
  return std::chrono::system_clock::time_point(
      std::chrono::duration_cast<std::chrono::system_clock::duration>(
          std::chrono::nanoseconds(TimeUtil::TimestampToNanoseconds(time))));
}

SessionInfo FromWire(const v1::Session& session) {
  SessionInfo info;
  info.session_id = session.session_id();
  info.revision = Revision{session.revision()};
  info.state = session.state() == v1::SESSION_STATE_RUNNING  ? SessionState::kRunning
               : session.state() == v1::SESSION_STATE_ASLEEP ? SessionState::kAsleep
                                                             : SessionState::kIdle;
  info.summary = SummaryFrom(session.counts(), session.state_hash());
  info.active_count = session.active_count();
  info.last_update_id = session.last_update_id();
  info.create_time = FromWire(session.create_time());
  info.commit_time = FromWire(session.commit_time());
  for (const auto& [key, value] : session.labels()) info.labels.emplace(key, value);
  info.memory_bytes = session.memory_bytes();
  if (session.has_history_bytes_max()) info.history_bytes_max = session.history_bytes_max();
  return info;
}

}  // namespace pliant::client
