#include "core/metric/gradation_rule.h"

#include <algorithm>

namespace pliant {

AxisSizes SizesFromMetric(const Metric& m) {
  const Eigenvalues eigenvalues = EigenvaluesOf(m);
  const double thin = 1 / std::sqrt(eigenvalues.high);
  const double wide = std::max(thin, 1 / std::sqrt(eigenvalues.low));
  const double d = 0.5 * (m.m11 - m.m22);
  const double radius = std::sqrt(d * d + m.m12 * m.m12);
  if (radius == 0) return {thin, wide, {}};
  return {thin, wide, {d / radius, m.m12 / radius}};
}

Metric MetricFromSizes(const AxisSizes& sizes) {
  const double high = 1 / (sizes.thin * sizes.thin);
  const double low = 1 / (sizes.wide * sizes.wide);
  // cos^2 = (1 + c) / 2 and sin^2 = (1 - c) / 2, the one that would cancel from the other.
  const auto [c, s] = sizes.frame;
  const double big = 0.5 * (1 + std::abs(c));
  const double small = s * s / (4 * big);
  const double cosine2 = c >= 0 ? big : small;
  const double sine2 = c >= 0 ? small : big;
  return {high * cosine2 + low * sine2, 0.5 * (high - low) * s, high * sine2 + low * cosine2};
}

double SizeRatio(const AxisSizes& raw, const AxisSizes& limited) {
  // In raw's axes, scaled by raw's sizes, the limited metric is [a b; b c].
  const double high = 1 / (limited.thin * limited.thin);
  const double low = 1 / (limited.wide * limited.wide);
  const double sine2 = SquaredSine(raw.frame, limited.frame);
  const double a = raw.thin * raw.thin * (high + (low - high) * sine2);
  const double c = raw.wide * raw.wide * (low + (high - low) * sine2);
  const double b2 = raw.thin * raw.thin * (raw.wide * raw.wide) * ((high - low) * (high - low)) *
                    (sine2 * (1 - sine2));
  const double d = 0.5 * (a - c);
  return std::sqrt(0.5 * (a + c) + std::sqrt(d * d + std::max(b2, 0.0)));
}

}  // namespace pliant
