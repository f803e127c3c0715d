#include "core/pliant/mesh_limits.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/sort_unique.h"
#include "core/mesh/mesh_rings.h"

namespace pliant {
namespace {

/// The raw tensors of a limiter's vertices, log-Euclidean in between.
class RawNodalField final : public MetricField {
 public:
  /// @param kept  null: the limiter has them
  RawNodalField(std::shared_ptr<FrozenMesh> base, std::shared_ptr<const MetricLimiter> limiter,
                std::shared_ptr<const KeptTensors> kept)
      : base_(std::move(base)), limiter_(std::move(limiter)), kept_(std::move(kept)) {}

  [[nodiscard]] Metric At(Vec2 p, std::int32_t& hint) const override {
    const Location location = base_->Locate(p, hint);
    hint = location.triangle;
    const std::array<VertexId, 3> corners = base_->triangle(TriangleId(hint)).vertices;
    LogMetric mean = location.weights[0] * LogAt(corners[0]);
    for (std::size_t k = 1; k < 3; ++k) mean = mean + location.weights[k] * LogAt(corners[k]);
    return Exp(mean);
  }

 private:
  [[nodiscard]] LogMetric LogAt(VertexId vertex) const {
    return kept_ != nullptr ? kept_->LogAt(vertex) : Log(limiter_->Raw(vertex.value()));
  }

  std::shared_ptr<FrozenMesh> base_;
  std::shared_ptr<const MetricLimiter> limiter_;
  std::shared_ptr<const KeptTensors> kept_;
};

/// Totals are whole numbers of this unit.
double Complexity(std::int64_t total) { return static_cast<double>(total) * 0x1p-20; }

MetricReport ReportOf(const LimitTotals& totals, const LimitChanges& changes) {
  return {.limits = true,
          .smoothing_count = totals.smoothing_count,
          .geometry_count = totals.geometry_count,
          .rotation_count = totals.rotation_count,
          .gradation_count = totals.gradation_count,
          .changed_count = std::ssize(changes.vertices),
          .size_ratio_max = changes.size_ratio_max,
          .worst = VertexId(changes.worst),
          .raw_complexity = Complexity(totals.raw_complexity),
          .limited_complexity = Complexity(totals.limited_complexity)};
}

}  // namespace

RawTensors Merge(const RawTensors& first, const RawTensors& second) {
  if (second.all) return second;
  RawTensors merged{.all = first.all, .vertices = {}, .tensors = {}};
  const auto take = [&](const RawTensors& from, std::size_t& i) {
    merged.vertices.push_back(from.vertices[i]);
    merged.tensors.push_back(from.tensors[i]);
    ++i;
  };
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < first.vertices.size() || j < second.vertices.size()) {
    const bool ends = j == second.vertices.size();
    if (!ends && i < first.vertices.size() && first.vertices[i] == second.vertices[j]) ++i;
    if (ends || (i < first.vertices.size() && first.vertices[i] < second.vertices[j])) {
      take(first, i);
    } else {
      take(second, j);
    }
  }
  return merged;
}

Status MeshLimits::Load(const GradationOptions& options, std::span<const VertexId> vertices,
                        std::span<const Metric> tensors, const StopSignal* stop) {
  return Load({options, nullptr}, vertices, tensors, stop);
}

Status MeshLimits::Load(const Rules& rules, std::span<const VertexId> vertices,
                        std::span<const Metric> tensors, const StopSignal* stop) {
  const GradationOptions& options = rules.options;
  options_ = options;
  functions_ = rules.functions;
  kept_ = functions_ == nullptr ? nullptr : std::make_shared<KeptTensors>();
  if (kept_ != nullptr) kept_->Reserve(mesh_.vertex_slots());
  segments_ = options.geometry == 0 && options.gap_element_count == 0
                  ? nullptr
                  : std::make_shared<BoundaryGaps>(mesh_);
  limiter_ = std::make_shared<MetricLimiter>(options);
  limiter_->Reserve(mesh_.vertex_slots());
  StopPoll stopped(stop);
  WantedTensors live;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (stopped()) return Stopped();
    if (!mesh_.IsLive(vertices[i])) continue;
    live.vertices.push_back(vertices[i]);
    live.tensors.push_back(tensors[i]);
  }
  PLIANT_RETURN_IF_ERROR(SetRawOf(live, stop));
  // Only damaged data that a checksum vouches for leaves a vertex out.
  for (std::int32_t v = 0; v < mesh_.vertex_slots(); ++v) {
    if (stopped()) return Stopped();
    GiveRaw(VertexId(v));
  }
  return {};
}

