#include "core/pliant/quality.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "core/base/sort_unique.h"
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

struct Corner {
  Vec2 position;
  Metric metric;
  std::int32_t hint = MetricField::kNoHint;
};

/// Which bin of the angles a cosine belongs to.
std::size_t AngleBin(double cosine) {
  static const std::array<double, 61> kCosines = BinCosines();
  // Cosines fall with the angle: the first border at or below ends the bin.
  const auto border =
      std::upper_bound(kCosines.begin() + 1, kCosines.end() - 1, cosine, std::greater<>());
  return static_cast<std::size_t>(border - kCosines.begin()) - 1;
}

/// What is measured of some triangles and edges, number by number: parts can be measured in any
/// order and by several threads, and summed up in one.
class Sample {
 public:
  void Clear() {
    qualities_.clear();
    areas_.clear();
    angle_counts_.fill(0);
    edges_.clear();
    averaged_.clear();
    points_.clear();
    hints_.clear();
  }

  void AddTriangle(const std::array<Corner, 3>& c) {
    constexpr double kSqrt3 = 1.7320508075688772;
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
      ++angle_counts_[AngleBin(InnerProduct(mean, u, w) / std::sqrt(uu * ww))];
    }
    qualities_.push_back(4 * kSqrt3 * area / squared_sum);
    areas_.push_back(area);
  }

  void AddEdge(const Corner& a, const Corner& b) {
    edges_.push_back(b.position - a.position);
    averaged_.push_back(Distance(a.position, a.metric, b.position, b.metric));
    const auto points = IntegrationPoints(a.position, b.position);
    points_.insert(points_.end(), points.begin(), points.end());
    hints_.push_back(a.hint);
    hints_.resize(points_.size(), MetricField::kNoHint);
  }

  /// Asks the field what the edges' integrated lengths need. Last of all.
  void Integrate(const MetricField& field) {
    metrics_.resize(points_.size());
    field.AtEach(points_, hints_, metrics_);
  }

  [[nodiscard]] std::span<const double> qualities() const { return qualities_; }
  [[nodiscard]] std::span<const double> areas() const { return areas_; }
  [[nodiscard]] const std::array<std::int64_t, 60>& angle_counts() const { return angle_counts_; }
  [[nodiscard]] std::span<const double> averaged() const { return averaged_; }
  /// Of the edge of that number. @pre Integrate was called
  [[nodiscard]] double integrated(std::size_t i) const {
    constexpr std::size_t kCount = kIntegrationPointCount;
    return IntegratedLength(edges_[i],
                            std::span<const Metric, kCount>(metrics_.data() + kCount * i, kCount));
  }

 private:
  std::vector<double> qualities_;
  std::vector<double> areas_;
  std::array<std::int64_t, 60> angle_counts_{};
  std::vector<Vec2> edges_;  // From end to end.
  std::vector<double> averaged_;
  std::vector<Vec2> points_;  // kIntegrationPointCount for each edge, and so what follows.
  std::vector<std::int32_t> hints_;
  std::vector<Metric> metrics_;
};

/// Sums samples up, in the order in which they come.
class QualityMeter {
 public:
  void Add(const Sample& sample) {
    qualities_.insert(qualities_.end(), sample.qualities().begin(), sample.qualities().end());
    for (const double q : sample.qualities()) quality_.q_mean += q;
    for (const double area : sample.areas()) quality_.complexity += area;
    for (std::size_t bin = 0; bin < sample.angle_counts().size(); ++bin) {
      quality_.angles.counts[bin] += sample.angle_counts()[bin];
    }
    for (std::size_t i = 0; i < sample.averaged().size(); ++i) {
      const double averaged = sample.averaged()[i];
      averaged_.Add(averaged);
      integrated_.Add(sample.integrated(i));
      auto& counts = quality_.lengths.counts;
      const double bin = averaged / quality_.lengths.upper * static_cast<double>(counts.size());
      const auto last = counts.size() - 1;
      ++counts[bin >= static_cast<double>(last) ? last : static_cast<std::size_t>(bin)];
      ++quality_.edge_count;
    }
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
  SortUnique(edges);
  return edges;
}

}  // namespace

/// First the metric at every vertex, then the triangles with the edges that are theirs to tell,
/// both by slots.
class QualityMeasurement::Impl {
 public:
  Impl(const Mesh& mesh, const MetricField& field)
      : mesh_(mesh), field_(field), metrics_(static_cast<std::size_t>(mesh.vertex_slots())) {}

  bool Continue(Executor& helpers) {
    if (next_vertex_ < mesh_.vertex_slots()) {
      next_vertex_ = Part(next_vertex_, mesh_.vertex_slots(), helpers, &Impl::AskAtVertices);
    } else if (next_triangle_ < mesh_.triangle_slots()) {
      next_triangle_ = Part(next_triangle_, mesh_.triangle_slots(), helpers, &Impl::Measure);
      for (const Sample& sample : samples_) meter_.Add(sample);
    }
    return next_vertex_ < mesh_.vertex_slots() || next_triangle_ < mesh_.triangle_slots();
  }

