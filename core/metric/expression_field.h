#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <variant>

#include "core/base/result.h"
#include "core/geometry/domain.h"
#include "core/metric/expression.h"
#include "core/metric/metric.h"
#include "core/metric/metric_field.h"
#include "core/metric/metric_spec.h"
#include "core/metric/shared_program.h"

namespace pliant {

/// What the fields by expression share: the time, the bounds, and the rule that a point without a
/// usable value is remembered: the lowest by x, then y, so that the order of questions has no say.
class ExpressionField : public MetricField {
 public:
  struct Settings {
    double time = 0;
    SizeBounds bounds;
    /// The answer where the expression has none.
    Metric fallback;
  };

  [[nodiscard]] Metric At(Vec2 p, std::int32_t& hint) const final;
  void AtEach(std::span<const Vec2> points, std::span<std::int32_t> hints,
              std::span<Metric> metrics) const final;
  [[nodiscard]] std::optional<Metric> Probe(Vec2 p, std::int32_t& /*hint*/) const final {
    return Evaluate(p);
  }
  [[nodiscard]] Status status() const final;
  [[nodiscard]] Status Save(ByteWriter& writer) const final;
  [[nodiscard]] std::size_t bytes() const final;

  /// Forgets the error, after a trial at points that may lie outside the domain.
  void ClearStatus() { failed_at_.reset(); }

 protected:
  explicit ExpressionField(const Settings& settings) : settings_(settings) {}

  [[nodiscard]] const Settings& settings() const { return settings_; }

  static constexpr std::size_t kBlockLength = SharedProgram::kBlockLength;
  using BlockAnswers = std::array<std::optional<Metric>, kBlockLength>;

 private:
  /// The bounded metric at p; nothing if the value there is not usable.
  [[nodiscard]] virtual std::optional<Metric> Evaluate(Vec2 p) const = 0;
  /// The same at up to kBlockLength points, in order.
  [[nodiscard]] virtual BlockAnswers EvaluateBlock(std::span<const Vec2> points) const = 0;
  /// The expressions' texts.
  [[nodiscard]] virtual std::variant<ExpressionMetric, SizeMetric> Source() const = 0;
  /// What is wrong at p, where Evaluate returned nothing.
  [[nodiscard]] virtual Error Describe(Vec2 p) const = 0;

  void Remember(Vec2 p) const;

  Settings settings_;
  mutable std::atomic_flag busy_;  // Guards what follows while `At` runs in several threads.
  mutable std::optional<Vec2> failed_at_;
};

/// Parses the three expressions; errors name "metric.m11", "metric.m12" or "metric.m22".
[[nodiscard]] Result<std::unique_ptr<ExpressionField>> MakeTensorField(
    const ExpressionMetric& metric, const ExpressionField::Settings& settings);

/// Parses the expression; errors name "metric.size".
[[nodiscard]] Result<std::unique_ptr<ExpressionField>> MakeSizeField(
    const SizeMetric& metric, const ExpressionField::Settings& settings);

}  // namespace pliant
