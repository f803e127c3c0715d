#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/geometry/vec2.h"
#include "core/metric/metric.h"

namespace pliant {

// The formulas of core/metric/gradation.h, one edge at a time. Only + - * / and sqrt, and each the
// same bits for an edge vector and its opposite: so the limited metric does not depend on the
// order of work. Apart from the solver, so that the tests can solve them in another way.

/// The direction of an axis by its double angle (cos 2a, sin 2a): the same for a vector and its
/// opposite, and comparing two of them needs no trigonometry.
struct AxisFrame {
  double c = 1;
  double s = 0;

  friend constexpr bool operator==(const AxisFrame&, const AxisFrame&) = default;
};

/// A metric by its two sizes, in domain units.
struct AxisSizes {
  double thin = 1;  ///< Wanted length across: the smaller one.
  double wide = 1;  ///< Wanted length along: thin or more.
  AxisFrame frame;  ///< Of the direction across, in which `thin` holds.

  friend constexpr bool operator==(const AxisSizes&, const AxisSizes&) = default;
};

/// How fast things may change.
struct GradationRates {
  double growth = 0;    ///< ln(gradation): largest increase of a size over a distance, per length.
  double rotation = 0;  ///< C of RotationLimit.
};

/// sin^2 of the angle between two axes.
[[nodiscard]] inline double SquaredSine(AxisFrame a, AxisFrame b) {
  const double c = a.c - b.c;
  const double s = a.s - b.s;
  return 0.25 * (c * c + s * s);
}

/// The squared components of e along the axis and across it. A frame of (0, 0) has no direction
/// and gives each a half.
struct SquaredComponents {
  double along;
  double across;
};
[[nodiscard]] inline SquaredComponents Split(Vec2 e, AxisFrame frame) {
  const double squared = e.x * e.x + e.y * e.y;
  const double z = (e.x * e.x - e.y * e.y) * frame.c + 2 * (e.x * e.y) * frame.s;
  // Rounding must not make a square negative.
  const double along = 0.5 * (squared + z);
  const double across = 0.5 * (squared - z);
  return {along > 0 ? along : 0, across > 0 ? across : 0};
}

/// The size that `size` may have grown to over a squared distance; more than `size` even where the
/// sum rounds to it, so that "may be reached from" is a strict order.
[[nodiscard]] inline double Grow(double size, double growth, double squared_distance) {
  const double grown = size + growth * std::sqrt(squared_distance);
  const double next = std::bit_cast<double>(std::bit_cast<std::uint64_t>(size) + 1);
  return grown > next ? grown : next;
}

/// Thin size allowed at distance e from p: distances across count in full, those along an
/// anisotropic p by the ratio of its sizes, as they would in its metric.
[[nodiscard]] inline double ThinLimit(const AxisSizes& p, Vec2 e, double growth) {
  const SquaredComponents part = Split(e, p.frame);
  const double ratio = p.thin / p.wide;
  return Grow(p.thin, growth, part.along + part.across * (ratio * ratio));
}

/// Wide size allowed at distance e from p.
[[nodiscard]] inline double WideLimit(const AxisSizes& p, Vec2 e, double growth) {
  const SquaredComponents part = Split(e, p.frame);
  const double ratio = p.wide / p.thin;
  return Grow(p.wide, growth, part.across + part.along * (ratio * ratio));
}

/// The largest wide size of p beside q, if the axes turn between them: a long element must not
/// leave the thin layer that turns away under it. Infinite if the axes agree or q is isotropic.
///
/// With k^2 = sin^2(angle) (1/thin_q^2 - 1/wide_q^2) the limit h solves k h = C l(h), where l(h) is
/// the length of e in a metric of wide size h and of the mean frame. It is never stricter than
/// growth from q's thin size over the turn.
[[nodiscard]] inline double RotationLimit(const AxisSizes& p, const AxisSizes& q, Vec2 e,
                                          GradationRates rates) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  if (rates.rotation == 0) return kInfinity;
  const double sine2 = SquaredSine(p.frame, q.frame);
  const double k2 = sine2 * (1 / (q.thin * q.thin) - 1 / (q.wide * q.wide));
  if (!(k2 > 0)) return kInfinity;
  // The mean frame, in which each counts by how anisotropic it is.
  const double weight_p = 1 - p.thin / p.wide;
  const double weight_q = 1 - q.thin / q.wide;
  AxisFrame mean = {weight_p * p.frame.c + weight_q * q.frame.c,
                    weight_p * p.frame.s + weight_q * q.frame.s};
  const double norm = std::sqrt(mean.c * mean.c + mean.s * mean.s);
  if (norm > 0) mean = {mean.c / norm, mean.s / norm};
  const SquaredComponents part = Split(e, mean);
  const double thin = 0.5 * (p.thin + q.thin);
  const double c2 = rates.rotation * rates.rotation;
  const double a = c2 * part.along / (thin * thin);
  const double root = std::sqrt(a * a + 4 * (k2 * (c2 * part.across)));
  const double limit = std::sqrt((a + root) / (2 * k2));
  const double floor = q.thin + rates.growth * std::sqrt((e.x * e.x + e.y * e.y) * sine2);
  return limit > floor ? limit : floor;
}

/// The wide size with which `raw`, made as thin as `thin` in another frame, still is at least as
/// fine as before in every direction. @pre thin < raw.thin
[[nodiscard]] inline double WideInFrame(const AxisSizes& raw, AxisFrame frame, double thin) {
  const double high = 1 / (raw.thin * raw.thin);
  const double low = 1 / (raw.wide * raw.wide);
  const double sine2 = SquaredSine(raw.frame, frame);
  const double turned = (high - low) * sine2;
  if (turned == 0) return raw.wide;
  // diag(1/thin^2, x) - raw is positive semi-definite from this x on: the Schur complement.
  const double x =
      (low + turned) + turned * (high - low) * (1 - sine2) / (1 / (thin * thin) - high + turned);
  return 1 / std::sqrt(x);
}

/// The sizes and axes of a tensor. @pre IsPositiveDefinite(m)
[[nodiscard]] AxisSizes SizesFromMetric(const Metric& m);

/// The largest ratio, over all directions, of the size in `raw` to that in `limited`.
[[nodiscard]] double SizeRatio(const AxisSizes& raw, const AxisSizes& limited);

/// The inverse of SizesFromMetric, up to rounding.
[[nodiscard]] Metric MetricFromSizes(const AxisSizes& sizes);

}  // namespace pliant