/// A live vertex that nobody gave a raw tensor wants what it has.
void MeshLimits::GiveRaw(VertexId vertex) {
  if (mesh_.IsLive(vertex) && !Has(vertex)) SetRaw(vertex, mesh_.metric(vertex));
}

Status MeshLimits::SetRawOf(const WantedTensors& raw, const StopSignal* stop) {
  for (std::size_t begin = 0; begin < raw.vertices.size(); begin += StopPoll::kPeriod) {
    if (stop != nullptr && stop->asked()) return Stopped();
    const std::size_t count = std::min<std::size_t>(StopPoll::kPeriod, raw.vertices.size() - begin);
    SetRawEach(std::span(raw.vertices).subspan(begin, count),
               std::span(raw.tensors).subspan(begin, count));
  }
  return {};
}

/// The same for so many that nobody minds if they are not interrupted.
void MeshLimits::SetRawEach(std::span<const VertexId> vertices, std::span<const Metric> raw) {
  std::vector<Metric> met;
  if (functions_ != nullptr) {
    std::vector<Vec2> points;
    points.reserve(vertices.size());
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      kept_->Set(vertices[i], raw[i]);
      points.push_back(mesh_.position(vertices[i]));
    }
    met.assign(raw.begin(), raw.end());
    functions_->MeetEach(points, met);
    raw = met;
  }
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    limiter_->SetRaw(vertices[i].value(), raw[i], SizeCap(vertices[i], raw[i]));
  }
}

void MeshLimits::Remove(VertexId vertex) {
  limiter_->Remove(vertex.value());
  if (kept_ != nullptr) kept_->Remove(vertex);
}

/// How far the size at a vertex depends on segments that it does not stand on.
double MeshLimits::ReachOf(const Metric& raw) const {
  if (options_.gap_element_count == 0) return 0;
  return options_.gap_element_count * SizesFromMetric(raw).wide;
}

/// The size that the geometry allows at a vertex; gaps that `raw` fills with enough elements do not
/// count.
double MeshLimits::SizeCap(VertexId vertex, const Metric& raw) const {
  const double cap = SegmentCap(vertex);
  if (options_.gap_element_count == 0 || !mesh_.vertex(vertex).edge.valid()) return cap;
  const double width = segments_->WidthAt(mesh_, vertex, ReachOf(raw));
  return std::min(cap, width / options_.gap_element_count);
}

/// The size that the input segments at a given vertex allow.
double MeshLimits::SegmentCap(VertexId vertex) const {
  double least = MetricLimiter::kNoCap;
  if (options_.geometry == 0 || !mesh_.vertex(vertex).fixed) return least;
  for (EdgeId id = mesh_.vertex(vertex).edge; id.valid();) {
    const EdgeRecord& edge = mesh_.edge(id);
    const SegmentRecord& line = mesh_.segments()[static_cast<std::size_t>(edge.segment)];
    least = std::min(least, Length(mesh_.position(line.b) - mesh_.position(line.a)));
    id = edge.next[edge.vertices[0] == vertex ? 0 : 1];
  }
  return options_.geometry * least;
}

void MeshLimits::RenewCap(VertexId vertex) {
  const double cap = SizeCap(vertex, Met(vertex));
  if (cap != limiter_->SizeCap(vertex.value())) limiter_->SetRaw(vertex.value(), Met(vertex), cap);
}

