#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

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
/// *Threads*: `At` from as many as you like; the rest, one caller at a time and no `At` meanwhile.
class MetricField {
 public:
  virtual ~MetricField() = default;

  /// The metric at p.
  ///
  /// @param p     a finite point; where the field is not defined (outside a background mesh) the
  ///              value at its nearest point holds.
  /// @param hint  where the last search near p ended, kNoHint at first; only ever a speed-up.
  [[nodiscard]] virtual Metric At(Vec2 p, std::int32_t& hint) const = 0;

  /// The same for someone who only looks around: nothing where there is no usable answer, and no
  /// trace of the question in status(). The point may lie outside the domain.
  [[nodiscard]] virtual std::optional<Metric> Probe(Vec2 p, std::int32_t& hint) const {
    return At(p, hint);
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
