#include "core/metric/gradation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <numeric>
#include <tuple>
#include <utility>
#include <vector>

#include "core/base/math.h"
#include "core/base/rng.h"
#include "core/metric/gradation_rule.h"

namespace pliant {
namespace {

struct Sample {
  std::vector<Vec2> points;
  std::vector<std::array<std::int32_t, 3>> triangles;
  std::vector<Metric> tensors;

  VertexGraph Graph() const {
    return GraphOfTriangles(triangles, static_cast<std::int32_t>(points.size()));
  }
  LimitedMetrics Limit(const GradationOptions& options) const {
    return LimitMetrics(Graph(), points, tensors, options);
  }
};

/// A jittered grid of n x n cells over [-1, 1]^2 with the tensors of a function.
Sample SampleGrid(int n, const std::function<Metric(Vec2)>& metric) {
  Rng rng(1996);
  Sample sample;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      const Vec2 p = {(2.0 * i + rng.Uniform(-0.4, 0.4)) / n - 1,
                      (2.0 * j + rng.Uniform(-0.4, 0.4)) / n - 1};
      sample.points.push_back(p);
      sample.tensors.push_back(metric(p));
    }
  }
  for (std::int32_t j = 0; j < n; ++j) {
    for (std::int32_t i = 0; i < n; ++i) {
      const std::int32_t a = j * (n + 1) + i;
      sample.triangles.push_back({a, a + 1, a + n + 2});
      sample.triangles.push_back({a, a + n + 2, a + n + 1});
    }
  }
  return sample;
}

Metric Axes(double major, double minor, double major_angle) {
  return MetricFromAxes({major, minor, {std::cos(major_angle), std::sin(major_angle)}});
}

Metric Jump(Vec2 p) { return Metric::Isotropic(p.x < 0.1 ? 0.1 : 0.005); }

/// Crossed needles of ratio 20 in the cells of a checkerboard.
Metric Checkerboard(Vec2 p) {
  const bool odd = (static_cast<int>(4 * p.x + 4) + static_cast<int>(4 * p.y + 4)) % 2 == 1;
  return Axes(0.4, 0.02, odd ? 0.3 : 0.3 + std::numbers::pi / 2);
}

/// A thin layer along the circle of radius 0.7.
Metric CurvedFront(Vec2 p) {
  const double r = Length(p);
  const double thin = 0.002 + 0.3 * std::abs(r - 0.7);
  return Axes(std::max(0.2, thin), thin, std::atan2(p.x, -p.y));
}

Metric RandomTensor(Rng& rng) {
  const double major = std::pow(10, rng.Uniform(-2, 0));
  return Axes(major, major * std::pow(10, -rng.Uniform(0, 2)), rng.Uniform(0, std::numbers::pi));
}

std::vector<Sample> Samples() {
  std::vector<Sample> samples = {SampleGrid(20, Jump), SampleGrid(24, Checkerboard),
                                 SampleGrid(40, CurvedFront)};
  auto rng = std::make_shared<Rng>(7);
  samples.push_back(SampleGrid(16, [rng](Vec2) { return RandomTensor(*rng); }));
  return samples;
}

constexpr GradationOptions kBoth = {.gradation = 1.5, .rotation = 0.7};
constexpr GradationOptions kAll[] = {kBoth,
                                     {.gradation = 1.5},
                                     {.rotation = 0.7},
                                     {.gradation = 1, .rotation = 0.7},
                                     {.gradation = 3}};

double LeastRatio(const Metric& a, const Metric& b) {
  double least = 1e300;
  for (int i = 0; i < 180; ++i) {
    const double angle = i * std::numbers::pi / 180;
    const Vec2 e = {std::cos(angle), std::sin(angle)};
    least = std::min(least, std::sqrt(SquaredLength(a, e) / SquaredLength(b, e)));
  }
  return least;
}

TEST(GraphOfTriangles, ListsEachNeighbourOnce) {
  const std::vector<std::array<std::int32_t, 3>> triangles = {{0, 1, 2}, {0, 2, 4}};
  const VertexGraph graph = GraphOfTriangles(triangles, 5);
  EXPECT_EQ(graph.offsets, (std::vector<std::int32_t>{0, 3, 5, 8, 8, 10}));
  EXPECT_EQ(graph.neighbors, (std::vector<std::int32_t>{1, 2, 4, 0, 2, 0, 1, 4, 0, 2}));
}

