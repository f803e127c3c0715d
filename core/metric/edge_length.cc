#include "core/metric/edge_length.h"

#include <array>
#include <cmath>
#include <utility>

#include "core/base/math.h"

namespace pliant {

namespace {

// The roots of the Legendre polynomial of degree 5 moved to [0, 1], and their weights.
struct Node {
  double position;
  double weight;
};
constexpr std::array<Node, kIntegrationPointCount> kNodes = {{
    {0.04691007703066800, 0.11846344252809454},
    {0.23076534494715845, 0.23931433524968324},
    {0.5, 0.28444444444444444},
    {0.76923465505284155, 0.23931433524968324},
    {0.95308992296933200, 0.11846344252809454},
}};

}  // namespace

double IntegratedLength(const MetricField& field, Vec2 p, Vec2 q, std::int32_t& hint) {
  std::array<Metric, kIntegrationPointCount> metrics;
  std::array<std::int32_t, kIntegrationPointCount> hints;
  hints.fill(MetricField::kNoHint);
  hints.front() = hint;
  field.AtEach(IntegrationPoints(p, q), hints, metrics);
  hint = hints.back();
  return IntegratedLength(q - p, metrics);
}

std::array<Vec2, kIntegrationPointCount> IntegrationPoints(Vec2 p, Vec2 q) {
  const Vec2 e = q - p;
  std::array<Vec2, kIntegrationPointCount> points;
  for (std::size_t i = 0; i < points.size(); ++i) points[i] = p + kNodes[i].position * e;
  return points;
}

double IntegratedLength(Vec2 e, std::span<const Metric, kIntegrationPointCount> metrics) {
  double length = 0;
  for (std::size_t i = 0; i < metrics.size(); ++i) {
    length += kNodes[i].weight * std::sqrt(SquaredLength(metrics[i], e));
  }
  return length;
}

double GeometricLength(Vec2 p, const Metric& mp, Vec2 q, const Metric& mq) {
  const Vec2 e = q - p;
  double longer = std::sqrt(SquaredLength(mp, e));
  double shorter = std::sqrt(SquaredLength(mq, e));
  if (longer < shorter) std::swap(longer, shorter);
  if (shorter == 0) return 0;
  const double sum = longer + shorter;
  const double difference = longer - shorter;
  // ln(l_p / l_q) = 2 atanh(z) with z = difference / sum. For small z its series is used, in which
  // the difference cancels out of the quotient: equal lengths need no special case.
  const double z = difference / sum;
  if (z > 1.0 / 6) return difference / Log(longer / shorter);
  const double w = z * z;
  const double series =
      1 +
      w * (1.0 / 3 +
           w * (1.0 / 5 +
                w * (1.0 / 7 + w * (1.0 / 9 + w * (1.0 / 11 +
                                                   w * (1.0 / 13 +
                                                        w * (1.0 / 15 +
                                                             w * (1.0 / 17 + w * (1.0 / 19)))))))));
  return 0.5 * sum / series;
}

}  // namespace pliant
