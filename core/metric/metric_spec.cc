#include "core/metric/metric_spec.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "core/metric/background_field.h"
#include "core/metric/expression_field.h"
#include "core/metric/intersected_field.h"

namespace pliant {
namespace {

// Squares of sizes and of their ratios must be numbers that metrics can hold.
constexpr double kSizeMin = 1e-70;
constexpr double kSizeMax = 1e70;

/// A metric to go on with where an expression has no value: as coarse as the box allows.
Metric Fallback(const SizeBounds& bounds, const BoundingBox& box) {
  if (bounds.size_max > 0) return Metric::Isotropic(bounds.size_max);
  const Vec2 extent = box.high - box.low;
  const double size = std::max({extent.x, extent.y, bounds.size_min});
  return Metric::Isotropic(std::clamp(size, kSizeMin, kSizeMax));
}

/// Refuses a field that has a value at none of the trial points, with the error of the first.
Status Try(ExpressionField& field, const BoundingBox& box) {
  const std::array<Vec2, 5> points = {0.5 * box.low + 0.5 * box.high,
                                      box.low,
                                      {box.high.x, box.low.y},
                                      box.high,
                                      {box.low.x, box.high.y}};
  Status first_error;
  bool has_value = false;
  for (const Vec2 p : points) {
    std::int32_t hint = MetricField::kNoHint;
    static_cast<void>(field.At(p, hint));
    if (first_error.ok()) first_error = field.status();
    has_value = has_value || field.status().ok();
    field.ClearStatus();
  }
  return has_value ? Status() : first_error;
}

Result<std::unique_ptr<MetricField>> Tried(Result<std::unique_ptr<ExpressionField>> field,
                                           const BoundingBox& box) {
  PLIANT_ASSIGN_OR_RETURN(std::unique_ptr<ExpressionField> made, std::move(field));
  PLIANT_RETURN_IF_ERROR(Try(*made, box));
  return std::unique_ptr<MetricField>(std::move(made));
}

/// What all sources of a specification share.
struct Frame {
  ExpressionField::Settings settings;
  BoundingBox box;
  const StopSignal* stop = nullptr;
};

Result<std::unique_ptr<MetricField>> MakeField(const ExpressionMetric& tensor, const Frame& frame) {
  return Tried(MakeTensorField(tensor, frame.settings), frame.box);
}

Result<std::unique_ptr<MetricField>> MakeField(const SizeMetric& size, const Frame& frame) {
  return Tried(MakeSizeField(size, frame.settings), frame.box);
}

Result<std::unique_ptr<MetricField>> MakeField(const BackgroundMetric& background,
                                               const Frame& frame) {
  PLIANT_ASSIGN_OR_RETURN(std::unique_ptr<BackgroundField> field,
                          BackgroundField::Make(background, frame.settings.bounds, frame.stop));
  return std::unique_ptr<MetricField>(std::move(field));
}

Result<std::unique_ptr<MetricField>> MakeField(const IntersectedMetric& intersected,
                                               const Frame& frame) {
  const std::size_t count = intersected.parts.size();
  if (count == 0 || count > IntersectedMetric::kPartsMax) {
    return Error{.code = count == 0 ? ErrorCode::kEmpty : ErrorCode::kTooLarge,
                 .message = std::to_string(count) + " metrics to intersect; expected 1 to " +
                            std::to_string(IntersectedMetric::kPartsMax),
                 .field = "metric.sources"};
  }
  std::vector<std::shared_ptr<MetricField>> parts;
  for (const PlainMetric& part : intersected.parts) {
    auto made = std::visit([&](const auto& source) { return MakeField(source, frame); }, part);
    if (!made.ok()) {
      Error error = made.error();
      error.message =
          "metric.sources[" + std::to_string(parts.size()) + "]: " + std::move(error.message);
      return error;
    }
    parts.push_back(std::move(*made));
  }
  return std::unique_ptr<MetricField>(
      std::make_unique<IntersectedField>(std::move(parts), frame.settings.bounds));
}

}  // namespace

Status CheckBounds(const SizeBounds& bounds) {
  const auto refuse = [](const char* name, const char* expected) {
    const std::string field = std::string("metric.limits.") + name;
    return Error{.code = ErrorCode::kOutOfRange,
                 .message = field + " is out of range; expected " + expected,
                 .field = field};
  };
  // Written so that NaN fails.
  const auto is_size = [](double size) {
    return size == 0 || (size >= kSizeMin && size <= kSizeMax);
  };
  if (!is_size(bounds.size_min)) return refuse("size_min", "0 (absent) or 1e-70 to 1e70");
  if (!is_size(bounds.size_max)) return refuse("size_max", "0 (absent) or 1e-70 to 1e70");
  if (bounds.size_max > 0 && bounds.size_max < bounds.size_min) {
    return refuse("size_max", "no less than size_min");
  }
  if (bounds.anisotropy_max != 0 &&
      !(bounds.anisotropy_max >= 1 && bounds.anisotropy_max <= kSizeMax)) {
    return refuse("anisotropy_max", "0 (absent) or 1 to 1e70");
  }
  return {};
}

bool IsFormula(const MetricSpec& spec) {
  if (const auto* intersected = std::get_if<IntersectedMetric>(&spec.source)) {
    return std::ranges::none_of(intersected->parts, [](const PlainMetric& part) {
      return std::holds_alternative<BackgroundMetric>(part);
    });
  }
  return !std::holds_alternative<BackgroundMetric>(spec.source);
}

Result<std::unique_ptr<MetricField>> MakeMetricField(const MetricSpec& spec, const BoundingBox& box,
                                                     const StopSignal* stop) {
  PLIANT_RETURN_IF_ERROR(CheckBounds(spec.bounds));
  if (!std::isfinite(spec.time)) {
    return Error{.code = ErrorCode::kNotFinite,
                 .message = "metric.time is NaN or infinite; expected a finite time",
                 .field = "metric.time"};
  }
  const Frame frame = {
      {.time = spec.time, .bounds = spec.bounds, .fallback = Fallback(spec.bounds, box)},
      box,
      stop};
  return std::visit([&](const auto& source) { return MakeField(source, frame); }, spec.source);
}

}  // namespace pliant
