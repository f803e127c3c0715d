#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/result.h"
#include "core/base/stop_signal.h"
#include "core/geometry/vec2.h"
#include "core/metric/metric.h"
#include "core/metric/metric_field.h"
#include "core/metric/metric_spec.h"

namespace pliant {

/// Metrics that are functions of place, to be intersected with tensors at the vertices of a mesh.
struct FunctionsSpec {
  std::vector<PlainMetric> parts;  ///< 1 to kPartsMax, in this order.
  std::size_t before_count = 0;    ///< How many of them come before the tensors.
  double time = 0;                 ///< The value of t in expressions, finite.

  /// With the tensors they are as many as IntersectedMetric may have.
  static constexpr std::size_t kPartsMax = IntersectedMetric::kPartsMax - 1;

  friend bool operator==(const FunctionsSpec&, const FunctionsSpec&) = default;
};

/// The fields that a FunctionsSpec describes, and what they make of tensors at vertices: in every
/// direction the finest holds, as in an IntersectedField with the tensors as one of its parts.
///
/// *Invariants*: those of MetricField. *Threads*: those of MetricField.
class MetricFunctions {
 public:
  /// Errors: those of MakeMetricField, the message beginning with which source is meant, tensors
  /// counted; kOutOfRange for before_count.
  /// @param bounds  of each part, and of what comes out. @param box  as for MakeMetricField
  [[nodiscard]] static Result<std::shared_ptr<const MetricFunctions>> Make(
      FunctionsSpec spec, const SizeBounds& bounds, const BoundingBox& box,
      const StopSignal* stop = nullptr);

  /// True if they are the same, or are made from the same; null is no functions.
  [[nodiscard]] static bool AreSame(const MetricFunctions* a, const MetricFunctions* b);
  /// True if Make(spec, bounds) would make the same.
  [[nodiscard]] bool IsMadeFrom(const FunctionsSpec& spec, const SizeBounds& bounds) const {
    return spec == spec_ && bounds == bounds_;
  }
  [[nodiscard]] const FunctionsSpec& spec() const { return spec_; }

  /// Puts in the place of each tensor its intersection with the functions at its point, bounded.
  /// @pre as many points as tensors
  void MeetEach(std::span<const Vec2> points, std::span<Metric> tensors) const;

  /// The intersection of a field of tensors with the functions, wherever it is asked, with the bits
  /// that MeetEach makes of the field's answer. Hints are those of `tensors`.
  [[nodiscard]] std::shared_ptr<MetricField> Over(std::shared_ptr<MetricField> tensors) const;

  /// The first error of the first part that has one (MetricField::status).
  [[nodiscard]] Status status() const;
  [[nodiscard]] std::size_t bytes() const;

  /// Writes what Read makes the same functions of. Read returns null, and the reader fails, where
  /// the bytes cannot be some.
  void Save(ByteWriter& writer) const;
  [[nodiscard]] static std::shared_ptr<const MetricFunctions> Read(ByteReader& reader);

 private:
  MetricFunctions(FunctionsSpec spec, const SizeBounds& bounds, const BoundingBox& box);

  FunctionsSpec spec_;
  SizeBounds bounds_;
  BoundingBox box_;
  std::vector<std::shared_ptr<MetricField>> parts_;
  // Where the last search of each part ended; which thread wrote it decides only the time.
  mutable std::vector<std::atomic<std::int32_t>> hints_;
};

}  // namespace pliant
