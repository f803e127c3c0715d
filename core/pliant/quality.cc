#include "core/pliant/quality.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/metric/edge_length.h"
#include "core/metric/metric.h"

namespace pliant {
namespace {

/// Cosines of the borders between the angle bins, by rotation through 3 degrees: no libm, so that
/// a histogram has the same counts everywhere.
std::array<double, 61> BinCosines() {
  constexpr Vec2 kThreeDegrees{0.99862953475457387378, 0.05233595624294383272};
  std::array<double, 61> cosines{};
  Vec2 direction{1, 0};
  for (double& cosine : cosines) {
    cosine = direction.x;
    direction = {direction.x * kThreeDegrees.x - direction.y * kThreeDegrees.y,
                 direction.x * kThreeDegrees.y + direction.y * kThreeDegrees.x};
  }
  return cosines;
}

/// Accumulates one way of measuring lengths.
class LengthMeter {
 public:
  void Add(double length) {
    sum_ += length;
    min_ = count_ == 0 ? length : std::min(min_, length);
    max_ = count_ == 0 ? length : std::max(max_, length);
    sqrt2_count_ += length >= kSqrtHalf && length <= kSqrt2 ? 1 : 0;
    count_125_ += length >= 0.8 && length <= 1.25 ? 1 : 0;
    ++count_;
  }
  [[nodiscard]] LengthStatistics Statistics() const {
    if (count_ == 0) return {};
    const auto n = static_cast<double>(count_);
    return {sum_ / n, min_, max_, static_cast<double>(sqrt2_count_) / n,
            static_cast<double>(count_125_) / n};
  }

 private:
  static constexpr double kSqrt2 = 1.4142135623730951;
  static constexpr double kSqrtHalf = 0.70710678118654757;
  double sum_ = 0;
  double min_ = 0;
  double max_ = 0;
  std::int64_t sqrt2_count_ = 0;
  std::int64_t count_125_ = 0;
  std::int64_t count_ = 0;
};

class QualityMeter {
 public:
  explicit QualityMeter(const MetricField& field) : field_(field) {}

  struct Corner {
    Vec2 position;
    Metric metric;
  };

  void AddTriangle(const std::array<Corner, 3>& c) {
    const Metric mean = (1.0 / 3.0) * (c[0].metric + c[1].metric + c[2].metric);
    const double area =
        NormalizedArea(c[0].position, mean, c[1].position, mean, c[2].position, mean);
    double squared_sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 u = c[(k + 1) % 3].position - c[k].position;
      const Vec2 w = c[(k + 2) % 3].position - c[k].position;
      const double uu = SquaredLength(mean, u);
      const double ww = SquaredLength(mean, w);
      squared_sum += uu;
      AddAngle(InnerProduct(mean, u, w) / std::sqrt(uu * ww));
    }
    const double q = 4 * kSqrt3 * area / squared_sum;
    qualities_.push_back(q);
    quality_.q_mean += q;
    quality_.complexity += area;
  }

  void AddEdge(const Corner& a, const Corner& b) {
    const double averaged = Distance(a.position, a.metric, b.position, b.metric);
    averaged_.Add(averaged);
    integrated_.Add(IntegratedLength(field_, a.position, b.position, hint_));
    auto& counts = quality_.lengths.counts;
    const double bin = averaged / quality_.lengths.upper * static_cast<double>(counts.size());
    const auto last = counts.size() - 1;
    ++counts[bin >= static_cast<double>(last) ? last : static_cast<std::size_t>(bin)];
    ++quality_.edge_count;
  }

