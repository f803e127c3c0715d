#include "core/metric/gradation.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <numeric>
#include <queue>
#include <utility>

#include "core/base/as_index.h"
#include "core/base/check.h"
#include "core/base/math.h"
#include "core/metric/gradation_rule.h"
#include "core/metric/tensor_smoothing.h"

namespace pliant {
namespace {

/// A vertex waiting at the size that it has been given; smallest first.
struct Waiting {
  double size;
  std::int32_t vertex;
  friend auto operator<=>(const Waiting&, const Waiting&) = default;
};
using Heap = std::priority_queue<Waiting, std::vector<Waiting>, std::greater<>>;

/// Which of two offers of the same thin size counts: any rule serves that looks at nothing but the
/// offers, for then the numbering of vertices plays no part.
bool IsBetter(const AxisSizes& a, const AxisSizes& b) {
  if (a.wide != b.wide) return a.wide > b.wide;
  if (a.frame.c != b.frame.c) return a.frame.c > b.frame.c;
  return a.frame.s > b.frame.s;
}

/// *Invariants*: sizes_ only shrink from pass to pass; a vertex that is done keeps its value.
class Limiter {
 public:
  Limiter(const VertexGraph& graph, std::span<const Vec2> points, GradationRates rates)
      : graph_(graph), points_(points), rates_(rates) {}

  LimitedMetrics Run(std::span<const Metric> tensors, const GradationOptions& options) {
    const bool with_growth = options.gradation != 0;
    raw_.reserve(tensors.size());
    for (const Metric& tensor : tensors) raw_.push_back(SizesFromMetric(tensor));
    was_smoothed_.assign(raw_.size(), 0);
    if (options.smoothing_count > 0) Smooth(tensors, options.smoothing_count);
    sizes_ = raw_;
    was_rotated_.assign(raw_.size(), 0);
    was_graded_.assign(raw_.size(), 0);
    LimitRotation();
    if (with_growth) {
      GrowThin();
      LimitRotation();
      GrowWide();
    }
    return Collect(tensors);
  }

 private:
  std::span<const std::int32_t> Neighbors(std::int32_t v) const {
    const auto begin = AsIndex(graph_.offsets[AsIndex(v)]);
    const auto end = AsIndex(graph_.offsets[AsIndex(v) + 1]);
    return std::span(graph_.neighbors).subspan(begin, end - begin);
  }
  std::int32_t size() const { return static_cast<std::int32_t>(raw_.size()); }
  Vec2 Edge(std::int32_t from, std::int32_t to) const {
    return points_[AsIndex(to)] - points_[AsIndex(from)];
  }

  /// Replaces each tensor by its mean with its ring, over and over.
  void Smooth(std::span<const Metric> tensors, std::int32_t pass_count) {
    std::vector<LogMetric> logs;
    for (const Metric& tensor : tensors) logs.push_back(pliant::Log(tensor));
    const std::vector<LogMetric> first = logs;
    for (std::int32_t pass = 0; pass < pass_count; ++pass) {
      const std::vector<LogMetric> before = logs;
      for (std::int32_t p = 0; p < size(); ++p) {
        std::vector<PlacedLog> ring;
        for (const std::int32_t q : Neighbors(p)) {
          ring.push_back({points_[AsIndex(q)], before[AsIndex(q)]});
        }
        logs[AsIndex(p)] = RingMean(before[AsIndex(p)], ring);
      }
    }
    for (std::size_t p = 0; p < logs.size(); ++p) {
      if (logs[p] == first[p]) continue;
      was_smoothed_[p] = 1;
      raw_[p] = SizesFromMetric(Exp(logs[p]));
    }
  }

