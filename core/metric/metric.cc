#include "core/metric/metric.h"

#include <algorithm>
#include <array>
#include <limits>

#include "core/base/check.h"
#include "core/base/math.h"
#include "core/base/vector_kernel.h"

namespace pliant {
namespace {

/// A symmetric matrix by its eigenvalues, low <= high, and the projector P on the eigenvector of
/// `high`: the matrix is high P + low (I - P). The projector needs one square root less than the
/// eigenvector and has no sign to choose.
struct Spectrum {
  double low;
  double high;
  double p11;
  double p12;
  double p22;
};

/// ab - cd with one rounding's error even where the products cancel, by Kahan's method. std::fma
/// is exactly rounded by definition, in hardware or in software: the same bits everywhere.
PLIANT_PART_OF_KERNEL inline double DifferenceOfProducts(double a, double b, double c, double d) {
  const double cd = c * d;
  const double rounding = std::fma(-c, d, cd);
  return std::fma(a, b, -cd) + rounding;
}

PLIANT_PART_OF_KERNEL inline double AccurateDeterminant(const Metric& m) {
  return DifferenceOfProducts(m.m11, m.m22, m.m12, m.m12);
}

/// Eigenvalues as mean -+ radius; the smaller in size of the two may be inaccurate.
PLIANT_PART_OF_KERNEL inline Spectrum SpectrumOf(double a11, double a12, double a22) {
  const double mean = 0.5 * (a11 + a22);
  const double d = 0.5 * (a11 - a22);
  const double radius = std::sqrt(d * d + a12 * a12);
  // P = (I + [d a12; a12 -d] / radius) / 2. The small diagonal entry is computed as
  // a12^2 / (2 radius (radius + |d|)), which does not cancel. Where the radius is 0 it is [0 0; 0
  // 1]; without a branch, for loops that become vector code.
  const double sum = radius + std::abs(d);
  const double big = radius == 0 ? 1 : sum / (2 * radius);
  const double small = radius == 0 ? 0 : (a12 / sum) * (a12 / (2 * radius));
  const double p12 = radius == 0 ? 0 : a12 / (2 * radius);
  const double p11 = d > 0 ? big : small;
  const double p22 = d > 0 ? small : big;
  return {mean - radius, mean + radius, p11, p12, p22};
}

/// As above for a positive definite tensor: both eigenvalues are accurate, because the small one
/// is the determinant divided by the large one.
PLIANT_PART_OF_KERNEL inline Spectrum SpectrumOf(const Metric& m) {
  Spectrum spectrum = SpectrumOf(m.m11, m.m12, m.m22);
  if (spectrum.low != spectrum.high) spectrum.low = AccurateDeterminant(m) / spectrum.high;
  return spectrum;
}

/// The matrix with the axes of `axes` and the given eigenvalues. Never called with low > high by
/// more than rounding; the diagonal is a sum of non-negative terms and so stays accurate.
PLIANT_PART_OF_KERNEL inline Metric Compose(const Spectrum& axes, double low, double high) {
  return {high * axes.p11 + low * axes.p22, (high - low) * axes.p12,
          high * axes.p22 + low * axes.p11};
}

/// So many tensors are worked on together.
constexpr std::size_t kMetricsAtOnce = 64;

/// The entries of as many symmetric matrices.
struct Columns {
  std::array<double, kMetricsAtOnce> a11;
  std::array<double, kMetricsAtOnce> a12;
  std::array<double, kMetricsAtOnce> a22;
};

/// What a kernel made of such matrices, and their eigenvalues, by which the results are judged.
struct ResultColumns : Columns {
  std::array<double, kMetricsAtOnce> low;
  std::array<double, kMetricsAtOnce> high;
};

/// The same operations as Log, for matrices whose eigenvalues are normal numbers.
PLIANT_FMA_KERNEL
void RunLogKernel(const Columns& in, std::size_t count, ResultColumns& out) {
  PLIANT_INDEPENDENT
  for (std::size_t k = 0; k < count; ++k) {
    const Spectrum spectrum = SpectrumOf(Metric{in.a11[k], in.a12[k], in.a22[k]});
    const Metric log = Compose(spectrum, LogOfNormal(spectrum.low), LogOfNormal(spectrum.high));
    out.low[k] = spectrum.low;
    out.high[k] = spectrum.high;
    out.a11[k] = log.m11;
    out.a12[k] = log.m12;
    out.a22[k] = log.m22;
  }
}

/// And as Exp, for those whose eigenvalues are at most kModerate in size.
PLIANT_VECTOR_KERNEL
void RunExpKernel(const Columns& in, std::size_t count, ResultColumns& out) {
  PLIANT_INDEPENDENT
  for (std::size_t k = 0; k < count; ++k) {
    const Spectrum spectrum = SpectrumOf(in.a11[k], in.a12[k], in.a22[k]);
    const Metric exp = Compose(spectrum, ExpOfModerate(spectrum.low), ExpOfModerate(spectrum.high));
    out.low[k] = spectrum.low;
    out.high[k] = spectrum.high;
    out.a11[k] = exp.m11;
    out.a12[k] = exp.m12;
    out.a22[k] = exp.m22;
  }
}

constexpr double kModerate = 700;

/// Runs a kernel on matrices, a block of columns at a time.
/// @param holds  whether its result for these eigenvalues, low and high, does
/// @param one    computes a single one where it does not
template <class In, class Out, class Kernel, class Holds, class One>
void RunInBlocks(std::span<const In> ins, std::span<Out> outs, Kernel kernel, Holds holds,
                 One one) {
  PLIANT_CHECK(ins.size() == outs.size());
  Columns in;
  ResultColumns out;
  for (std::size_t begin = 0; begin < ins.size(); begin += kMetricsAtOnce) {
    const std::size_t count = std::min(kMetricsAtOnce, ins.size() - begin);
    for (std::size_t k = 0; k < count; ++k) {
      const auto& [a11, a12, a22] = ins[begin + k];
      in.a11[k] = a11;
      in.a12[k] = a12;
      in.a22[k] = a22;
    }
    kernel(in, count, out);
    for (std::size_t k = 0; k < count; ++k) {
      outs[begin + k] = holds(out.low[k], out.high[k]) ? Out{out.a11[k], out.a12[k], out.a22[k]}
                                                       : one(ins[begin + k]);
    }
  }
}

bool BoundsNothing(const SizeBounds& bounds) {
  return bounds.size_max <= 0 && bounds.size_min <= 0 && bounds.anisotropy_max <= 0;
}

}  // namespace

bool IsPositiveDefinite(const Metric& m) {
  // Squares of entries must neither overflow nor vanish; written so that NaN fails.
  constexpr double kEntryMin = 1e-150;
  constexpr double kEntryMax = 1e150;
  if (!(m.m11 >= kEntryMin && m.m11 <= kEntryMax)) return false;
  if (!(m.m22 >= kEntryMin && m.m22 <= kEntryMax)) return false;
  // The rounded determinant is what areas use, the accurate one what eigenvalues use.
  return Determinant(m) >= std::numeric_limits<double>::min() && AccurateDeterminant(m) > 0;
}

Metric MetricFromAxes(const MetricAxes& axes) {
  const double low = 1 / (axes.major_radius * axes.major_radius);
  const double high = 1 / (axes.minor_radius * axes.minor_radius);
  const auto [c, s] = axes.major_direction;
  return {low * (c * c) + high * (s * s), (low - high) * (c * s), low * (s * s) + high * (c * c)};
}

MetricAxes AxesFromMetric(const Metric& m) {
  const Spectrum spectrum = SpectrumOf(m);
  MetricAxes axes;
  axes.major_radius = 1 / std::sqrt(spectrum.low);
  axes.minor_radius = 1 / std::sqrt(spectrum.high);
  // The major axis is the eigenvector of `low`, whose projector is I - P.
  if (spectrum.p22 >= spectrum.p11) {
    const double c = std::sqrt(spectrum.p22);
    axes.major_direction = {c, -spectrum.p12 / c};
  } else {
    const double s = std::sqrt(spectrum.p11);
    const double c = -spectrum.p12 / s;
    axes.major_direction = c < 0 ? Vec2{-c, -s} : Vec2{c, s};
  }
  return axes;
}

Eigenvalues EigenvaluesOf(const Metric& m) {
  const Spectrum plain = SpectrumOf(m.m11, m.m12, m.m22);
  // Divide by the eigenvalue of the larger size; the trace tells which it is.
  const double det = AccurateDeterminant(m);
  if (plain.high > 0 && plain.high >= -plain.low) return {det / plain.high, plain.high};
  if (plain.low < 0) return {plain.low, det / plain.low};
  return {plain.low, plain.high};
}

LogMetric Log(const Metric& m) {
  const Spectrum spectrum = SpectrumOf(m);
  const Metric log = Compose(spectrum, Log(spectrum.low), Log(spectrum.high));
  return {log.m11, log.m12, log.m22};
}

Metric Exp(const LogMetric& l) {
  const Spectrum spectrum = SpectrumOf(l.l11, l.l12, l.l22);
  return Compose(spectrum, Exp(spectrum.low), Exp(spectrum.high));
}

void LogEach(std::span<const Metric> metrics, std::span<LogMetric> logs) {
  const auto is_normal = [](double low, double high) {
    return low >= std::numeric_limits<double>::min() && high <= std::numeric_limits<double>::max();
  };
  RunInBlocks(metrics, logs, RunLogKernel, is_normal, [](const Metric& m) { return Log(m); });
}

void ExpEach(std::span<const LogMetric> logs, std::span<Metric> metrics) {
  const auto is_moderate = [](double low, double high) {
    return low >= -kModerate && high <= kModerate;
  };
  RunInBlocks(logs, metrics, RunExpKernel, is_moderate, [](const LogMetric& l) { return Exp(l); });
}

double LogDistance(const LogMetric& a, const LogMetric& b) {
  const double d11 = a.l11 - b.l11;
  const double d12 = a.l12 - b.l12;
  const double d22 = a.l22 - b.l22;
  return std::sqrt(d11 * d11 + 2 * d12 * d12 + d22 * d22);
}

Metric GeometricMean(const Metric& a, const Metric& b) {
  const double root_a = std::sqrt(Determinant(a));
  const double root_b = std::sqrt(Determinant(b));
  const Metric sum = root_b * a + root_a * b;
  const Metric mean = std::sqrt(root_a * root_b / Determinant(sum)) * sum;
  return IsPositiveDefinite(mean) ? mean : 0.5 * (a + b);
}

Metric LogEuclideanMean(const Metric& a, const Metric& b, double t) {
  return Exp((1 - t) * Log(a) + t * Log(b));
}

Metric Intersect(const Metric& a, const Metric& b) {
  // With the Cholesky factor a = L L', the matrix c = L^-1 b L^-T is what b looks like where a is
  // the identity. Raising its eigenvalues to at least 1 and going back gives the intersection, as
  // a plus a positive term for each eigenvalue beyond 1: so rounding cannot lose a.
  const double l11 = std::sqrt(a.m11);
  const double l21 = a.m12 / l11;
  const double l22 = std::sqrt(AccurateDeterminant(a) / a.m11);
  const double c11 = b.m11 / a.m11;
  const double c12 = (b.m12 - l21 * (b.m11 / l11)) / (l11 * l22);
  const double k = l21 / l11;
  const double c22 = ((b.m22 - k * b.m12) - k * (b.m12 - k * b.m11)) / (l22 * l22);

  Spectrum c = SpectrumOf(c11, c12, c22);
  c.low = AccurateDeterminant(b) / AccurateDeterminant(a) / c.high;
  if (c.low >= 1) return b;
  if (!(c.high > 1)) return a;
  // Only one eigenvalue exceeds 1: add (high - 1) L P L'.
  const double excess = c.high - 1;
  const double w1 = l11 * c.p11;
  const double w2 = l21 * c.p11 + l22 * c.p12;
  const double v2 = l21 * c.p12 + l22 * c.p22;
  return {a.m11 + excess * (w1 * l11), a.m12 + excess * (w2 * l11),
          a.m22 + excess * (w2 * l21 + v2 * l22)};
}

Metric Bound(const Metric& m, const SizeBounds& bounds) {
  if (BoundsNothing(bounds)) return m;
  const Spectrum axes = SpectrumOf(m.m11, m.m12, m.m22);
  const Eigenvalues raw = EigenvaluesOf(m);
  double high = raw.high;
  double low = raw.low;
  // Sizes are inverse square roots of eigenvalues: the largest size bounds them from below.
  if (bounds.size_max > 0) {
    const double floor = 1 / (bounds.size_max * bounds.size_max);
    high = std::max(high, floor);
    low = std::max(low, floor);
  }
  if (bounds.size_min > 0) {
    const double ceiling = 1 / (bounds.size_min * bounds.size_min);
    high = std::min(high, ceiling);
    low = std::min(low, ceiling);
  }
  if (bounds.anisotropy_max > 0) {
    low = std::max(low, high / (bounds.anisotropy_max * bounds.anisotropy_max));
  }
  if (low == raw.low && high == raw.high) return m;
  return Compose(axes, low, high);
}

std::optional<Metric> AdmitTensor(const Metric& raw, const SizeBounds& bounds) {
  constexpr double kEntryMax = 1e150;
  constexpr double kZeroShare = 0x1p-40;
  const auto is_measurable = [&](double entry) { return std::abs(entry) <= kEntryMax; };
  if (!is_measurable(raw.m11) || !is_measurable(raw.m12) || !is_measurable(raw.m22)) return {};
  if (IsPositiveDefinite(raw)) {
    if (BoundsNothing(bounds)) return raw;
  } else {
    const Eigenvalues eigenvalues = EigenvaluesOf(raw);
    const bool is_semi_definite =
        eigenvalues.high >= 0 && eigenvalues.low >= -kZeroShare * eigenvalues.high;
    if (!is_semi_definite || bounds.size_max <= 0) return {};
  }
  const Metric bounded = Bound(raw, bounds);
  if (!IsPositiveDefinite(bounded)) return {};
  return bounded;
}

double RelativeChange(const Metric& old, const Metric& now) {
  const double determinant = Determinant(old);
  const double mean =
      (old.m22 * now.m11 - 2 * old.m12 * now.m12 + old.m11 * now.m22) / (2 * determinant);
  const double product = Determinant(now) / determinant;
  const double radius = std::sqrt(std::max(0.0, mean * mean - product));
  return std::max(std::fabs(mean + radius - 1), std::fabs(mean - radius - 1));
}

}  // namespace pliant
