#include "core/pliant/quality.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "core/base/executor.h"
#include "core/mesh/export_mesh.h"
#include "core/metric/function_field.h"
#include "core/threads/thread_pool.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using testing::GridData;

Metric Wavy(Vec2 p) { return {2 + p.x + 0.1 * p.y, 0.3 - 0.05 * p.x, 1 + 0.2 * p.y}; }

/// What the header says, again, the slow way: everything by sorting and summing in long double.
struct Naive {
  std::vector<long double> qualities;
  std::vector<long double> averaged;
  std::vector<long double> integrated;
  std::vector<long double> angles;
  long double complexity = 0;

  Naive(const MeshData& mesh, Metric (*field)(Vec2)) {
    std::map<std::pair<int, int>, int> edges;
    for (const auto& t : mesh.triangles) AddTriangle(mesh, field, t, edges);
    for (const auto& [ends, count] : edges) {
      const Vec2 p = mesh.points[static_cast<std::size_t>(ends.first)];
      const Vec2 e = mesh.points[static_cast<std::size_t>(ends.second)] - p;
      averaged.push_back(std::sqrt((Squared(field(p), e) + Squared(field(p + e), e)) / 2));
      long double sum = 0;  // The midpoint rule stands for Gauss.
      for (int i = 0; i < 1000; ++i) sum += std::sqrt(Squared(field(p + (i + 0.5) / 1000 * e), e));
      integrated.push_back(sum / 1000);
    }
  }

  static long double Squared(const Metric& m, Vec2 e) {
    return static_cast<long double>(m.m11) * e.x * e.x + 2.0L * m.m12 * e.x * e.y +
           static_cast<long double>(m.m22) * e.y * e.y;
  }

  void AddTriangle(const MeshData& mesh, Metric (*field)(Vec2), const std::array<int, 3>& t,
                   std::map<std::pair<int, int>, int>& edges) {
    std::array<Vec2, 3> p;
    Metric mean{0, 0, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      p[k] = mesh.points[static_cast<std::size_t>(t[k])];
      mean = mean + (1.0 / 3) * field(p[k]);
      ++edges[std::minmax(t[k], t[(k + 1) % 3])];
    }
    const long double root = std::sqrt(static_cast<long double>(mean.m11) * mean.m22 -
                                       static_cast<long double>(mean.m12) * mean.m12);
    const long double area = root * Cross(p[1] - p[0], p[2] - p[0]) / 2;
    long double squares = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec2 u = p[(k + 1) % 3] - p[k];
      const Vec2 w = p[(k + 2) % 3] - p[k];
      const long double dot = (Squared(mean, u + w) - Squared(mean, u - w)) / 4;
      angles.push_back(std::atan2(root * Cross(u, w), dot) * 57.29577951308232L);
      squares += Squared(mean, u);
    }
    qualities.push_back(4 * std::sqrt(3.0L) * area / squares);
    complexity += area;
  }
};

long double Mean(const std::vector<long double>& values) {
  long double sum = 0;
  for (const long double value : values) sum += value;
  return sum / static_cast<long double>(values.size());
}

void ExpectStatistics(const LengthStatistics& is, const std::vector<long double>& lengths) {
  const auto share = [&](long double low, long double high) {
    const auto inside = std::count_if(lengths.begin(), lengths.end(),
                                      [&](long double l) { return l >= low && l <= high; });
    return static_cast<double>(inside) / static_cast<double>(lengths.size());
  };
  EXPECT_NEAR(is.mean, static_cast<double>(Mean(lengths)), 1e-6);
  EXPECT_NEAR(is.min, static_cast<double>(*std::min_element(lengths.begin(), lengths.end())), 1e-6);
  EXPECT_NEAR(is.max, static_cast<double>(*std::max_element(lengths.begin(), lengths.end())), 1e-6);
  EXPECT_EQ(is.share_sqrt2, share(std::sqrt(0.5L), std::sqrt(2.0L)));
  EXPECT_EQ(is.share_125, share(0.8L, 1.25L));
}

void ExpectHistogram(const Histogram<60>& is, const std::vector<long double>& values) {
  Histogram<60> expected{.upper = is.upper};
  for (const long double value : values) {
    const auto bin = static_cast<std::size_t>(value / is.upper * 60);
    ++expected.counts[std::min<std::size_t>(bin, 59)];
  }
  EXPECT_EQ(is.counts, expected.counts);
}