  /// Shortens every wide size by the rotation limit. All see the sizes of before.
  void LimitRotation() {
    if (rates_.rotation == 0) return;
    base_ = sizes_;
    for (std::int32_t p = 0; p < size(); ++p) {
      double wide = base_[AsIndex(p)].wide;
      for (const std::int32_t q : Neighbors(p)) {
        wide =
            std::min(wide, RotationLimit(base_[AsIndex(p)], base_[AsIndex(q)], Edge(p, q), rates_));
      }
      wide = std::max(wide, base_[AsIndex(p)].thin);
      if (wide < base_[AsIndex(p)].wide) was_rotated_[AsIndex(p)] = 1;
      sizes_[AsIndex(p)].wide = wide;
    }
  }

  /// What p offers to q, at the thin size `thin`: p's axes, or q's own if they leave a larger wide
  /// size.
  AxisSizes Offer(const AxisSizes& p, std::int32_t q, Vec2 e, double thin) const {
    const double limit = WideLimit(p, e, rates_.growth);
    const double kept = std::min(base_[AsIndex(q)].wide, limit);
    const double adopted = std::min(WideInFrame(raw_[AsIndex(q)], p.frame, thin), limit);
    if (adopted >= kept) return {thin, adopted, p.frame};
    return {thin, kept, base_[AsIndex(q)].frame};
  }

  /// The shortest-path problem of thin sizes. Only vertices that have something to offer to a
  /// neighbour enter the heap: most of a smooth metric never does.
  void GrowThin() {
    base_ = sizes_;
    std::vector<char> is_done(raw_.size(), 0);
    Heap heap;
    const auto thin_at = [&](std::int32_t p, std::int32_t q) {
      return ThinLimit(sizes_[AsIndex(p)], Edge(p, q), rates_.growth);
    };
    for (std::int32_t p = 0; p < size(); ++p) {
      const auto has_offer = [&](std::int32_t q) { return thin_at(p, q) < base_[AsIndex(q)].thin; };
      if (std::ranges::any_of(Neighbors(p), has_offer)) heap.push({sizes_[AsIndex(p)].thin, p});
    }
    while (!heap.empty()) {
      const auto [thin_p, p] = heap.top();
      heap.pop();
      if (is_done[AsIndex(p)] != 0 || thin_p != sizes_[AsIndex(p)].thin) continue;
      is_done[AsIndex(p)] = 1;
      for (const std::int32_t q : Neighbors(p)) {
        if (is_done[AsIndex(q)] != 0) continue;
        AxisSizes& label = sizes_[AsIndex(q)];
        const double thin = thin_at(p, q);
        // Against its own wish a vertex takes only a smaller size.
        if (thin > label.thin || thin >= base_[AsIndex(q)].thin) continue;
        const AxisSizes offer = Offer(sizes_[AsIndex(p)], q, Edge(p, q), thin);
        if (thin == label.thin && !IsBetter(offer, label)) continue;
        if (thin < label.thin) heap.push({thin, q});
        label = offer;
        was_graded_[AsIndex(q)] = 1;
      }
    }
  }

  /// The shortest-path problem of wide sizes, with axes and thin sizes final.
  void GrowWide() {
    std::vector<char> is_done(raw_.size(), 0);
    Heap heap;
    const auto wide_at = [&](std::int32_t p, std::int32_t q) {
      const double wide = WideLimit(sizes_[AsIndex(p)], Edge(p, q), rates_.growth);
      return std::max(wide, sizes_[AsIndex(q)].thin);
    };
    for (std::int32_t p = 0; p < size(); ++p) {
      const auto has_offer = [&](std::int32_t q) {
        return wide_at(p, q) < sizes_[AsIndex(q)].wide;
      };
      if (std::ranges::any_of(Neighbors(p), has_offer)) heap.push({sizes_[AsIndex(p)].wide, p});
    }
    while (!heap.empty()) {
      const auto [wide_p, p] = heap.top();
      heap.pop();
      if (is_done[AsIndex(p)] != 0 || wide_p != sizes_[AsIndex(p)].wide) continue;
      is_done[AsIndex(p)] = 1;
      for (const std::int32_t q : Neighbors(p)) {
        const double wide = wide_at(p, q);
        if (is_done[AsIndex(q)] != 0 || wide >= sizes_[AsIndex(q)].wide) continue;
        sizes_[AsIndex(q)].wide = wide;
        heap.push({wide, q});
        was_graded_[AsIndex(q)] = 1;
      }
    }
  }

