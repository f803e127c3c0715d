#include "core/pliant/recalled_field.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/base/as_index.h"

namespace pliant {
namespace {

/// A corner agrees if what it has and what was there one shift back differ by no more than this,
/// in logarithms of squared lengths.
constexpr double kAgrees = 0.5;

/// A triangle knows enough of the metric of a vertex for which its sides are no longer than this.
constexpr double kSquaredSideMax = 2.25;

}  // namespace

RecalledField::RecalledField(std::unique_ptr<BackgroundField> sent,
                             std::shared_ptr<FrozenMesh> before)
    : sent_(std::move(sent)), before_(std::move(before)) {}

void RecalledField::SetShift(Vec2 by) {
  by_ = by;
  recalls_ = false;
  rests_.Clear();
  recalled_.assign(AsIndex(sent_->locator().triangle_count()), kUnknown);
}

std::optional<Metric> RecalledField::Recall(const Arrival& arrival) {
  if (!Knows(arrival)) return std::nullopt;
  const Location location = sent_->locator().Locate(arrival.place, arrival.triangle);
  return Exp(Log(arrival.tensor) + RestIn(location));
}

/// True if answers in the triangle of an arrival are those of before.
bool RecalledField::Knows(const Arrival& arrival) {
  std::int32_t& recalled = recalled_[AsIndex(arrival.triangle)];
  if (recalled != kUnknown) return recalled != kForgotten;
  if (!IsCoarse(arrival.triangle, arrival.tensor)) return false;
  std::int32_t from = arrival.from_triangle;
  recalled = from;
  for (const std::int32_t corner : sent_->locator().corners(arrival.triangle)) {
    if (!RestAt(corner, from).agrees) recalled = kForgotten;
  }
  recalls_ = recalls_ || recalled != kForgotten;
  return recalled != kForgotten;
}

RecalledField::Rest RecalledField::RestAt(std::int32_t corner, std::int32_t& from_triangle) {
  if (const Rest* known = rests_.Find(corner); known != nullptr) return *known;
  Rest& rest = rests_.Insert(corner, {});
  const Vec2 origin = sent_->locator().points()[AsIndex(corner)] - by_;
  const Location location = before_->Locate(origin, from_triangle);
  if (!location.inside) return rest;
  from_triangle = location.triangle;
  const LogMetric was = before_->LogAt(origin, from_triangle);
  rest.log = sent_->logs()[AsIndex(corner)] + (-1) * was;
  rest.agrees = LogDistance(rest.log, {}) <= kAgrees;
  return rest;
}

bool RecalledField::IsCoarse(std::int32_t triangle, const Metric& tensor) const {
  const auto& corners = sent_->locator().corners(triangle);
  const auto points = sent_->locator().points();
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec2 side = points[AsIndex(corners[(k + 1) % 3])] - points[AsIndex(corners[k])];
    if (SquaredLength(tensor, side) > kSquaredSideMax) return true;
  }
  return false;
}

Metric RecalledField::At(Vec2 p, std::int32_t& hint) const {
  const Location location = sent_->locator().Locate(p, hint);
  hint = location.triangle;
  if (!recalls_ || recalled_[AsIndex(hint)] < 0) return Exp(sent_->LogIn(location));
  return Exp(before_->LogAt(p - by_, recalled_[AsIndex(hint)]) + RestIn(location));
}

/// @pre the triangle is recalled
LogMetric RecalledField::RestIn(const Location& location) const {
  const auto& corners = sent_->locator().corners(location.triangle);
  LogMetric log = location.weights[0] * rests_.Find(corners[0])->log;
  for (std::size_t k = 1; k < 3; ++k) {
    log = log + location.weights[k] * rests_.Find(corners[k])->log;
  }
  return log;
}

std::optional<Metric> RecalledField::Probe(Vec2 p, std::int32_t& hint) const {
  if (!Meet(sent_->locator().box(), {p, p})) return std::nullopt;
  return At(p, hint);
}

void RecalledField::ProbeEach(std::span<Question> questions) const {
  if (recalls_) {
    MetricField::ProbeEach(questions);
  } else {
    sent_->ProbeEach(questions);
  }
}

void RecalledField::ProbeLogEach(std::span<LogQuestion> questions) const {
  if (recalls_) {
    MetricField::ProbeLogEach(questions);
  } else {
    sent_->ProbeLogEach(questions);
  }
}

std::size_t RecalledField::bytes() const {
  return sent_->bytes() + rests_.entries().capacity() * sizeof(Rest) +
         recalled_.capacity() * sizeof(std::int32_t);
}

}  // namespace pliant