/// Where segments are others than before, whoever stands on them or sees them may have another cap.
void MeshLimits::RenewSegments() {
  if (segments_ == nullptr) return;
  const std::optional<BoundingBox> place = segments_->DifferenceTo(mesh_);
  if (!place) return;
  const auto before = std::exchange(segments_, std::make_shared<BoundaryGaps>(mesh_));
  for (std::int32_t e = 0; e < mesh_.edge_slots(); ++e) {
    const EdgeRecord& edge = mesh_.edge(EdgeId(e));
    if (!edge.live) continue;
    const bool is_other = before->Differs(mesh_, edge.segment);
    for (const VertexId end : edge.vertices) {
      if (!Has(end)) continue;
      const double reach = ReachOf(Met(end));
      if (is_other || SquaredDistance(*place, mesh_.position(end)) <= reach * reach) {
        RenewCap(end);
      }
    }
  }
}

/// These may stand on other segments than before, or be given ones no more, or see another side.
void MeshLimits::RenewCaps(std::vector<VertexId> vertices) {
  SortUnique(vertices);
  for (const VertexId vertex : vertices) RenewCap(vertex);
}

std::shared_ptr<MetricField> MeshLimits::RawField(std::shared_ptr<FrozenMesh> base) const {
  return std::make_shared<RawNodalField>(std::move(base), limiter_, kept_);
}

Status MeshLimits::Follow(FrozenMesh& base, const MetricField& raw, const StopSignal* stop) {
  base.CatchUp();
  StopPoll stopped(stop);
  // Raw tensors are read before any is written.
  WantedTensors moved;
  std::vector<VertexId> capped;
  std::vector<VertexId> gone;
  for (const auto& [slot, old] : base.vertices()) {
    if (stopped()) return Stopped();
    const VertexId vertex(slot);
    if (!mesh_.IsLive(vertex)) {
      if (old.live) gone.push_back(vertex);
      continue;
    }
    // Also one that is given no more, or has left the boundary.
    if (segments_ != nullptr && old.live) capped.push_back(vertex);
    if (old.live && old.position == mesh_.position(vertex)) continue;
    // The loop has asked for the vertex there, most often of the same triangles.
    std::int32_t hint = mesh_.hint(vertex);
    moved.vertices.push_back(vertex);
    moved.tensors.push_back(raw.At(mesh_.position(vertex), hint));
  }
  for (const VertexId vertex : gone) Remove(vertex);
  RenewSegments();
  PLIANT_RETURN_IF_ERROR(SetRawOf(moved, stop));
  for (const auto& [slot, old] : base.triangles()) {
    if (stopped()) return Stopped();
    const TriangleId id(slot);
    const bool is_live = slot < mesh_.triangle_slots() && mesh_.triangle(id).live;
    if (is_live && old.live && old.vertices == mesh_.triangle(id).vertices) continue;
    const auto touch = [&](const std::array<VertexId, 3>& corners) {
      for (const VertexId v : corners) {
        if (!mesh_.IsLive(v)) continue;
        limiter_->Touch(v.value());
        if (segments_ != nullptr && mesh_.vertex(v).edge.valid()) capped.push_back(v);
      }
    };
    if (old.live) touch(old.vertices);
    if (is_live) touch(mesh_.triangle(id).vertices);
  }
  RenewCaps(std::move(capped));
  return {};
}

Result<WantedTensors> MeshLimits::Update(const StopSignal* stop) {
  MeshRings rings(mesh_);
  const LimitChanges changes = limiter_->Update(rings, stop);
  if (changes.stopped) return Stopped();
  report_ = options_.any() ? ReportOf(limiter_->totals(), changes) : MetricReport();
  WantedTensors wanted;
  wanted.vertices.reserve(changes.vertices.size());
  wanted.tensors.reserve(changes.vertices.size());
  StopPoll stopped(stop);
  for (const std::int32_t v : changes.vertices) {
    if (stopped()) return Stopped();
    wanted.vertices.emplace_back(v);
    wanted.tensors.push_back(limiter_->Limited(v));
  }
  return wanted;
}

