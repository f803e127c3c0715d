#include "core/pliant/metric_shift.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

namespace pliant {
namespace {

/// So many of the samples take part in the first look around, and in the compass search.
constexpr std::size_t kScanned = 24;
/// And before that every so many of these, for which a shift must leave a share of the differences.
/// Most candidates end here, and where nothing has moved all of them do.
constexpr std::size_t kScannedFirst = 3;
constexpr double kWorthALook = 0.9;
/// Distances are halved so many times.
constexpr int kScales = 10;
constexpr int kCompassRounds = 6;
constexpr int kNewtonSteps = 12;
constexpr int kSecondTries = 2;

/// Differences of tensors count up to this: log 50 in squared length.
constexpr double kDifferenceMax = 4;
/// A shift explains the change if it leaves this share of the differences.
constexpr double kExplained = 0.3;
/// One that leaves more than this share may lie in a valley beside the right one: it is looked for
/// again, by all samples.
constexpr double kDoubtful = 0.15;
/// What was sent is exact, so that the way back to the old tensors leaves less than this share.
constexpr double kDoubtfulBack = 0.004;
/// And no more than this, where that is little: vertices hold tensors that differ by less.
constexpr double kHeldBack = 0.02;
/// Newton's steps end when one leaves more than this share.
constexpr double kEnough = 0.98;
/// A look around that finds no shift with less than this share of the differences ends the search.
constexpr double kPromising = 0.8;
/// The first step of a compass search, as a share of the length of the shift: after a look around,
/// and about a shift that is nearly right.
constexpr double kFarStep = 0.4;
constexpr double kNearStep = 0.05;
/// Without a reason to go on, the shorter of two shifts is taken.
constexpr double kClearly = 0.97;

constexpr double kCos1 = 0.9238795325112867;
constexpr double kCos2 = 0.7071067811865476;
constexpr double kCos3 = 0.3826834323650898;
constexpr std::array<Vec2, 16> kDirections = {{{1, 0},
                                               {kCos1, kCos3},
                                               {kCos2, kCos2},
                                               {kCos3, kCos1},
                                               {0, 1},
                                               {-kCos3, kCos1},
                                               {-kCos2, kCos2},
                                               {-kCos1, kCos3},
                                               {-1, 0},
                                               {-kCos1, -kCos3},
                                               {-kCos2, -kCos2},
                                               {-kCos3, -kCos1},
                                               {0, -1},
                                               {kCos3, -kCos1},
                                               {kCos2, -kCos2},
                                               {kCos1, -kCos3}}};

class ShiftSearch {
 public:
  ShiftSearch(std::span<const PlacedTensor> samples, const MetricField& field,
              const StopSignal* stop)
      : field_(field), stop_(stop) {
    low_ = high_ = samples.front().position;
    for (const PlacedTensor& sample : samples) {
      const Vec2 p = sample.position;
      low_ = {std::min(low_.x, p.x), std::min(low_.y, p.y)};
      high_ = {std::max(high_.x, p.x), std::max(high_.y, p.y)};
      places_.push_back({p, Log(sample.tensor), sample.hint});
    }
  }

  /// From a shift that is nearly right.
  Vec2 Refine(Vec2 from) {
    const double before = Cost({}, 1);
    Vec2 best = Newton(from);
    double cost = Cost(best, 1);
    // Newton's steps can end beside a front that is thinner than what they have left.
    const double doubtful = std::max(kDoubtfulBack * before, kHeldBack);
    for (int again = 0; again < kSecondTries && cost > doubtful; ++again) {
      const Vec2 other = Newton(Walk(best, {.stride = 1, .step = kNearStep}));
      const double last = std::exchange(cost, Cost(other, 1));
      if (cost < last) best = other;
      if (!(cost < kEnough * last)) break;
    }
    return best;
  }

  std::optional<Vec2> Run() {
    const double before = Cost({}, 1);
    Vec2 best = Scan();
    if (best == Vec2{}) return std::nullopt;
    const std::size_t few = std::max<std::size_t>(1, places_.size() / kScanned);
    best = Newton(Walk(best, {.stride = few, .step = kFarStep}));
    double cost = Cost(best, 1);
    // The look around can have begun in the wrong place, of a valley that bends.
    for (int again = 0; again < kSecondTries && !(cost < kDoubtful * before); ++again) {
      best = Newton(Walk(best, {.stride = 1, .step = kFarStep}));
      const double last = std::exchange(cost, Cost(best, 1));
      if (!(cost < kEnough * last)) break;
    }
    if (!(cost < kExplained * before)) return std::nullopt;
    return best;
  }

 private:
  struct Place {
    Vec2 position;
    LogMetric log;
    std::int32_t hint;
  };

  /// Asks for the logarithm that the field has after a shift, of every `stride`-th place; nothing
  /// where it has no answer.
  std::span<const MetricField::LogQuestion> Ask(Vec2 shift, std::size_t stride) {
    questions_.clear();
    for (std::size_t i = 0; i < places_.size(); i += stride) {
      questions_.push_back({places_[i].position + shift, places_[i].hint, {}});
    }
    field_.ProbeLogEach(questions_);
    for (std::size_t k = 0; k < questions_.size(); ++k) {
      places_[k * stride].hint = questions_[k].hint;
    }
    return questions_;
  }

  std::vector<std::optional<LogMetric>> LogsAt(Vec2 shift) {
    std::vector<std::optional<LogMetric>> logs;
    for (const MetricField::LogQuestion& one : Ask(shift, 1)) logs.push_back(one.answer);
    return logs;
  }

