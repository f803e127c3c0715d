#pragma once

#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/domain.h"
#include "core/geometry/mesh_data.h"
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

/// Everything that says which metric a session follows.
struct MetricSpec {
  std::variant<ExpressionMetric, SizeMetric, BackgroundMetric> source = SizeMetric{"1"};
  double time = 0;  ///< The value of t in expressions.
  SizeBounds bounds;
};

/// Builds the field that a specification describes, bounds applied.
///
/// Expressions are parsed here, and tried at the corners and the centre of `box`, so that a
/// mistake shows at once. Errors: kExpressionSyntax (index = position in the text),
/// kNotFinite and kNotPositiveDefinite (index = first bad tensor), kArrayLength, kOutOfRange
/// for bounds, and those of a bad background mesh; `field` starts with "metric.".
[[nodiscard]] Result<std::unique_ptr<MetricField>> MakeMetricField(const MetricSpec& spec,
                                                                   const BoundingBox& box);

}  // namespace pliant
