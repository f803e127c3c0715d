#include "core/metric/solution_metric.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>

#include "core/base/as_index.h"
#include "core/base/math.h"
#include "core/metric/hessian.h"

namespace pliant {
namespace {

constexpr double kExponentMax = 100;
/// Mean error of linear interpolation of a quadratic function over a unit triangle, over the trace
/// of M^-1 |H|: for H = M = I it is 1/2 (1/3 - 1/12) = 1/8.
constexpr double kUnitError = 1.0 / 16;
constexpr int kSweepsMax = 60;
constexpr double kComplexityTolerance = 1e-9;

double Power(double base, double exponent) { return Exp(exponent * Log(base)); }

/// The integral of exp(f), f linear on triangles with given values at points.
double IntegralOfExp(const MeshData& mesh, std::span<const double> exponents) {
  // Radon's rule: the centre and two triples of points.
  constexpr double kRoot15 = 3.872983346207416885179265399782400;
  constexpr std::array kNear{(6 - kRoot15) / 21, (6 + kRoot15) / 21};
  constexpr std::array kWeights{(155 - kRoot15) / 1200, (155 + kRoot15) / 1200};
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const std::array<double, 3> f{exponents[AsIndex(a)], exponents[AsIndex(b)],
                                  exponents[AsIndex(c)]};
    const double total = f[0] + f[1] + f[2];
    double mean = 9.0 / 40 * Exp(total / 3);
    for (std::size_t k = 0; k < 2; ++k) {
      for (const double own : f) {
        mean += kWeights[k] * Exp(kNear[k] * (total - own) + (1 - 2 * kNear[k]) * own);
      }
    }
    const Vec2 p = mesh.points[AsIndex(a)];
    sum += 0.5 * Cross(mesh.points[AsIndex(b)] - p, mesh.points[AsIndex(c)] - p) * mean;
  }
  return sum;
}

double DiameterOf(const MeshData& mesh) {
  Vec2 low = mesh.points.front();
  Vec2 high = low;
  for (const Vec2 p : mesh.points) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  return Length(high - low);
}

/// |H| with its floor.
std::vector<Metric> Curvatures(const MeshData& mesh, std::span<const double> values,
                               double calm_share) {
  const auto [low, high] = std::ranges::minmax(values);
  const double diameter = DiameterOf(mesh);
  // A constant field has no unit: any multiple of the identity will do.
  const double range = high > low ? high - low : 1;
  const double floor = calm_share * range / (diameter * diameter);
  std::vector<Metric> curvatures = RecoverHessians(mesh, values);
  for (Metric& curvature : curvatures) {
    curvature = Bound(AbsoluteValue(curvature), {.size_max = 1 / std::sqrt(floor)});
  }
  return curvatures;
}

/// The optimal metric of one field.
std::vector<Metric> MetricOfField(const MeshData& mesh, std::span<const double> values,
                                  const SolutionTarget& target) {
  const double p = target.norm_exponent;
  std::vector<Metric> metric = Curvatures(mesh, values, target.calm_share);
  // sqrt(det) of det^(-1/(2p+2)) |H| is det^(p/(2p+2)), so its complexity is also the integral that
  // the error needs.
  std::vector<double> exponents;
  for (Metric& tensor : metric) {
    const double log_determinant = Log(Determinant(tensor));
    exponents.push_back(p / (2 * p + 2) * log_determinant);
    tensor = Exp(-log_determinant / (2 * p + 2)) * tensor;
  }
  const double integral = IntegralOfExp(mesh, exponents);
  double factor = 0;
  if (const auto* complexity = std::get_if<TargetComplexity>(&target.target)) {
    factor = complexity->complexity / integral;
  } else {
    const double area = IntegralOfExp(mesh, std::vector<double>(mesh.points.size(), 0.0));
    const double error = std::get<TargetError>(target.target).error;
    factor = 2 * kUnitError * Power(integral / area, 1 / p) / error;
  }
  for (Metric& tensor : metric) tensor = factor * tensor;
  return metric;
}

std::vector<Metric> ScaledAndBounded(std::span<const Metric> metric, double factor,
                                     const SizeBounds& bounds) {
  std::vector<Metric> result;
  result.reserve(metric.size());
  for (const Metric& tensor : metric) result.push_back(Bound(factor * tensor, bounds));
  return result;
}

Error RefuseSolution(ErrorCode code, const char* field, const std::string& message) {
  return {code, message, std::string("metric.solution") + field};
}

Status CheckSolution(const MeshData& mesh, std::span<const std::vector<double>> fields,
                     const SolutionTarget& target) {
  if (fields.empty() || mesh.triangles.empty()) {
    return RefuseSolution(ErrorCode::kEmpty, ".field",
                          "a metric of a solution needs a field and a mesh");
  }
  for (std::size_t k = 0; k < fields.size(); ++k) {
    if (fields[k].size() != mesh.points.size()) {
      return RefuseSolution(ErrorCode::kArrayLength, ".field",
                            "field " + std::to_string(k) + " has " +
                                std::to_string(fields[k].size()) + " values for " +
                                std::to_string(mesh.points.size()) + " points");
    }
    for (std::size_t i = 0; i < fields[k].size(); ++i) {
      if (std::isfinite(fields[k][i])) continue;
      Error error = RefuseSolution(
          ErrorCode::kNotFinite, ".field",
          "value " + std::to_string(i) + " of field " + std::to_string(k) + " is NaN or infinite");
      error.index = static_cast<std::int64_t>(i);
      error.other_index = static_cast<std::int64_t>(k);
      return error;
    }
  }
  if (!(target.norm_exponent >= 1 && target.norm_exponent <= kExponentMax)) {
    return RefuseSolution(ErrorCode::kOutOfRange, ".norm_exponent",
                          "the exponent of the norm is " + std::to_string(target.norm_exponent) +
                              "; expected 1 to 100");
  }
  if (!(target.calm_share > 0 && target.calm_share <= 1)) {
    return RefuseSolution(ErrorCode::kOutOfRange, ".calm_share", "expected a share in (0, 1]");
  }
  const auto* complexity = std::get_if<TargetComplexity>(&target.target);
  const double wanted =
      complexity != nullptr ? complexity->complexity : std::get<TargetError>(target.target).error;
  if (!(wanted > 0) || !std::isfinite(wanted)) {
    return RefuseSolution(
        ErrorCode::kOutOfRange, complexity != nullptr ? ".complexity" : ".error",
        "the target is " + std::to_string(wanted) + "; expected a positive number");
  }
  return {};
}

}  // namespace