  /// Mean difference over every `stride`-th place. Once stopped no shift is better than another.
  double Cost(Vec2 shift, std::size_t stride) {
    if (stop_ != nullptr && stop_->asked()) return kDifferenceMax;
    double sum = 0;
    const auto questions = Ask(shift, stride);
    for (std::size_t k = 0; k < questions.size(); ++k) {
      const std::optional<LogMetric>& answer = questions[k].answer;
      sum += answer ? std::min(kDifferenceMax, LogDistance(*answer, places_[k * stride].log))
                    : kDifferenceMax;
    }
    return sum / static_cast<double>(questions.size());
  }

  /// The best of shifts on circles around zero.
  Vec2 Scan() {
    const std::size_t stride = std::max<std::size_t>(1, places_.size() / kScanned);
    double least = kPromising * Cost({}, stride);
    Vec2 best;
    const double worth = kWorthALook * Cost({}, kScannedFirst * stride);
    double radius = 0.5 * Length(high_ - low_);
    for (int scale = 0; scale < kScales; ++scale, radius *= 0.5) {
      for (const Vec2 direction : kDirections) {
        if (!(Cost(radius * direction, kScannedFirst * stride) < worth)) continue;
        const double cost = Cost(radius * direction, stride);
        // Radii shrink: a shorter shift that is as good is preferred.
        if (!(cost * kClearly < least)) continue;
        least = std::min(least, cost);
        best = radius * direction;
      }
    }
    return best;
  }

  struct Compass {
    std::size_t stride;  ///< Every so many of the places take part.
    double step;         ///< The first, as a share of the shift.
  };

  Vec2 Walk(Vec2 best, const Compass& compass) {
    const std::size_t stride = compass.stride;
    double least = Cost(best, stride);
    double step = compass.step * Length(best);
    for (int round = 0; round < kCompassRounds; ++round, step *= 0.5) {
      const Vec2 from = best;
      for (std::size_t k = 0; k < kDirections.size(); k += 2) {
        const Vec2 candidate = from + step * kDirections[k];
        const double cost = Cost(candidate, stride);
        if (!(cost < least)) continue;
        least = cost;
        best = candidate;
      }
    }
    return best;
  }

  /// Gauss-Newton steps on the sum of the differences, not of their squares: places that do not
  /// take part in the motion shall not spoil it.
  Vec2 Newton(Vec2 best) {
    double least = Cost(best, 1);
    for (int round = 0; round < kNewtonSteps; ++round) {
      const Vec2 step = NewtonStep(best);
      const double before = least;
      bool better = false;
      for (double share = 1; !better && share > 0.05; share *= 0.5) {
        const double cost = Cost(best + share * step, 1);
        better = cost < least;
        if (!better) continue;
        least = cost;
        best = best + share * step;
      }
      if (!(least < kEnough * before)) break;
    }
    return best;
  }

  Vec2 NewtonStep(Vec2 at) {
    const double delta = 1e-4 * Length(at);
    double a11 = 0;
    double a12 = 0;
    double a22 = 0;
    Vec2 b;
    const auto all_here = LogsAt(at);
    const auto all_right = LogsAt(at + Vec2{delta, 0});
    const auto all_up = LogsAt(at + Vec2{0, delta});
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const Place& place = places_[i];
      const std::optional<LogMetric>& here = all_here[i];
      const std::optional<LogMetric>& right = all_right[i];
      const std::optional<LogMetric>& up = all_up[i];
      if (!here || !right || !up) continue;
      const double difference = LogDistance(*here, place.log);
      if (difference > 1) continue;
      const double weight = 1 / std::max(difference, 1e-3);
      const LogMetric gone = place.log + (-1) * *here;
      const LogMetric dx = (1 / delta) * (*right + (-1) * *here);
      const LogMetric dy = (1 / delta) * (*up + (-1) * *here);
      const auto dot = [](const LogMetric& u, const LogMetric& v) {
        return u.l11 * v.l11 + 2 * u.l12 * v.l12 + u.l22 * v.l22;
      };
      a11 += weight * dot(dx, dx);
      a12 += weight * dot(dx, dy);
      a22 += weight * dot(dy, dy);
      b = b + weight * Vec2{dot(dx, gone), dot(dy, gone)};
    }
    // Along a straight front nothing is known; it is not moved along itself.
    const double slack = 1e-6 * (a11 + a22);
    a11 += slack;
    a22 += slack;
    const double determinant = a11 * a22 - a12 * a12;
    if (!(determinant > 0)) return {};
    return {(a22 * b.x - a12 * b.y) / determinant, (a11 * b.y - a12 * b.x) / determinant};
  }

  const MetricField& field_;
  const StopSignal* const stop_;
  std::vector<Place> places_;
  std::vector<MetricField::LogQuestion> questions_;  // Of the last Ask.
  Vec2 low_;
  Vec2 high_;
};

}  // namespace

std::optional<Vec2> FindShift(std::span<const PlacedTensor> samples, const MetricField& field,
                              const StopSignal* stop) {
  if (samples.empty()) return std::nullopt;
  return ShiftSearch(samples, field, stop).Run();
}

Vec2 RefineShift(std::span<const PlacedTensor> samples, const MetricField& field, Vec2 from) {
  if (samples.empty()) return from;
  return ShiftSearch(samples, field, nullptr).Refine(from);
}

}  // namespace pliant
