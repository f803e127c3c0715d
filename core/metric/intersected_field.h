#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/result.h"
#include "core/metric/metric.h"
#include "core/metric/metric_field.h"

namespace pliant {

/// Several fields at once: in every direction the finest holds. [Alauzet2003] The parts are
/// intersected in the order in which they are given, for an intersection is associative only up to
/// rounding; what comes out is bounded once more, because two directions together may ask for less
/// than either size_min.
///
/// *Invariants*: those of MetricField. *Threads*: those of MetricField.
class IntersectedField final : public MetricField {
 public:
  /// @param hinted  the part whose hints callers keep. @pre there is such a part, and none is null
  IntersectedField(std::vector<std::shared_ptr<MetricField>> parts, const SizeBounds& bounds,
                   std::size_t hinted = 0);

  /// The hint is that of one part; the others remember where their last search ended.
  [[nodiscard]] Metric At(Vec2 p, std::int32_t& hint) const override;
  [[nodiscard]] std::optional<Metric> Probe(Vec2 p, std::int32_t& hint) const override;
  /// The first error of the first part that has one.
  [[nodiscard]] Status status() const override;
  [[nodiscard]] Status Save(ByteWriter& writer) const override;
  [[nodiscard]] std::size_t bytes() const override;

 private:
  template <class Ask>
  [[nodiscard]] std::optional<Metric> Meet(Ask ask, std::int32_t& hint) const;

  std::vector<std::shared_ptr<MetricField>> parts_;
  // One for each part; that of `hinted_` is not used. Which thread wrote one last decides only the
  // time.
  mutable std::vector<std::atomic<std::int32_t>> hints_;
  SizeBounds bounds_;
  std::size_t hinted_;
};

}  // namespace pliant