// Goal: the numbers are what the header says. Method: an implementation of its own, without
// neighbours, slots or histogram tricks, on meshes with nothing regular about them.
TEST(MeasureQuality, AgreesWithAnIndependentImplementation) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto made = testing::ImportedMesh(GridData(5, 5));
    testing::RandomEditor editor(*made, seed);
    for (int i = 0; i < 800; ++i) editor.Step();
    const MeshData data = ExportMesh(made->mesh).data;
    const Naive naive(data, &Wavy);
    const FunctionField field(&Wavy);
    const Quality quality = MeasureQuality(made->mesh, field);
    EXPECT_EQ(quality.vertex_count, made->mesh.vertex_count());
    EXPECT_EQ(quality.triangle_count, made->mesh.triangle_count());
    EXPECT_EQ(quality.edge_count, static_cast<std::int64_t>(naive.averaged.size()));
    EXPECT_NEAR(quality.q_mean, static_cast<double>(Mean(naive.qualities)), 1e-12);
    std::vector<long double> sorted = naive.qualities;
    std::sort(sorted.begin(), sorted.end());
    EXPECT_NEAR(quality.q_min, static_cast<double>(sorted.front()), 1e-12);
    EXPECT_NEAR(quality.q_percentile_1, static_cast<double>(sorted[sorted.size() / 100]), 1e-12);
    EXPECT_NEAR(quality.complexity, static_cast<double>(naive.complexity), 1e-10);
    ExpectStatistics(quality.averaged, naive.averaged);
    ExpectStatistics(quality.integrated, naive.integrated);
    ExpectHistogram(quality.lengths, naive.averaged);
    ExpectHistogram(quality.angles, naive.angles);
  }
}

TEST(MeasureQuality, OfPlainArraysIsThatOfTheMesh) {
  const auto made = testing::ImportedMesh(GridData(5, 5));
  testing::RandomEditor editor(*made, 77);
  for (int i = 0; i < 500; ++i) editor.Step();
  const FunctionField field(&Wavy);
  const Quality a = MeasureQuality(made->mesh, field);
  const Quality b = MeasureQuality(ExportMesh(made->mesh).data, field);
  EXPECT_EQ(a.q_mean, b.q_mean);
  EXPECT_EQ(a.q_min, b.q_min);
  EXPECT_EQ(a.angles, b.angles);
  EXPECT_EQ(a.lengths, b.lengths);
  EXPECT_EQ(a.edge_count, b.edge_count);
  EXPECT_NEAR(a.integrated.mean, b.integrated.mean, 1e-14) << "summed in another order";
}

// Goal: parts and helpers change no bit. Method: a mesh of several parts with free slots, measured
// in one go and by threads; then twice as many looks as there are parts.
TEST(QualityMeasurement, GivesTheBitsOfTheWholeWhoeverHelps) {
  const auto made = testing::ImportedMesh(GridData(60, 60));
  testing::RandomEditor editor(*made, 4);
  for (int i = 0; i < 3000; ++i) editor.Step();
  ASSERT_LT(made->mesh.triangle_count(), made->mesh.triangle_slots());
  const FunctionField field(&Wavy);
  const Quality whole = MeasureQuality(made->mesh, field);
  ThreadPool threads(3);
  InlineExecutor alone;
  for (Executor* helpers : {static_cast<Executor*>(&threads), static_cast<Executor*>(&alone)}) {
    QualityMeasurement measurement(made->mesh, field);
    int part_count = 1;
    while (measurement.Continue(*helpers)) ++part_count;
    EXPECT_GE(part_count, 3);
    EXPECT_FALSE(measurement.Continue(*helpers)) << "nothing is measured twice";
    EXPECT_EQ(measurement.Take(), whole);
  }
}

TEST(MeasureQuality, OfAnEquilateralTriangleIsOne) {
  MeshData data;
  data.points = {{0, 0}, {1, 0}, {0.5, testing::kEquilateralHeight}};
  data.triangles = {{0, 1, 2}};
  const Quality quality = MeasureQuality(data, FunctionField([](Vec2) { return Metric{1, 0, 1}; }));
  EXPECT_NEAR(quality.q_mean, 1, 1e-15);
  EXPECT_NEAR(quality.averaged.mean, 1, 1e-15);
  EXPECT_NEAR(quality.integrated.max, 1, 1e-15);
  EXPECT_EQ(quality.edge_count, 3);
  EXPECT_EQ(quality.averaged.share_125, 1);
  // Affine images are as good in the metric that goes with them.
  for (Vec2& p : data.points) p.x *= 10;
  const Quality image = MeasureQuality(data, FunctionField([](Vec2) {
                                         return Metric{0.01, 0, 1};
                                       }));
  EXPECT_NEAR(image.q_mean, 1, 1e-14);
}

}  // namespace
}  // namespace pliant
