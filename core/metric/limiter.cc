#include "core/metric/limiter.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/as_index.h"
#include "core/base/check.h"
#include "core/base/math.h"

namespace pliant {
namespace {

/// Puts different vertices in order: a good part of all of them by marks, which for a million takes
/// a third of the time.
void Sort(std::vector<std::int32_t>& vertices, std::size_t slot_count) {
  constexpr std::size_t kMarksShare = 32;
  if (kMarksShare * vertices.size() < slot_count) {
    std::sort(vertices.begin(), vertices.end());
    return;
  }
  std::vector<bool> marks(slot_count);
  for (const std::int32_t v : vertices) marks[AsIndex(v)] = true;
  vertices.clear();
  for (std::size_t v = 0; v < slot_count; ++v) {
    if (marks[v]) vertices.push_back(static_cast<std::int32_t>(v));
  }
}

}  // namespace

MetricLimiter::MetricLimiter(const GradationOptions& options)
    : rates_{.growth = options.gradation == 0 ? 0 : Log(options.gradation),
             .rotation = options.rotation},
      grows_(options.gradation != 0),
      smoothing_(options.smoothing_count) {
  PLIANT_CHECK(options.gradation == 0 || options.gradation >= 1, "gradation", options.gradation);
  PLIANT_CHECK(options.rotation >= 0, "rotation", options.rotation);
}

void MetricLimiter::Reserve(std::int32_t slot_count) {
  rows_.reserve(AsIndex(slot_count));
  smoothing_.Reserve(slot_count);
  touched_.reserve(AsIndex(slot_count));
  changed_.reserve(AsIndex(slot_count));
  near_.reserve(AsIndex(slot_count));
}

void MetricLimiter::SetRaw(std::int32_t vertex, const Metric& raw, double size_cap) {
  if (AsIndex(vertex) >= rows_.size()) rows_.resize(AsIndex(vertex) + 1);
  Row& row = Mutable(vertex);
  row.is_new = row.is_new || !row.live;
  row.live = true;
  row.raw = raw;
  row.size_cap = size_cap;
  if (smoothing_.on()) {
    smoothing_.Set(vertex, raw);
  } else {
    SetOwn(row, raw);
  }
  Touch(vertex);
}

void MetricLimiter::SetOwn(Row& row, const Metric& wanted) {
  row.own = SizesFromMetric(wanted);
  row.capped = row.own.wide > row.size_cap;
  row.own.thin = std::min(row.own.thin, row.size_cap);
  row.own.wide = std::min(row.own.wide, row.size_cap);
}

void MetricLimiter::Remove(std::int32_t vertex) {
  Row& row = Mutable(vertex);
  row.live = false;
  row.is_new = false;
}

LimitChanges MetricLimiter::Update(VertexRings& rings, const StopSignal* stop) {
  const auto asked = [&] { return stop != nullptr && stop->asked(); };
  std::erase_if(touched_, [&](std::int32_t v) { return !row(v).live; });
  if (smoothing_.on()) Smooth(rings, stop);
  if (asked()) return {.vertices = {}, .stopped = true};
  LookAtTouched(rings, stop);
  const std::int64_t settled_before = thin_.settled_count() + wide_.settled_count();
  if (asked()) return {.vertices = {}, .stopped = true};
  if (grows_) Grow(rings, stop);
  if (asked()) return {.vertices = {}, .stopped = true};
  LimitChanges changes = Finish(rings, stop);
  if (changes.stopped) return changes;
  changes.looked_count =
      std::ssize(near_) + thin_.settled_count() + wide_.settled_count() - settled_before;
  for (const std::int32_t v : near_) rows_[AsIndex(v)].near = false;
  near_.clear();
  return changes;
}

/// Before the first pass: averages become what their vertices want.
void MetricLimiter::Smooth(VertexRings& rings, const StopSignal* stop) {
  touched_ = smoothing_.Update(rings, touched_, stop);
  StopPoll stopped(stop);
  for (const std::int32_t v : touched_) {
    if (stopped()) return;
    Row& row = Mutable(v);
    row.smoothed = smoothing_.Differs(v);
    SetOwn(row, row.smoothed ? smoothing_.At(v) : row.raw);
  }
}

void MetricLimiter::LookAtTouched(VertexRings& rings, const StopSignal* stop) {
  StopPoll stopped(stop);
  for (const std::int32_t v : touched_) {
    if (stopped()) return;
    AddNear(v);
    AddNearRing(rings, v);
  }
  touched_.clear();
  for (const std::int32_t v : near_) {
    if (stopped()) return;
    LimitOwn(rings, v);
  }
}

/// The first pass: the rotation limit between the raw tensors.
void MetricLimiter::LimitOwn(VertexRings& rings, std::int32_t v) {
  const double base_wide = Rotated(rings, v, RotationOf::kOwn);
  if (!row(v).is_new && row(v).base_wide == base_wide && grows_) return;
  Row& row = Mutable(v);
  row.base_wide = base_wide;
  // A new vertex begins with what it wants itself; and without growth that is all.
  if (!row.is_new && grows_) return;
  row.label = row.base();
  row.cap = row.wide = base_wide;
  row.is_new = false;
}

/// The second and third pass: two shortest-path problems, and the rotation limit between them.
void MetricLimiter::Grow(VertexRings& rings, const StopSignal* stop) {
  StopPoll stopped(stop);
  ThinProblem thin{*this, rings};
  for (const std::int32_t v : near_) {
    if (stopped()) return;
    thin_.Recheck(thin, v);
  }
  std::vector<std::int32_t> relabeled;
  const auto relabel = [&](std::int32_t v) {
    Mutable(v);
    relabeled.push_back(v);
  };
  thin_.Settle(thin, relabel, stop);
  for (const std::int32_t v : relabeled) {
    if (stopped()) return;
    AddNear(v);
    AddNearRing(rings, v);
  }
  for (const std::int32_t v : near_) {
    if (stopped()) return;
    const double cap = Rotated(rings, v, RotationOf::kLabel);
    if (row(v).cap != cap) Mutable(v).cap = cap;
  }
  WideProblem wide{*this, rings};
  for (const std::int32_t v : near_) {
    if (stopped()) return;
    wide_.Recheck(wide, v);
  }
  const auto widen = [&](std::int32_t v) { Mutable(v); };
  wide_.Settle(wide, widen, stop);
}

LimitChanges MetricLimiter::Finish(VertexRings& rings, const StopSignal* stop) {
  LimitChanges changes;
  StopPoll stopped(stop);
  for (const std::int32_t v : near_) {
    if (stopped()) return {.vertices = {}, .stopped = true};
    Measure(rings, v);
  }
  for (const std::int32_t v : changed_) {
    if (stopped()) return {.vertices = {}, .stopped = true};
    if (row(v).live && !row(v).near) Measure(rings, v);
  }
  Sort(changed_, rows_.size());
  for (const std::int32_t v : changed_) {
    if (stopped()) return {.vertices = {}, .stopped = true};
    Row& row = rows_[AsIndex(v)];
    row.changed = false;
    if (!row.live) continue;
    Count(row, 1);
    changes.vertices.push_back(v);
    const AxisSizes limited = row.limited();
    if (row.is_raw()) continue;
    const double ratio = SizeRatio(SizesFromMetric(row.raw), limited);
    if (ratio <= changes.size_ratio_max) continue;
    changes.size_ratio_max = ratio;
    changes.worst = v;
  }
  changed_.clear();
  return changes;
}

/// What a vertex adds to the complexities.
void MetricLimiter::Measure(VertexRings& rings, std::int32_t v) {
  const auto rounded = [](double complexity) {
    // A bound that no sum over a mesh overflows.
    return static_cast<std::int64_t>(std::min(complexity * 0x1p20, 0x1p50));
  };
  const double area = rings.Area(v);
  const Row& now = row(v);
  const std::int64_t raw = rounded(area * std::sqrt(Determinant(now.raw)));
  const std::int64_t limited = rounded(area / (now.label.thin * now.wide));
  if (now.raw_complexity == raw && now.limited_complexity == limited) return;
  Row& row = now.changed ? rows_[AsIndex(v)] : Mutable(v);
  row.raw_complexity = raw;
  row.limited_complexity = limited;
}

Metric MetricLimiter::Limited(std::int32_t vertex) const {
  const Row& row = this->row(vertex);
  return row.is_raw() ? row.raw : MetricFromSizes(row.limited());
}

void MetricLimiter::Commit() {
  PLIANT_CHECK(changed_.empty() && touched_.empty());
  for (const auto& [v, old] : log_) rows_[AsIndex(v)].logged = false;
  log_.clear();
  smoothing_.Commit();
  committed_size_ = rows_.size();
  committed_totals_ = totals_;
}

std::vector<std::pair<std::int32_t, Metric>> MetricLimiter::ChangedRaw() const {
  std::vector<std::pair<std::int32_t, Metric>> changed;
  for (const auto& [v, old] : log_) {
    if (old.live && !(row(v).live && row(v).raw == old.raw)) changed.emplace_back(v, old.raw);
  }
  std::ranges::sort(changed, {}, [](const auto& entry) { return entry.first; });
  return changed;
}

void MetricLimiter::Rollback() {
  // An Update that was stopped has left these.
  for (const std::int32_t v : near_) rows_[AsIndex(v)].near = false;
  near_.clear();
  thin_.Clear();
  wide_.Clear();
  for (const auto& [v, old] : log_) rows_[AsIndex(v)] = old;
  log_.clear();
  smoothing_.Rollback();
  rows_.resize(committed_size_);
  totals_ = committed_totals_;
  touched_.clear();
  changed_.clear();
}

MetricLimiter::Row& MetricLimiter::Mutable(std::int32_t v) {
  Row& row = rows_[AsIndex(v)];
  if (!row.changed) {
    // Of rows that the last commit did not have, nothing comes back.
    if (!row.logged && AsIndex(v) < committed_size_) {
      log_.emplace_back(v, row);
      log_.back().second.near = false;
      row.logged = true;
    }
    if (row.live) Count(row, -1);
    row.changed = true;
    changed_.push_back(v);
  }
  return row;
}

void MetricLimiter::Count(const Row& row, int sign) {
  if (row.smoothed) totals_.smoothing_count += sign;
  if (row.capped) totals_.geometry_count += sign;
  if (row.rotated()) totals_.rotation_count += sign;
  if (row.graded()) totals_.gradation_count += sign;
  totals_.raw_complexity += sign * row.raw_complexity;
  totals_.limited_complexity += sign * row.limited_complexity;
}

void MetricLimiter::AddNear(std::int32_t v) {
  Row& row = rows_[AsIndex(v)];
  if (row.near) return;
  row.near = true;
  near_.push_back(v);
}

void MetricLimiter::AddNearRing(VertexRings& rings, std::int32_t v) {
  for (const std::int32_t q : rings.Neighbors(v)) AddNear(q);
}

double MetricLimiter::Rotated(VertexRings& rings, std::int32_t v, RotationOf pass) const {
  const AxisSizes& sizes = SizesFor(pass, row(v));
  if (rates_.rotation == 0) return sizes.wide;
  double wide = sizes.wide;
  const Vec2 position = rings.position(v);
  for (const std::int32_t q : rings.Neighbors(v)) {
    const AxisSizes& other = SizesFor(pass, row(q));
    wide = std::min(wide, RotationLimit(sizes, other, rings.position(q) - position, rates_));
  }
  return std::max(wide, sizes.thin);
}

AxisSizes MetricLimiter::ThinProblem::None() {
  return {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), {}};
}