Result<std::vector<Metric>> MetricOfSolution(const MeshData& mesh,
                                             std::span<const std::vector<double>> fields,
                                             const SolutionTarget& target) {
  PLIANT_RETURN_IF_ERROR(CheckSolution(mesh, fields, target));
  std::vector<Metric> metric = MetricOfField(mesh, fields[0], target);
  for (std::size_t k = 1; k < fields.size(); ++k) {
    const std::vector<Metric> other = MetricOfField(mesh, fields[k], target);
    for (std::size_t i = 0; i < metric.size(); ++i) metric[i] = Intersect(metric[i], other[i]);
  }
  std::vector<Metric> result = ScaledAndBounded(metric, 1, target.bounds);
  const auto* wanted = std::get_if<TargetComplexity>(&target.target);
  if (wanted == nullptr) return result;
  // Complexity grows with the factor, at most in proportion, so that this approaches it from one
  // side; where all tensors have met a bound it can grow no further.
  double factor = 1;
  double last = 0;
  for (int sweep = 0; sweep < kSweepsMax; ++sweep) {
    const double complexity = ComplexityOf(mesh, result);
    const double ratio = wanted->complexity / complexity;
    if (std::fabs(ratio - 1) <= kComplexityTolerance || complexity == last) break;
    last = complexity;
    factor *= ratio;
    result = ScaledAndBounded(metric, factor, target.bounds);
  }
  return result;
}

double ComplexityOf(const MeshData& mesh, std::span<const Metric> tensors) {
  std::vector<double> exponents;
  exponents.reserve(tensors.size());
  for (const Metric& tensor : tensors) exponents.push_back(0.5 * Log(Determinant(tensor)));
  return IntegralOfExp(mesh, exponents);
}

}  // namespace pliant