  Quality Take() { return meter_.Finish(mesh_.vertex_count()); }

 private:
  static constexpr std::int32_t kTaskCount = 8;
  static constexpr std::int32_t kTaskLength = 512;

  struct Range {
    std::int32_t begin;
    std::int32_t end;
  };
  using Work = void (Impl::*)(Range, Sample&);

  /// Has the slots from `begin` on worked on, as many as make a part; returns where it ends.
  std::int32_t Part(std::int32_t begin, std::int32_t end, Executor& helpers, Work work) {
    helpers.Run(kTaskCount, [&](std::int32_t task) {
      Sample& sample = samples_[static_cast<std::size_t>(task)];
      sample.Clear();
      const std::int32_t first = std::min(begin + task * kTaskLength, end);
      (this->*work)({first, std::min(first + kTaskLength, end)}, sample);
    });
    return std::min(begin + kTaskCount * kTaskLength, end);
  }

  void AskAtVertices(Range slots, Sample& /*sample*/) {
    std::vector<Vec2> points;
    std::vector<std::int32_t> hints;
    for (std::int32_t v = slots.begin; v < slots.end; ++v) {
      if (!mesh_.vertex(VertexId(v)).live) continue;
      points.push_back(mesh_.position(VertexId(v)));
      hints.push_back(mesh_.hint(VertexId(v)));
    }
    std::vector<Metric> metrics(points.size());
    field_.AtEach(points, hints, metrics);
    auto next = metrics.begin();
    for (std::int32_t v = slots.begin; v < slots.end; ++v) {
      if (mesh_.vertex(VertexId(v)).live) metrics_[static_cast<std::size_t>(v)] = *next++;
    }
  }

  void Measure(Range slots, Sample& sample) {
    const auto corner = [&](VertexId v) {
      return Corner{mesh_.position(v), metrics_[v.index()], mesh_.hint(v)};
    };
    for (std::int32_t t = slots.begin; t < slots.end; ++t) {
      const TriangleRecord& triangle = mesh_.triangle(TriangleId(t));
      if (!triangle.live) continue;
      const auto [a, b, c] = CanonicalTriangle(triangle.vertices);
      sample.AddTriangle({corner(a), corner(b), corner(c)});
      for (std::size_t side = 0; side < 3; ++side) {
        // Each edge once: from the triangle with the lower slot.
        if (triangle.neighbors[side].valid() && triangle.neighbors[side] < TriangleId(t)) continue;
        const auto [from, to] =
            std::minmax(triangle.vertices[(side + 1) % 3], triangle.vertices[(side + 2) % 3]);
        sample.AddEdge(corner(from), corner(to));
      }
    }
    sample.Integrate(field_);
  }

  const Mesh& mesh_;
  const MetricField& field_;
  std::vector<Metric> metrics_;  // By slot.
  std::int32_t next_vertex_ = 0;
  std::int32_t next_triangle_ = 0;
  std::array<Sample, kTaskCount> samples_;  // One for each task of a part.
  QualityMeter meter_;
};

QualityMeasurement::QualityMeasurement(const Mesh& mesh, const MetricField& field)
    : impl_(std::make_unique<Impl>(mesh, field)) {}

QualityMeasurement::~QualityMeasurement() = default;

bool QualityMeasurement::Continue(Executor& helpers) { return impl_->Continue(helpers); }

Quality QualityMeasurement::Take() { return impl_->Take(); }

Quality MeasureQuality(const Mesh& mesh, const MetricField& field) {
  QualityMeasurement measurement(mesh, field);
  InlineExecutor alone;
  while (measurement.Continue(alone)) {
  }
  return measurement.Take();
}

Quality MeasureQuality(const MeshData& mesh, const MetricField& field) {
  std::vector<Metric> metrics(mesh.points.size());
  std::vector<std::int32_t> hints(mesh.points.size(), MetricField::kNoHint);
  field.AtEach(mesh.points, hints, metrics);
  const auto corner = [&](std::int32_t v) {
    const auto index = static_cast<std::size_t>(v);
    return Corner{mesh.points[index], metrics[index], hints[index]};
  };
  QualityMeter meter;
  Sample sample;
  // As in the measurement of a mesh: in portions that stay in the cache.
  constexpr std::size_t kPortion = 1024;
  const auto add_each = [&](const auto& items, auto&& add) {
    for (std::size_t begin = 0; begin < items.size(); begin += kPortion) {
      sample.Clear();
      const std::size_t end = std::min(begin + kPortion, items.size());
      for (std::size_t i = begin; i < end; ++i) add(items[i]);
      sample.Integrate(field);
      meter.Add(sample);
    }
  };
  add_each(mesh.triangles, [&](const auto& corners) {
    sample.AddTriangle({corner(corners[0]), corner(corners[1]), corner(corners[2])});
  });
  add_each(DistinctEdges(mesh),
           [&](const auto& ends) { sample.AddEdge(corner(ends.first), corner(ends.second)); });
  return meter.Finish(static_cast<std::int64_t>(mesh.points.size()));
}

}  // namespace pliant
