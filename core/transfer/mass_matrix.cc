#include "core/transfer/mass_matrix.h"

namespace pliant {
namespace {

/// 3^-36 is below 2^-53.
constexpr int kIterations = 36;

}  // namespace

void MassMatrix::AddTriangle(const std::array<std::int32_t, 3>& corners, double area) {
  if (!(area > 0)) return;
  elements_.push_back({corners, area});
  for (const std::int32_t corner : corners) {
    if (corner < 0) continue;
    diagonal_[static_cast<std::size_t>(corner)] += area / 6;
    lumped_[static_cast<std::size_t>(corner)] += area / 3;
  }
}

std::vector<double> MassMatrix::Solve(std::span<const double> b) const {
  constexpr double kCenter = 1.25;  // Of the spectrum, and its half width.
  constexpr double kRadius = 0.75;
  constexpr double kSigma = kCenter / kRadius;
  const std::size_t count = diagonal_.size();
  std::vector<double> x(count, 0.0);
  std::vector<double> residual(b.begin(), b.end());
  std::vector<double> step(count);
  // An unknown without area stays 0: nothing can be asked of it.
  std::vector<double> scale(count);
  for (std::size_t i = 0; i < count; ++i) scale[i] = diagonal_[i] > 0 ? 1 / diagonal_[i] : 0;
  for (std::size_t i = 0; i < count; ++i) step[i] = residual[i] * scale[i] / kCenter;
  double rho = 1 / kSigma;
  for (int k = 0; k < kIterations; ++k) {
    for (std::size_t i = 0; i < count; ++i) x[i] += step[i];
    SubtractProduct(step, residual);
    const double next = 1 / (2 * kSigma - rho);
    for (std::size_t i = 0; i < count; ++i) {
      step[i] = next * rho * step[i] + 2 * next / kRadius * (residual[i] * scale[i]);
    }
    rho = next;
  }
  return x;
}

void MassMatrix::SubtractProduct(std::span<const double> x, std::span<double> result) const {
  for (const Element& element : elements_) {
    double sum = 0;
    for (const std::int32_t corner : element.corners) {
      if (corner >= 0) sum += x[static_cast<std::size_t>(corner)];
    }
    for (const std::int32_t corner : element.corners) {
      if (corner < 0) continue;
      const auto i = static_cast<std::size_t>(corner);
      result[i] -= element.area / 12 * (x[i] + sum);
    }
  }
}

}  // namespace pliant
