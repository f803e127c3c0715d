#pragma once

#include <cstdint>
#include <utility>

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

 private:
  Function function_;
};

}  // namespace pliant
