#pragma once

#include <cmath>
#include <optional>
#include <span>

#include "core/geometry/vec2.h"

namespace pliant {

/// A symmetric 2x2 tensor [m11 m12; m12 m22] in 1 / domain unit squared; as a metric it is positive
/// definite, and an edge vector e has the wanted length if e' M e = 1. [BossenHeckbert1996, sec. 4]
struct Metric {
  double m11 = 1;
  double m12 = 0;
  double m22 = 1;

  /// The metric that wants edges of length `size` in every direction: I / size^2. @pre size > 0
  static constexpr Metric Isotropic(double size) {
    return {1 / (size * size), 0, 1 / (size * size)};
  }

  friend constexpr bool operator==(const Metric&, const Metric&) = default;
  friend constexpr Metric operator+(const Metric& a, const Metric& b) {
    return {a.m11 + b.m11, a.m12 + b.m12, a.m22 + b.m22};
  }
  friend constexpr Metric operator-(const Metric& a, const Metric& b) {
    return {a.m11 - b.m11, a.m12 - b.m12, a.m22 - b.m22};
  }
  friend constexpr Metric operator*(double s, const Metric& a) {
    return {s * a.m11, s * a.m12, s * a.m22};
  }
};

[[nodiscard]] constexpr bool SameBits(const Metric& a, const Metric& b) {
  return SameBits(a.m11, b.m11) && SameBits(a.m12, b.m12) && SameBits(a.m22, b.m22);
}

[[nodiscard]] constexpr double Determinant(const Metric& m) {
  return m.m11 * m.m22 - m.m12 * m.m12;
}

/// e' M e: the squared metric length of the vector e.
[[nodiscard]] constexpr double SquaredLength(const Metric& m, Vec2 e) {
  return m.m11 * e.x * e.x + 2 * m.m12 * e.x * e.y + m.m22 * e.y * e.y;
}

/// a' M b: the inner product that M defines.
[[nodiscard]] constexpr double InnerProduct(const Metric& m, Vec2 a, Vec2 b) {
  return a.x * (m.m11 * b.x + m.m12 * b.y) + a.y * (m.m12 * b.x + m.m22 * b.y);
}

[[nodiscard]] inline bool IsFinite(const Metric& m) {
  return std::isfinite(m.m11) && std::isfinite(m.m12) && std::isfinite(m.m22);
}

/// True if m is positive definite and its lengths and areas can be computed: the determinant, as
/// computed, is a normal number, and the diagonal lies in [1e-150, 1e150]. Where the radii of a
/// slanted metric differ by more than a factor of about 3e7, its entries cannot be told from those
/// of a semi-definite one, and the answer depends on their rounding.
[[nodiscard]] bool IsPositiveDefinite(const Metric& m);

/// A metric by its axes, the form in which people think of it (eq. 3).
struct MetricAxes {
  double major_radius = 1;        ///< r1 > 0, wanted length along the major axis, in domain units.
  double minor_radius = 1;        ///< r2 > 0, r2 <= r1, wanted length across it.
  Vec2 major_direction = {1, 0};  ///< Unit vector along the major axis: (cos t, sin t).
};

/// M = R(t) diag(1/r1^2, 1/r2^2) R(t)^T. [BossenHeckbert1996, eq. 3]
/// @pre radii are positive and finite and the direction has unit length.
[[nodiscard]] Metric MetricFromAxes(const MetricAxes& axes);

/// The inverse of MetricFromAxes: radii are the inverse square roots of the eigenvalues. Uses only
/// + - * / fma and sqrt, so it has the same bits everywhere. The direction points to x > 0, or is
/// (0, +-1); an isotropic metric has (1, 0).
/// @pre IsPositiveDefinite(m)
[[nodiscard]] MetricAxes AxesFromMetric(const Metric& m);

/// The eigenvalues of any symmetric tensor, each accurate relative to its own size.
struct Eigenvalues {
  double low = 0;
  double high = 0;  ///< >= low
};
/// @pre IsFinite(m), entries of at most 1e150 in size.
[[nodiscard]] Eigenvalues EigenvaluesOf(const Metric& m);

/// Distance between x and y with M averaged over both ends. [BossenHeckbert1996, eq. 4]
[[nodiscard]] inline double Distance(Vec2 x, const Metric& mx, Vec2 y, const Metric& my) {
  return std::sqrt(SquaredLength(0.5 * (mx + my), y - x));
}

/// Signed area of the triangle x, y, z with M averaged over its corners; positive if they run
/// counter-clockwise. [BossenHeckbert1996, eq. 5]
[[nodiscard]] inline double NormalizedArea(Vec2 x, const Metric& mx, Vec2 y, const Metric& my,
                                           Vec2 z, const Metric& mz) {
  constexpr double kThird = 1.0 / 3.0;
  return 0.5 * std::sqrt(Determinant(kThird * (mx + my + mz))) * Cross(y - x, z - x);
}

/// The geometric mean of two metrics, the G with G A^-1 G = B: where the wanted size grows linearly
/// from A to B, the metric in the metric's middle between them. Their arithmetic mean where it
/// cannot be computed, so that the mean is always positive definite. [Bhatia2007, prop. 4.1.12]
/// @pre both are positive definite
[[nodiscard]] Metric GeometricMean(const Metric& a, const Metric& b);

/// Matrix logarithm of a metric, and its inverse: the space in which tensors are averaged, because
/// any mean taken there is positive definite. Own exp and log: the same bits on every CPU.
/// [Arsigny2006]
struct LogMetric {
  double l11 = 0;
  double l12 = 0;
  double l22 = 0;