double MetricLimiter::WideProblem::None() { return std::numeric_limits<double>::infinity(); }

/// What p offers to q: its axes, or q's own if they leave a larger wide size.
std::optional<AxisSizes> MetricLimiter::ThinProblem::Offer(const AxisSizes& value, std::int32_t p,
                                                           std::int32_t q) const {
  if (value.thin == std::numeric_limits<double>::infinity()) return {};
  const Row& row = limiter.row(q);
  const double growth = limiter.rates_.growth;
  // Against its own wish a vertex takes only a smaller size.
  if (!(value.thin < row.own.thin)) return {};
  const Vec2 e = rings.position(q) - rings.position(p);
  const double thin = ThinLimit(value, e, growth);
  if (!(thin < row.own.thin)) return {};
  const double limit = WideLimit(value, e, growth);
  const double kept = std::min(row.base_wide, limit);
  const double adopted = std::min(WideInFrame(row.own, value.frame, thin), limit);
  if (adopted >= kept) return AxisSizes{thin, adopted, value.frame};
  return AxisSizes{thin, kept, row.own.frame};
}

std::optional<double> MetricLimiter::WideProblem::Offer(double value, std::int32_t p,
                                                        std::int32_t q) const {
  const Row& to = limiter.row(q);
  if (!(value < to.cap)) return {};
  const Row& from = limiter.row(p);
  const Vec2 e = rings.position(q) - rings.position(p);
  const AxisSizes sizes{from.label.thin, value, from.label.frame};
  const double wide = std::max(WideLimit(sizes, e, limiter.rates_.growth), to.label.thin);
  if (!(wide < to.cap)) return {};
  return wide;
}

}  // namespace pliant