  LimitedMetrics Collect(std::span<const Metric> tensors) const {
    LimitedMetrics result;
    result.tensors.reserve(tensors.size());
    for (std::size_t v = 0; v < tensors.size(); ++v) {
      result.rotation_count += was_rotated_[v];
      result.gradation_count += was_graded_[v];
      result.smoothing_count += was_smoothed_[v];
      if (was_smoothed_[v] == 0 && sizes_[v] == raw_[v]) {
        result.tensors.push_back(tensors[v]);
        continue;
      }
      result.tensors.push_back(MetricFromSizes(sizes_[v]));
      const double ratio = SizeRatio(SizesFromMetric(tensors[v]), sizes_[v]);
      result.size_ratio_max = std::max(result.size_ratio_max, ratio);
    }
    return result;
  }

  const VertexGraph& graph_;
  std::span<const Vec2> points_;
  GradationRates rates_;
  std::vector<AxisSizes> raw_;    ///< Of the tensors, or of their averages.
  std::vector<AxisSizes> base_;   ///< What a pass starts from.
  std::vector<AxisSizes> sizes_;  ///< The result so far.
  std::vector<char> was_smoothed_;
  std::vector<char> was_rotated_;
  std::vector<char> was_graded_;
};

}  // namespace

VertexGraph GraphOfTriangles(std::span<const std::array<std::int32_t, 3>> triangles,
                             std::int32_t vertex_count) {
  // Every triangle puts each of its corners' two neighbours into a bucket of the corner; most come
  // twice.
  std::vector<std::int32_t> bucket_end(AsIndex(vertex_count) + 1, 0);
  for (const auto& corners : triangles) {
    for (const std::int32_t v : corners) bucket_end[AsIndex(v) + 1] += 2;
  }
  std::partial_sum(bucket_end.begin(), bucket_end.end(), bucket_end.begin());
  std::vector<std::int32_t> fill(bucket_end.begin(), std::prev(bucket_end.end()));
  std::vector<std::int32_t> buckets(AsIndex(bucket_end.back()));
  for (const auto& corners : triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      std::int32_t& next = fill[AsIndex(corners[k])];
      buckets[AsIndex(next++)] = corners[(k + 1) % 3];
      buckets[AsIndex(next++)] = corners[(k + 2) % 3];
    }
  }
  VertexGraph graph;
  graph.offsets.reserve(bucket_end.size());
  graph.offsets.push_back(0);
  graph.neighbors.reserve(buckets.size() / 2 + AsIndex(vertex_count));
  for (std::size_t v = 0; v < AsIndex(vertex_count); ++v) {
    const auto begin = buckets.begin() + bucket_end[v];
    const auto end = buckets.begin() + bucket_end[v + 1];
    std::sort(begin, end);
    graph.neighbors.insert(graph.neighbors.end(), begin, std::unique(begin, end));
    graph.offsets.push_back(static_cast<std::int32_t>(graph.neighbors.size()));
  }
  return graph;
}

LimitedMetrics LimitMetrics(const VertexGraph& graph, std::span<const Vec2> points,
                            std::span<const Metric> tensors, const GradationOptions& options) {
  PLIANT_CHECK(graph.offsets.size() == points.size() + 1 && points.size() == tensors.size(),
               "points", points.size(), "tensors", tensors.size());
  PLIANT_CHECK(options.gradation == 0 || options.gradation >= 1, "gradation", options.gradation);
  PLIANT_CHECK(options.rotation >= 0, "rotation", options.rotation);
  const GradationRates rates = {.growth = options.gradation == 0 ? 0 : Log(options.gradation),
                                .rotation = options.rotation};
  return Limiter(graph, points, rates).Run(tensors, options);
}

}  // namespace pliant
