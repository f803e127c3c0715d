#include "core/metric/limiter.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/check.h"
#include "core/base/math.h"

namespace pliant {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::size_t Index(std::int32_t vertex) { return static_cast<std::size_t>(vertex); }

}  // namespace

MetricLimiter::MetricLimiter(const GradationOptions& options)
    : rates_{.growth = options.gradation == 0 ? 0 : Log(options.gradation),
             .rotation = options.rotation},
      grows_(options.gradation != 0) {
  PLIANT_CHECK(options.gradation == 0 || options.gradation >= 1, "gradation", options.gradation);
  PLIANT_CHECK(options.rotation >= 0, "rotation", options.rotation);
}

void MetricLimiter::SetRaw(std::int32_t vertex, const Metric& raw) {
  if (Index(vertex) >= rows_.size()) rows_.resize(Index(vertex) + 1);
  Row& row = Mutable(vertex);
  row.is_new = row.is_new || !row.live;
  row.live = true;
  row.raw = raw;
  row.own = SizesFromMetric(raw);
  Touch(vertex);
}

void MetricLimiter::Remove(std::int32_t vertex) {
  Row& row = Mutable(vertex);
  row.live = false;
  row.is_new = false;
}

LimitChanges MetricLimiter::Update(VertexRings& rings) {
  for (const std::int32_t v : touched_) {
    if (!row(v).live) continue;
    AddNear(v);
    AddNearRing(rings, v);
  }
  touched_.clear();
  for (const std::int32_t v : near_) LimitOwn(rings, v);
  const std::int64_t settled_before = thin_.settled_count() + wide_.settled_count();
  if (grows_) Grow(rings);
  LimitChanges changes = Finish();
  changes.looked_count =
      std::ssize(near_) + thin_.settled_count() + wide_.settled_count() - settled_before;
  for (const std::int32_t v : near_) rows_[Index(v)].near = false;
  near_.clear();
  return changes;
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
void MetricLimiter::Grow(VertexRings& rings) {
  ThinProblem thin{*this, rings};
  for (const std::int32_t v : near_) thin_.Recheck(thin, v);
  std::vector<std::int32_t> relabeled;
  thin_.Settle(thin, [&](std::int32_t v) {
    Mutable(v);
    relabeled.push_back(v);
  });
  for (const std::int32_t v : relabeled) {
    AddNear(v);
    AddNearRing(rings, v);
  }
  for (const std::int32_t v : near_) {
    const double cap = Rotated(rings, v, RotationOf::kLabel);
    if (row(v).cap != cap) Mutable(v).cap = cap;
  }
  WideProblem wide{*this, rings};
  for (const std::int32_t v : near_) wide_.Recheck(wide, v);
  wide_.Settle(wide, [&](std::int32_t v) { Mutable(v); });
}

LimitChanges MetricLimiter::Finish() {
  LimitChanges changes;
  std::sort(changed_.begin(), changed_.end());
  for (const std::int32_t v : changed_) {
    Row& row = rows_[Index(v)];
    row.changed = false;
    if (!row.live) continue;
    Count(row, 1);
    changes.vertices.push_back(v);
    changes.rotation_count += row.rotated() ? 1 : 0;
    changes.gradation_count += row.graded() ? 1 : 0;
    if (row.limited() != row.own) {
      changes.size_ratio_max = std::max(changes.size_ratio_max, SizeRatio(row.own, row.limited()));
    }
  }
  changed_.clear();
  return changes;
}

Metric MetricLimiter::Limited(std::int32_t vertex) const {
  const Row& row = this->row(vertex);
  return row.limited() == row.own ? row.raw : MetricFromSizes(row.limited());
}

void MetricLimiter::Commit() {
  PLIANT_CHECK(changed_.empty() && touched_.empty());
  for (const auto& [v, old] : log_) rows_[Index(v)].logged = false;
  log_.clear();
  committed_size_ = rows_.size();
  committed_counts_ = counts_;
}

void MetricLimiter::Rollback() {
  for (const auto& [v, old] : log_) rows_[Index(v)] = old;
  log_.clear();
  rows_.resize(committed_size_);
  counts_ = committed_counts_;
  touched_.clear();
  changed_.clear();
}

MetricLimiter::Row& MetricLimiter::Mutable(std::int32_t v) {
  Row& row = rows_[Index(v)];
  if (!row.changed) {
    if (!row.logged) {
      log_.emplace_back(v, row);
      log_.back().second.near = false;
    }
    if (row.live) Count(row, -1);
    row.changed = true;
    row.logged = true;
    changed_.push_back(v);
  }
  return row;
}

void MetricLimiter::Count(const Row& row, int sign) {
  if (row.rotated()) counts_.rotation += sign;
  if (row.graded()) counts_.gradation += sign;
}

void MetricLimiter::AddNear(std::int32_t v) {
  Row& row = rows_[Index(v)];
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

AxisSizes MetricLimiter::ThinProblem::None() { return {kInfinity, kInfinity, {}}; }

double MetricLimiter::WideProblem::None() { return kInfinity; }

/// What p offers to q: its axes, or q's own if they leave a larger wide size.
std::optional<AxisSizes> MetricLimiter::ThinProblem::Offer(const AxisSizes& value, std::int32_t p,
                                                           std::int32_t q) const {
  if (value.thin == kInfinity) return {};
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