TEST(LimitMetrics, LeavesAloneWhatNeedsNothing) {
  for (const GradationOptions& options : {GradationOptions{}, kBoth}) {
    const Sample constant = SampleGrid(8, [](Vec2) { return Axes(0.5, 0.01, 0.4); });
    const LimitedMetrics limited = constant.Limit(options);
    EXPECT_EQ(limited.tensors, constant.tensors);
    EXPECT_EQ(limited.rotation_count + limited.gradation_count, 0);
    EXPECT_EQ(limited.size_ratio_max, 1);
  }
  const Sample wild = Samples().back();
  EXPECT_EQ(wild.Limit({}).tensors, wild.tensors);
}

TEST(LimitMetrics, IsNowhereCoarserThanTheRawMetric) {
  for (const Sample& sample : Samples()) {
    for (const GradationOptions& options : kAll) {
      const LimitedMetrics limited = sample.Limit(options);
      double largest = 1;
      for (std::size_t v = 0; v < sample.points.size(); ++v) {
        ASSERT_TRUE(IsPositiveDefinite(limited.tensors[v]));
        ASSERT_GE(LeastRatio(limited.tensors[v], sample.tensors[v]), 1 - 1e-9) << "vertex " << v;
        largest = std::max(largest, 1 / LeastRatio(sample.tensors[v], limited.tensors[v]));
      }
      // The report is the supremum over all directions, the samples come close to it.
      EXPECT_GE(limited.size_ratio_max, largest * (1 - 1e-9));
      EXPECT_LE(limited.size_ratio_max, largest * 1.2);
    }
  }
}

// Goal: the answer belongs to the points, not to their numbers. Method: shuffle and compare bits.
TEST(LimitMetrics, DoesNotDependOnTheNumberingOfVertices) {
  for (const Sample& sample : Samples()) {
    const auto count = sample.points.size();
    const LimitedMetrics expected = sample.Limit(kBoth);
    for (std::uint64_t seed = 0; seed < 3; ++seed) {
      Rng rng(seed);
      std::vector<std::size_t> new_index(count);
      std::iota(new_index.begin(), new_index.end(), 0);
      for (std::size_t i = count; i > 1; --i) std::swap(new_index[i - 1], new_index[rng.Below(i)]);
      Sample shuffled = sample;
      for (std::size_t v = 0; v < count; ++v) {
        shuffled.points[new_index[v]] = sample.points[v];
        shuffled.tensors[new_index[v]] = sample.tensors[v];
      }
      for (auto& corners : shuffled.triangles) {
        for (auto& v : corners) {
          v = static_cast<std::int32_t>(new_index[static_cast<std::size_t>(v)]);
        }
      }
      const LimitedMetrics limited = shuffled.Limit(kBoth);
      for (std::size_t v = 0; v < count; ++v) {
        ASSERT_EQ(limited.tensors[new_index[v]], expected.tensors[v]) << "seed " << seed;
      }
      EXPECT_EQ(limited.rotation_count, expected.rotation_count);
      EXPECT_EQ(limited.gradation_count, expected.gradation_count);
      EXPECT_EQ(limited.size_ratio_max, expected.size_ratio_max);
    }
  }
}

/// Solves the same equations without a heap: every vertex takes the best that its neighbours'
/// latest values offer, again and again from scratch, until a whole sweep changes nothing.
class Sweeps {
 public:
  Sweeps(const Sample& sample, const GradationOptions& options)
      : sample_(sample), graph_(sample.Graph()) {
    rates_ = {.growth = Log(options.gradation), .rotation = options.rotation};
    for (const Metric& tensor : sample.tensors) raw_.push_back(SizesFromMetric(tensor));
  }

  std::vector<AxisSizes> Solve() {
    base_ = Rotated(raw_);
    Repeat([&](std::size_t q) { return Thin(q); }, base_);
    cap_ = Rotated(current_);
    Repeat([&](std::size_t q) { return Wide(q); }, cap_);
    return current_;
  }

 private:
  void Repeat(const std::function<AxisSizes(std::size_t)>& update,
              const std::vector<AxisSizes>& start) {
    current_ = start;
    bool has_changed = true;
    for (int sweep = 0; has_changed && sweep < 5000; ++sweep) {
      has_changed = false;
      for (std::size_t i = 0; i < raw_.size(); ++i) {
        const std::size_t q = sweep % 2 == 0 ? i : raw_.size() - 1 - i;
        const AxisSizes next = update(q);
        has_changed = has_changed || next != current_[q];
        current_[q] = next;
      }
    }
    EXPECT_FALSE(has_changed);
  }

