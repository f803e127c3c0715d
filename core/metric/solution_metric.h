#pragma once

#include <span>
#include <variant>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/mesh_data.h"
#include "core/metric/metric.h"

namespace pliant {

/// How fine a mesh for a solution shall be.
struct TargetComplexity {
  /// Wanted integral of sqrt(det M) over the mesh; a unit mesh has about 2 / sqrt(3) times as many
  /// vertices and 4 / sqrt(3) times as many triangles. > 0.
  double complexity = 1000;
};
struct TargetError {
  /// Wanted mean error of linear interpolation in the Lp norm, (1/|domain| integral e^p)^(1/p), in
  /// the field's unit; by the model of a unit mesh, which is on the safe side where the Hessian is
  /// indefinite. Of several fields, each has it. > 0.
  double error = 1e-3;
};

/// What a metric shall do for a solution.
struct SolutionTarget {
  std::variant<TargetComplexity, TargetError> target = TargetComplexity{};
  /// p of the Lp norm of the interpolation error that is to be least, 1 to 100. Small p follows all
  /// scales of the solution, large p its strongest feature.
  double norm_exponent = 2;
  /// Eigenvalues of |H| count as no smaller than this share of (range of the values) / (diameter of
  /// the mesh)^2: a floor, so that a field without curvature has a metric, too. Larger puts
  /// more vertices into calm places. 0 < share <= 1; for users of the core only.
  double calm_share = 1e-3;
  /// Applied to the result; a target complexity is reached with them, if it can be.
  SizeBounds bounds = {};
};

/// The metric at the vertices of a mesh that makes the interpolation error of nodal fields least.
///
/// From the recovered Hessian H of each field, floor applied, comes the metric that is optimal for
/// the Lp norm, D det|H|^(-1/(2p+2)) |H| [LoseilleAlauzet2011]; D from the target. Metrics of
/// several fields are intersected, and for a target complexity scaled together until the bounded
/// result has it. The integral is that of the metric which is log-Euclidean between the vertices.
///
/// A field knows only what the mesh that carries it resolves: adapt, evaluate or compute the
/// solution on the new mesh, and repeat; about five rounds suffice.
/// @param fields  each one value per point of `mesh`; at least one field. Components of vectors are
///                fields.
/// @return one tensor per point, or kEmpty, kArrayLength, kNotFinite (index = point, other_index =
///         field), kOutOfRange; `field` starts with "metric.solution".
/// @par Cost  O(n) for each field, and for a target complexity with bounds up to 60 sweeps.
[[nodiscard]] Result<std::vector<Metric>> MetricOfSolution(
    const MeshData& mesh, std::span<const std::vector<double>> fields,
    const SolutionTarget& target);

/// The integral of sqrt(det M) over a mesh, M log-Euclidean between the vertices: its square root
/// of the determinant is the exponential of a linear function. By a rule of degree 5 [Radon1948].
/// @pre tensors, one per point, are positive definite
[[nodiscard]] double ComplexityOf(const MeshData& mesh, std::span<const Metric> tensors);

}  // namespace pliant
