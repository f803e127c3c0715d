#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/base/bytes.h"
#include "core/base/result.h"
#include "core/geometry/vec2.h"
#include "core/metric/metric.h"

namespace pliant {

/// A metric that can be asked for at any point of the domain, at any time: the paper's "element
/// size function".
///
/// *Invariants*: pure; the same point and any hint give the same bits, so that the order of
/// questions cannot change a mesh. Every answer is positive definite.
/// *Threads*: `At` and `AtEach` from as many as you like; the rest, one caller at a time and none
/// of these meanwhile.
class MetricField {
 public:
  virtual ~MetricField() = default;

  /// The metric at p.
  ///
  /// @param p     a finite point; where the field is not defined (outside a background mesh) the
  ///              value at its nearest point holds.
  /// @param hint  where the last search near p ended, kNoHint at first; only ever a speed-up.
  [[nodiscard]] virtual Metric At(Vec2 p, std::int32_t& hint) const = 0;

  /// The metrics at many points at once, each with the bits that At gives: what is the same work at
  /// every point is then paid once for several.
  ///
  /// @param points   as for At.
  /// @param hints    one for each point, as for At; at kNoHint the search begins where that for the
  ///                 point before it ended.
  /// @param metrics  gets the answers. @pre all three are equally long
  virtual void AtEach(std::span<const Vec2> points, std::span<std::int32_t> hints,
                      std::span<Metric> metrics) const {
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (hints[i] == kNoHint && i > 0) hints[i] = hints[i - 1];
      metrics[i] = At(points[i], hints[i]);
    }
  }

  /// The same as At for someone who only looks around: nothing where there is no usable answer, and
  /// no trace of the question in status(). The point may lie outside the domain.
  [[nodiscard]] virtual std::optional<Metric> Probe(Vec2 p, std::int32_t& hint) const {
    return At(p, hint);
  }

  /// One of several questions of someone who looks around.
  template <class Answer>
  struct QuestionFor {
    Vec2 place;
    std::int32_t hint = kNoHint;
    std::optional<Answer> answer;
  };
  using Question = QuestionFor<Metric>;
  /// Probe for each of them, with the same answers; those that walk through a mesh go side by side.
  virtual void ProbeEach(std::span<Question> questions) const {
    for (Question& one : questions) one.answer = Probe(one.place, one.hint);
  }

  using LogQuestion = QuestionFor<LogMetric>;
  /// The same for the logarithms of the metrics, to rounding: where these are what the field is
  /// made of, there is neither an exponential to compute nor its logarithm.
  virtual void ProbeLogEach(std::span<LogQuestion> questions) const {
    for (LogQuestion& one : questions) {
      const std::optional<Metric> metric = Probe(one.place, one.hint);
      one.answer = metric ? std::optional(Log(*metric)) : std::nullopt;
    }
  }

  /// Says that At will soon be asked with this hint, so that the memory can be fetched by then:
  /// first what the hint names, later, when that is there, what it leads to. Any hint will do.
  virtual void PrefetchHint(std::int32_t /*hint*/) const {}
  virtual void PrefetchBehindHint(std::int32_t /*hint*/) const {}

  /// A question since the field was made that it had no usable answer to: an expression that is
  /// NaN or not positive definite at a point of the domain (kExpressionValue, the point in the
  /// message); of several, the one at the lowest x, then y, whatever their order. `At` answered
  /// it with some valid metric all the same; whoever asked must throw away what was built from it.
  [[nodiscard]] virtual Status status() const { return {}; }

  /// Writes what the field is made of, so that ReadField (saved_field.h) makes another one that
  /// answers with the same bits. Errors: kUnimplemented for a field that cannot be written: one of
  /// a caller's own.
  [[nodiscard]] virtual Status Save(ByteWriter& /*writer*/) const {
    return Error{ErrorCode::kUnimplemented,
                 "the session follows a metric field of the caller's own, which has no written "
                 "form; to save it, use an expression, a background mesh or tensors at vertices",
                 "metric"};
  }

  /// What the field takes in memory, roughly.
  [[nodiscard]] virtual std::size_t bytes() const { return 0; }

  static constexpr std::int32_t kNoHint = -1;
};

}  // namespace pliant
