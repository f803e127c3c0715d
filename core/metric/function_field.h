#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "core/geometry/vec2.h"
#include "core/metric/metric.h"
#include "core/metric/metric_field.h"

namespace pliant {

/// A metric field from C++: any callable Metric(Vec2) that is pure and always positive definite.
///
/// *Invariants*: those of MetricField, which the callable must keep; nothing is checked here.
/// *Threads*: as many as the callable allows.
template <class Function>
class FunctionField final : public MetricField {
 public:
  explicit FunctionField(Function function) : function_(std::move(function)) {}

  [[nodiscard]] Metric At(Vec2 p, std::int32_t& /*hint*/) const override { return function_(p); }

  void AtEach(std::span<const Vec2> points, std::span<std::int32_t> /*hints*/,
              std::span<Metric> metrics) const override {
    for (std::size_t i = 0; i < points.size(); ++i) metrics[i] = function_(points[i]);
  }

 private:
  Function function_;
};

}  // namespace pliant