  template <class Function>
  void ForNeighbors(std::size_t q, Function function) const {
    for (auto k = graph_.offsets[q]; k < graph_.offsets[q + 1]; ++k) {
      const auto p = static_cast<std::size_t>(graph_.neighbors[static_cast<std::size_t>(k)]);
      function(p, sample_.points[q] - sample_.points[p]);
    }
  }

  std::vector<AxisSizes> Rotated(const std::vector<AxisSizes>& sizes) const {
    std::vector<AxisSizes> rotated = sizes;
    for (std::size_t p = 0; p < sizes.size(); ++p) {
      ForNeighbors(p, [&](std::size_t q, Vec2 e) {
        rotated[p].wide = std::min(rotated[p].wide, RotationLimit(sizes[p], sizes[q], e, rates_));
      });
      rotated[p].wide = std::max(rotated[p].wide, rotated[p].thin);
    }
    return rotated;
  }

  AxisSizes Thin(std::size_t q) const {
    AxisSizes best = base_[q];
    bool is_own = true;
    ForNeighbors(q, [&](std::size_t p, Vec2 e) {
      const double thin = ThinLimit(current_[p], e, rates_.growth);
      if (thin > best.thin || (is_own && thin == best.thin)) return;
      const double limit = WideLimit(current_[p], e, rates_.growth);
      const double kept = std::min(base_[q].wide, limit);
      const double adopted = std::min(WideInFrame(raw_[q], current_[p].frame, thin), limit);
      const AxisSizes offer = adopted >= kept ? AxisSizes{thin, adopted, current_[p].frame}
                                              : AxisSizes{thin, kept, base_[q].frame};
      const auto key = [](const AxisSizes& a) {
        return std::tuple(a.thin, -a.wide, -a.frame.c, -a.frame.s);
      };
      if (is_own || key(offer) < key(best)) best = offer;
      is_own = false;
    });
    return best;
  }

  AxisSizes Wide(std::size_t q) const {
    AxisSizes best = cap_[q];
    ForNeighbors(q, [&](std::size_t p, Vec2 e) {
      best.wide = std::min(best.wide, WideLimit(current_[p], e, rates_.growth));
    });
    best.wide = std::max(best.wide, best.thin);
    return best;
  }

  const Sample& sample_;
  VertexGraph graph_;
  GradationRates rates_;
  std::vector<AxisSizes> raw_;
  std::vector<AxisSizes> base_;
  std::vector<AxisSizes> cap_;
  std::vector<AxisSizes> current_;
};

// Goal: the heap finds the one solution of the equations, to the bit.
TEST(LimitMetrics, IsTheFixedPointThatSweepsReach) {
  for (const Sample& sample : Samples()) {
    for (const double gradation : {1.1, 1.5, 3.0}) {
      const GradationOptions options = {.gradation = gradation, .rotation = 0.7};
      const LimitedMetrics limited = sample.Limit(options);
      const std::vector<AxisSizes> expected = Sweeps(sample, options).Solve();
      std::size_t changed = 0;
      for (std::size_t v = 0; v < expected.size(); ++v) {
        if (limited.tensors[v] == sample.tensors[v]) continue;
        ++changed;
        ASSERT_EQ(limited.tensors[v], MetricFromSizes(expected[v])) << "vertex " << v;
      }
      EXPECT_GT(changed, 0U);
    }
  }
}

TEST(LimitMetrics, MakesAJumpGrowGently) {
  const Sample sample = SampleGrid(40, Jump);
  const LimitedMetrics limited = sample.Limit({.gradation = 1.5});
  const VertexGraph graph = sample.Graph();
  std::vector<AxisSizes> sizes;
  for (const Metric& tensor : limited.tensors) sizes.push_back(SizesFromMetric(tensor));
  for (std::size_t p = 0; p < sizes.size(); ++p) {
    // Isotropic in, isotropic out: no stars of needles around small elements.
    ASSERT_NEAR(sizes[p].wide / sizes[p].thin, 1, 1e-9);
    for (auto k = graph.offsets[p]; k < graph.offsets[p + 1]; ++k) {
      const auto q = static_cast<std::size_t>(graph.neighbors[static_cast<std::size_t>(k)]);
      const double length = Length(sample.points[q] - sample.points[p]) / sizes[p].thin;
      ASSERT_LE(sizes[q].thin / sizes[p].thin,
                std::pow(1.5, length) * (1 + 1e-12) + std::log(1.5) * length);
      ASSERT_LE(sizes[q].thin,
                (sizes[p].thin + std::log(1.5) * length * sizes[p].thin) * (1 + 1e-12));
    }
    // Not finer than the straight distance to the jump demands. Edges make detours, at most 10 %.
    const double distance = std::max(0.0, 0.1 - sample.points[p].x);
    if (distance > 0) {
      ASSERT_GE(sizes[p].thin, std::min(0.1, 0.005 + std::log(1.5) * 0.9 * (distance - 0.1)));
    }
  }
  EXPECT_NEAR(limited.size_ratio_max, 0.1 / (0.005 + std::log(1.5) * 0.05), 2.5);
  EXPECT_GT(limited.gradation_count, 50);
  EXPECT_EQ(limited.rotation_count, 0);
}

