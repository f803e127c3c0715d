#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/base/result.h"
#include "core/base/stop_signal.h"
#include "core/geometry/bounding_box.h"
#include "core/geometry/mesh_data.h"
#include "core/metric/gradation.h"
#include "core/metric/metric.h"
#include "core/metric/metric_field.h"

namespace pliant {

/// The tensor by three expressions in x, y and t, in 1 / domain unit squared. Syntax:
/// core/metric/README.md.
struct ExpressionMetric {
  std::string m11;
  std::string m12;
  std::string m22;

  friend bool operator==(const ExpressionMetric&, const ExpressionMetric&) = default;
};

/// An isotropic metric by one expression in x, y and t: the wanted edge length, in domain units.
struct SizeMetric {
  std::string size;

  friend bool operator==(const SizeMetric&, const SizeMetric&) = default;
};

/// Tensors at the vertices of a background mesh, log-Euclidean in between.
struct BackgroundMetric {
  MeshData mesh;
  std::vector<Metric> tensors;  ///< One per point of `mesh`.

  friend bool operator==(const BackgroundMetric&, const BackgroundMetric&) = default;
};

/// A metric that stands for itself.
using PlainMetric = std::variant<ExpressionMetric, SizeMetric, BackgroundMetric>;

/// Several metrics at once: in every direction the finest holds.
struct IntersectedMetric {
  static constexpr std::size_t kPartsMax = 16;

  std::vector<PlainMetric> parts;  ///< 1 to kPartsMax, intersected in this order.

  friend bool operator==(const IntersectedMetric&, const IntersectedMetric&) = default;
};

/// Everything that says which metric a session follows.
struct MetricSpec {
  std::variant<ExpressionMetric, SizeMetric, BackgroundMetric, IntersectedMetric> source =
      SizeMetric{"1"};
  double time = 0;  ///< The value of t in expressions, finite.
  /// Sizes given here lie in [1e-70, 1e70].
  SizeBounds bounds = {};
  /// How much the metric may change from place to place; off unless asked for, or needed
  /// (`automatic`). Applied at the vertices of the mesh by whoever follows the field (Remesher),
  /// not by the field itself. gradation 0 or in [1, 10], rotation 0 or in [0.1, 10].
  GradationOptions gradation = {};

  friend bool operator==(const MetricSpec&, const MetricSpec&) = default;
};

/// What limits a metric, whatever it comes from.
struct MetricLimits {
  SizeBounds bounds = {};           ///< As MetricSpec::bounds.
  GradationOptions gradation = {};  ///< As MetricSpec::gradation.

  friend bool operator==(const MetricLimits&, const MetricLimits&) = default;
};

/// Refuses impossible bounds. Errors: kOutOfRange; `field` starts with "metric.limits.".
[[nodiscard]] Status CheckBounds(const SizeBounds& bounds);

/// True if a specification is all formulas: small, and another one where the time is another.
[[nodiscard]] bool IsFormula(const MetricSpec& spec);

/// Builds the field that a specification describes, bounds applied.
///
/// An expression is parsed here and tried at the corners and the centre of `box`; if it has no
/// usable value at any of them, that is a mistake and refused at once. A single bad corner is not,
/// for it may lie outside the domain: what happens inside shows in MetricField::status.
///
/// What makes a tensor or a size usable, and what bounds.size_max does for semi-definite ones:
/// core/metric/README.md.
///
/// @return the field, or the first error; `field` starts with "metric.":
///         kExpressionSyntax and kTooLarge (index = position in the text), kExpressionValue;
///         kArrayLength, kNotFinite, kNotPositiveDefinite for tensors (index = first bad one);
///         kEmpty, kNotFinite, kIndexOutOfRange, kTriangleDegenerate, kTriangleOrientation,
///         kNonManifoldEdge for a background mesh (index = first bad point or triangle; the
///         other triangle at the edge in other_index); kOutOfRange for bounds and kNotFinite for
///         the time. Overlapping triangles are not looked for: where they overlap, the value is
///         that of one of them. Of several metrics the message begins with which one is meant;
///         kEmpty and kTooLarge (`field` "metric.sources") for their number.
/// @param stop  null: nobody; else kCancelled if it asks to while a background mesh is read.
/// @par Cost  parsing, or O(n log n) for n background triangles.
[[nodiscard]] Result<std::unique_ptr<MetricField>> MakeMetricField(
    const MetricSpec& spec, const BoundingBox& box, const StopSignal* stop = nullptr);

}  // namespace pliant
