#include "core/pliant/smooth.h"

#include <algorithm>
#include <cmath>

#include "core/base/math.h"

namespace pliant {
namespace {

/// Beyond this distance exp(-d^4) is below 1e-100 and ExpNegative out of its range.
constexpr double kPliantReach = 4;

/// (1 - d^4) exp(-d^4), from d^4.
double PliantForce(double d4) { return (1 - d4) * ExpNegative(-d4); }

}  // namespace

double SmoothingForce(Smoothing smoothing, double d) {
  switch (smoothing) {
    case Smoothing::kPliant:
      return d < kPliantReach ? PliantForce(d * d * d * d) : 0;
    case Smoothing::kLaplacian:
      return -d;
    case Smoothing::kLennardJones: {
      const double inverse = 1 / d;
      const double cube = inverse * inverse * inverse;
      const double seventh = cube * cube * inverse;
      // Unstable near 0, where it grows without bound: no more than one wanted length.
      return std::clamp(seventh * cube * cube - seventh, -1.0, 1.0);
    }
    case Smoothing::kBubble:
      return d < 1.5 ? (1.25 * d - 2.375) * d * d + 1.125 : 0;
  }
  return 0;
}

Vec2 SmoothingStep(const Mesh& mesh, VertexId node, std::span<const VertexId> neighbors,
                   Smoothing smoothing, double alpha, std::span<const double> weights) {
  const Vec2 p = mesh.position(node);
  const Metric& m = mesh.metric(node);
  Vec2 sum;
  for (std::size_t k = 0; k < neighbors.size(); ++k) {
    const VertexRecord& other = mesh.vertex(neighbors[k]);
    const Vec2 e = p - other.position;
    const double squared = SquaredLength(0.5 * (m + other.metric), e);
    if (smoothing == Smoothing::kPliant) {  // The hot case, with one square root less in d^4.
      if (squared >= kPliantReach * kPliantReach) continue;
      const Vec2 force = (PliantForce(squared * squared) / std::sqrt(squared)) * e;
      sum += weights.empty() ? force : weights[k] * force;
    } else {
      const double d = std::sqrt(squared);
      sum += (SmoothingForce(smoothing, d) / d) * e;
    }
  }
  if (smoothing == Smoothing::kLaplacian) alpha = 1 / static_cast<double>(neighbors.size());
  return alpha * sum;
}

}  // namespace pliant