  Quality Finish(std::int64_t vertex_count) {
    quality_.vertex_count = vertex_count;
    quality_.triangle_count = static_cast<std::int64_t>(qualities_.size());
    quality_.integrated = integrated_.Statistics();
    quality_.averaged = averaged_.Statistics();
    if (qualities_.empty()) return quality_;
    quality_.q_mean /= static_cast<double>(qualities_.size());
    quality_.q_min = *std::min_element(qualities_.begin(), qualities_.end());
    const auto percentile =
        qualities_.begin() + static_cast<std::ptrdiff_t>(qualities_.size() / 100);
    std::nth_element(qualities_.begin(), percentile, qualities_.end());
    quality_.q_percentile_1 = *percentile;
    return quality_;
  }

 private:
  static constexpr double kSqrt3 = 1.7320508075688772;

  void AddAngle(double cosine) {
    // Cosines fall with the angle: the first border at or below ends the bin.
    const auto border =
        std::upper_bound(cosines_.begin() + 1, cosines_.end() - 1, cosine, std::greater<>());
    ++quality_.angles.counts[static_cast<std::size_t>(border - cosines_.begin()) - 1];
  }

  const MetricField& field_;
  std::int32_t hint_ = MetricField::kNoHint;
  const std::array<double, 61> cosines_ = BinCosines();
  Quality quality_;
  LengthMeter integrated_;
  LengthMeter averaged_;
  std::vector<double> qualities_;
};

/// Each edge of the triangles once, ends in ascending order.
std::vector<std::pair<std::int32_t, std::int32_t>> DistinctEdges(const MeshData& mesh) {
  std::vector<std::pair<std::int32_t, std::int32_t>> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (const auto& corners : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      edges.push_back(std::minmax({corners[k], corners[(k + 1) % 3]}));
    }
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

}  // namespace

Quality MeasureQuality(const Mesh& mesh, const MetricField& field) {
  QualityMeter meter(field);
  std::vector<Metric> metrics(static_cast<std::size_t>(mesh.vertex_slots()));
  for (std::int32_t v = 0; v < mesh.vertex_slots(); ++v) {
    const VertexRecord& vertex = mesh.vertex(VertexId(v));
    if (!vertex.live) continue;
    std::int32_t hint = mesh.hint(VertexId(v));
    metrics[static_cast<std::size_t>(v)] = field.At(vertex.position, hint);
  }
  const auto corner = [&](VertexId v) {
    return QualityMeter::Corner{mesh.position(v), metrics[v.index()]};
  };
  for (std::int32_t t = 0; t < mesh.triangle_slots(); ++t) {
    const TriangleRecord& triangle = mesh.triangle(TriangleId(t));
    if (!triangle.live) continue;
    const auto [a, b, c] = CanonicalTriangle(triangle.vertices);
    meter.AddTriangle({corner(a), corner(b), corner(c)});
    for (std::size_t side = 0; side < 3; ++side) {
      // Each edge once: from the triangle with the lower slot.
      if (triangle.neighbors[side].valid() && triangle.neighbors[side] < TriangleId(t)) continue;
      const auto [from, to] =
          std::minmax(triangle.vertices[(side + 1) % 3], triangle.vertices[(side + 2) % 3]);
      meter.AddEdge(corner(from), corner(to));
    }
  }
  return meter.Finish(mesh.vertex_count());
}

Quality MeasureQuality(const MeshData& mesh, const MetricField& field) {
  QualityMeter meter(field);
  std::vector<Metric> metrics;
  metrics.reserve(mesh.points.size());
  std::int32_t hint = MetricField::kNoHint;
  for (const Vec2 point : mesh.points) metrics.push_back(field.At(point, hint));
  const auto corner = [&](std::int32_t v) {
    const auto index = static_cast<std::size_t>(v);
    return QualityMeter::Corner{mesh.points[index], metrics[index]};
  };
  for (const auto& [a, b, c] : mesh.triangles) {
    meter.AddTriangle({corner(a), corner(b), corner(c)});
  }
  for (const auto& [from, to] : DistinctEdges(mesh)) meter.AddEdge(corner(from), corner(to));
  return meter.Finish(static_cast<std::int64_t>(mesh.points.size()));
}

}  // namespace pliant