RawTensors MeshLimits::Commit() {
  RawTensors undo = RawOfCommit();
  if (on()) limiter_->Commit();
  if (kept_ != nullptr) kept_->Commit();
  committed_ = limiter_;
  committed_kept_ = kept_;
  committed_functions_ = functions_;
  committed_report_ = report_;
  committed_options_ = options_;
  committed_segments_ = segments_;
  return undo;
}

/// Raw tensors of the last commit where they are others now, or all if limits began anew.
RawTensors MeshLimits::RawOfCommit() {
  RawTensors undo;
  if (limiter_ != committed_) {
    undo.all = true;
    if (committed_ == nullptr) return undo;
    committed_->Rollback();
    if (committed_kept_ != nullptr) committed_kept_->Rollback();
    limiter_.swap(committed_);
    kept_.swap(committed_kept_);
    undo = All();
    kept_.swap(committed_kept_);
    limiter_.swap(committed_);
  } else if (kept_ != nullptr) {
    for (const auto& [vertex, raw] : kept_->Changed()) {
      undo.vertices.push_back(vertex);
      undo.tensors.push_back(raw);
    }
  } else if (on()) {
    for (const auto& [v, raw] : limiter_->ChangedRaw()) {
      undo.vertices.emplace_back(v);
      undo.tensors.push_back(raw);
    }
  }
  return undo;
}

void MeshLimits::Rollback() {
  limiter_ = committed_;
  if (on()) limiter_->Rollback();
  kept_ = committed_kept_;
  if (kept_ != nullptr) kept_->Rollback();
  functions_ = committed_functions_;
  report_ = committed_report_;
  options_ = committed_options_;
  segments_ = committed_segments_;
}

RawTensors MeshLimits::All() const {
  RawTensors raw{.all = true, .vertices = {}, .tensors = {}};
  if (!on()) return raw;
  for (std::int32_t v = 0; v < limiter_->slot_count(); ++v) {
    if (!limiter_->Has(v)) continue;
    raw.vertices.emplace_back(v);
    raw.tensors.push_back(Raw(VertexId(v)));
  }
  return raw;
}

RawTensors MeshLimits::At(std::span<const VertexId> vertices) const {
  RawTensors raw;
  if (!on()) return raw;
  for (const VertexId vertex : vertices) {
    if (!Has(vertex)) continue;
    raw.vertices.push_back(vertex);
    raw.tensors.push_back(Raw(vertex));
  }
  return raw;
}

void MeshLimits::Apply(const RawTensors& raw, std::span<const VertexId> touched) {
  for (const VertexId vertex : touched) {
    if (!mesh_.IsLive(vertex) && Has(vertex)) Remove(vertex);
  }
  RenewSegments();
  if (functions_ != nullptr) {
    // Functions are others where a vertex has moved, though it may want the same.
    WantedTensors moved;
    for (const VertexId vertex : touched) {
      if (!mesh_.IsLive(vertex) || !Has(vertex)) continue;
      moved.vertices.push_back(vertex);
      moved.tensors.push_back(Raw(vertex));
    }
    PLIANT_CHECK(SetRawOf(moved).ok());
  }
  for (std::size_t i = 0; i < raw.vertices.size(); ++i) {
    if (mesh_.IsLive(raw.vertices[i])) SetRaw(raw.vertices[i], raw.tensors[i]);
  }
  for (const VertexId vertex : touched) GiveRaw(vertex);
  std::vector<VertexId> live;
  for (const VertexId vertex : touched) {
    if (!mesh_.IsLive(vertex)) continue;
    live.push_back(vertex);
    limiter_->Touch(vertex.value());
  }
  if (segments_ != nullptr) RenewCaps(std::move(live));
}

}  // namespace pliant