  friend constexpr bool operator==(const LogMetric&, const LogMetric&) = default;
  friend constexpr LogMetric operator+(const LogMetric& a, const LogMetric& b) {
    return {a.l11 + b.l11, a.l12 + b.l12, a.l22 + b.l22};
  }
  friend constexpr LogMetric operator*(double s, const LogMetric& a) {
    return {s * a.l11, s * a.l12, s * a.l22};
  }
};
/// @pre IsPositiveDefinite(m)
[[nodiscard]] LogMetric Log(const Metric& m);
[[nodiscard]] Metric Exp(const LogMetric& l);
/// Log and Exp of each of them, with the same bits. @pre both are equally long
void LogEach(std::span<const Metric> metrics, std::span<LogMetric> logs);
void ExpEach(std::span<const LogMetric> logs, std::span<Metric> metrics);

/// The Frobenius norm of a - b: how unlike two tensors are, whatever the units and axes.
/// [Arsigny2006]
[[nodiscard]] double LogDistance(const LogMetric& a, const LogMetric& b);

/// The log-Euclidean mean exp((1-t) log a + t log b). @pre both positive definite; t in [0, 1]
[[nodiscard]] Metric LogEuclideanMean(const Metric& a, const Metric& b, double t);

/// The largest ellipse inside both: in every direction at least as fine as a and as b, by
/// simultaneous reduction. Symmetric only up to rounding. @pre both positive definite
[[nodiscard]] Metric Intersect(const Metric& a, const Metric& b);

/// How much `now` differs from `old`, whatever the units and axes: the largest |lambda - 1| over
/// the eigenvalues of old^-1 now. 0.05 means that no squared length changed by more than 5 %.
/// @pre both positive definite
[[nodiscard]] double RelativeChange(const Metric& old, const Metric& now);

/// Bounds on the sizes a metric asks for. A bound of 0 is absent.
struct SizeBounds {
  double size_min = 0;  ///< hmin >= 0, domain units.
  double size_max = 0;  ///< hmax >= 0, domain units; >= hmin if both are given.
  double anisotropy_max =
      0;  ///< Largest ratio of major to minor radius, >= 1; the minor radius is kept.

  friend constexpr bool operator==(const SizeBounds&, const SizeBounds&) = default;
};
/// m with its radii forced into the bounds, axes kept; m to the bit if they lie inside.
/// @pre IsPositiveDefinite(m); or m is any finite tensor and size_max > 0, which then stands in for
///      every eigenvalue that is too small, a negative one too.
[[nodiscard]] Metric Bound(const Metric& m, const SizeBounds& bounds);

/// What a tensor from outside asks for, bounds applied; nothing if it is no metric.
///
/// A metric is positive definite before and after it is bounded. With size_max > 0 a semi-definite
/// tensor (a Hessian where the solution is straight in one direction, or in all) is one too: it
/// gets size_max where it has no wish. An eigenvalue of -2^-40 times the other one or less in size
/// counts as 0, because differences of computed entries leave that much; a truly negative one is
/// refused, for no size belongs to it, and taking its absolute value is the sender's decision.
[[nodiscard]] std::optional<Metric> AdmitTensor(const Metric& raw, const SizeBounds& bounds);

}  // namespace pliant