TEST(LimitMetrics, ShortensLongElementsOnACurvedFront) {
  // On a circle of radius r with constant thin size, the limit is sqrt(C thin r).
  const double thin = 0.001;
  const double radius = 2;
  Sample sample;
  const int count = 400;
  for (int ring = 0; ring < 3; ++ring) {
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * i / count;
      const double r = radius + 0.01 * ring;
      sample.points.push_back({r * std::cos(angle), r * std::sin(angle)});
      sample.tensors.push_back(Axes(1, thin, angle + std::numbers::pi / 2));
      const std::int32_t a = ring * count + i;
      const std::int32_t b = ring * count + (i + 1) % count;
      if (ring > 0) {
        sample.triangles.push_back({a, a - count, b});
        sample.triangles.push_back({b, a - count, b - count});
      }
    }
  }
  const LimitedMetrics limited = sample.Limit({.rotation = 0.7});
  EXPECT_EQ(limited.rotation_count, 3 * count);
  EXPECT_EQ(limited.gradation_count, 0);
  const AxisSizes sizes = SizesFromMetric(limited.tensors[count + 5]);
  EXPECT_NEAR(sizes.thin, thin, 1e-12);
  EXPECT_NEAR(sizes.wide / std::sqrt(0.7 * thin * radius), 1, 0.02);
}

// Goal: what has been limited needs little more. A second run sees the first one's result as raw.
TEST(LimitMetrics, ChangesLittleWhenItRunsAgain) {
  Sample again = SampleGrid(40, Jump);
  again.tensors = again.Limit(kBoth).tensors;
  EXPECT_LT(again.Limit(kBoth).size_ratio_max, 1 + 1e-9);
  again = SampleGrid(40, CurvedFront);
  const double first = again.Limit(kBoth).size_ratio_max;
  again.tensors = again.Limit(kBoth).tensors;
  EXPECT_LT(again.Limit(kBoth).size_ratio_max, 1 + 0.2 * (first - 1));
}

TEST(LimitMetrics, ScalesAndTurnsWithItsInput) {
  const Sample sample = SampleGrid(40, CurvedFront);
  const LimitedMetrics expected = sample.Limit(kBoth);
  Sample moved = sample;
  const double c = std::cos(0.6);
  const double s = std::sin(0.6);
  const double scale = 1000;
  for (std::size_t v = 0; v < sample.points.size(); ++v) {
    const auto [x, y] = sample.points[v];
    moved.points[v] = {scale * (c * x - s * y), scale * (s * x + c * y)};
    MetricAxes axes = AxesFromMetric(sample.tensors[v]);
    const Vec2 u = axes.major_direction;
    moved.tensors[v] = MetricFromAxes({scale * axes.major_radius,
                                       scale * axes.minor_radius,
                                       {c * u.x - s * u.y, s * u.x + c * u.y}});
  }
  const LimitedMetrics limited = moved.Limit(kBoth);
  EXPECT_EQ(limited.rotation_count, expected.rotation_count);
  EXPECT_NEAR(limited.size_ratio_max, expected.size_ratio_max, 1e-6);
  for (std::size_t v = 0; v < sample.points.size(); ++v) {
    const AxisSizes a = SizesFromMetric(expected.tensors[v]);
    const AxisSizes b = SizesFromMetric(limited.tensors[v]);
    EXPECT_NEAR(b.thin / (scale * a.thin), 1, 1e-6);
    EXPECT_NEAR(b.wide / (scale * a.wide), 1, 1e-6);
  }
}

}  // namespace
}  // namespace pliant
