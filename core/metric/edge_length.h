#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/geometry/vec2.h"
#include "core/metric/metric.h"
#include "core/metric/metric_field.h"

namespace pliant {

/// Length of the segment pq measured in the metric field itself: the integral of
/// sqrt(e' M(x) e) over the segment, e = q - p, by 5-point Gauss-Legendre quadrature.
///
/// The measure that a mesh is judged by: unlike eq. 4 it sees what the metric does between the
/// ends. Exact for sqrt(e' M e) a polynomial of degree 9 along the segment; a jump of the metric
/// inside the segment costs an error of up to a tenth of the jump.
///
/// @param p, q  finite end points, in domain units.
/// @param hint  as for MetricField::At; the five questions follow each other along the segment.
/// @return length, dimensionless, >= 0; symmetric under swapping the ends up to rounding.
/// @par Cost    five evaluations of the field.
[[nodiscard]] double IntegratedLength(const MetricField& field, Vec2 p, Vec2 q, std::int32_t& hint);

/// Points at which IntegratedLength asks the field.
inline constexpr std::size_t kIntegrationPointCount = 5;

/// IntegratedLength for those who ask for many segments together: where it asks, from p to q...
[[nodiscard]] std::array<Vec2, kIntegrationPointCount> IntegrationPoints(Vec2 p, Vec2 q);

/// ...and the length, to the bit, that follows from the metrics there.
/// @param e  q - p
[[nodiscard]] double IntegratedLength(Vec2 e,
                                      std::span<const Metric, kIntegrationPointCount> metrics);

/// Length of the segment pq measured in a metric that varies from `mp` to `mq` along it.
///
/// The requested size is taken to vary geometrically along pq, h(t) = h_p^(1-t) h_q^t, so the
/// integral of |pq|/h(t) is the logarithmic mean of the lengths measured with the end metrics:
///
///     l = (l_p - l_q) / ln(l_p / l_q),   l_p = sqrt(e' M_p e),  e = q - p
///
/// @return length, dimensionless, >= 0; 0 only if p == q; the same bits when the ends are swapped.
/// @pre IsPositiveDefinite(mp) and (mq).
/// @par Accuracy  relative error < 1e-14 for l_p / l_q in [1e-6, 1e6]; a test pins it.
/// @par Cost      two square roots, and a logarithm if the lengths differ by more than 40 %.
/// @see [Alauzet2010]
[[nodiscard]] double GeometricLength(Vec2 p, const Metric& mp, Vec2 q, const Metric& mq);

}  // namespace pliant
