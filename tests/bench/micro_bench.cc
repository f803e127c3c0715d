// Small pieces of the core: predicates, elementary functions, metrics and fields. Inputs are drawn
// once, from a fixed seed, and used in turn, so that no branch is learned by heart.
#include <benchmark/benchmark.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/base/math.h"
#include "core/base/rng.h"
#include "core/delaunay/triangulate.h"
#include "core/geometry/predicates.h"
#include "core/mesh/export_mesh.h"
#include "core/metric/background_field.h"
#include "core/metric/metric.h"
#include "core/metric/metric_spec.h"
#include "core/pliant/quality.h"
#include "core/pliant/remesher.h"
#include "tests/support/cases.h"

namespace pliant {
namespace {

constexpr std::size_t kInputs = 4096;

std::vector<Vec2> RandomPoints(std::size_t count, std::uint64_t seed) {
  Rng rng(seed);
  std::vector<Vec2> points(count);
  for (Vec2& p : points) p = {rng.Uniform(-3, 3), rng.Uniform(-3, 3)};
  return points;
}

/// The numbers 0, 1, ..., kInputs - 1, over and over.
class Turn {
 public:
  std::size_t Next() { return next_++ % kInputs; }

 private:
  std::size_t next_ = 0;
};

void BM_Orient2d(benchmark::State& state) {
  const auto points = RandomPoints(kInputs + 2, 1);
  Turn turn;
  for (auto _ : state) {
    const std::size_t i = turn.Next();
    benchmark::DoNotOptimize(Orient2d(points[i], points[i + 1], points[i + 2]));
  }
}
BENCHMARK(BM_Orient2d);

// Points of an integer grid on one line: the filter is never sure.
void BM_Orient2dCollinear(benchmark::State& state) {
  std::vector<Vec2> points;
  for (std::size_t i = 0; i < kInputs + 2; ++i) {
    const auto t = static_cast<double>(i) / 3;
    points.push_back({t, t});
  }
  Turn turn;
  for (auto _ : state) {
    const std::size_t i = turn.Next();
    benchmark::DoNotOptimize(Orient2d(points[i], points[i + 1], points[i + 2]));
  }
}
BENCHMARK(BM_Orient2dCollinear);

void BM_InCircle(benchmark::State& state) {
  const auto points = RandomPoints(kInputs + 3, 2);
  Turn turn;
  for (auto _ : state) {
    const std::size_t i = turn.Next();
    benchmark::DoNotOptimize(InCircle(points[i], points[i + 1], points[i + 2], points[i + 3]));
  }
}
BENCHMARK(BM_InCircle);

// The corners of a square: exactly on the circle.
void BM_InCircleCocircular(benchmark::State& state) {
  const auto corners = RandomPoints(kInputs, 3);
  Turn turn;
  for (auto _ : state) {
    const Vec2 p = corners[turn.Next()];
    benchmark::DoNotOptimize(InCircle(p, {-p.y, p.x}, {-p.x, -p.y}, {p.y, -p.x}));
  }
}
BENCHMARK(BM_InCircleCocircular);

void BM_Exp(benchmark::State& state) {
  const auto points = RandomPoints(kInputs, 4);
  Turn turn;
  for (auto _ : state) benchmark::DoNotOptimize(Exp(3 * points[turn.Next()].x));
}
BENCHMARK(BM_Exp);

void BM_ExpNegative(benchmark::State& state) {
  const auto points = RandomPoints(kInputs, 5);
  Turn turn;
  for (auto _ : state) benchmark::DoNotOptimize(ExpNegative(points[turn.Next()].x - 3));
}
BENCHMARK(BM_ExpNegative);

void BM_Log(benchmark::State& state) {
  const auto points = RandomPoints(kInputs, 6);
  Turn turn;
  for (auto _ : state) benchmark::DoNotOptimize(Log(points[turn.Next()].x + 3.001));
}
BENCHMARK(BM_Log);

std::vector<Metric> GaussianMetrics() {
  const auto gaussian = testing::GaussianCase(10'000);
  std::vector<Metric> metrics;
  std::int32_t hint = MetricField::kNoHint;
  for (const Vec2 p : RandomPoints(kInputs, 7)) metrics.push_back(gaussian.field->At(p, hint));
  return metrics;
}

void BM_MetricLog(benchmark::State& state) {
  const auto metrics = GaussianMetrics();
  Turn turn;
  for (auto _ : state) benchmark::DoNotOptimize(Log(metrics[turn.Next()]));
}
BENCHMARK(BM_MetricLog);

void BM_MetricExp(benchmark::State& state) {
  std::vector<LogMetric> logs;
  for (const Metric& metric : GaussianMetrics()) logs.push_back(Log(metric));
  Turn turn;
  for (auto _ : state) benchmark::DoNotOptimize(Exp(logs[turn.Next()]));
}
BENCHMARK(BM_MetricExp);

/// Asks a field at random points, which is what it costs without locality but with a warm cache.
void AskField(benchmark::State& state, const MetricField& field, const std::vector<Vec2>& points) {
  std::vector<std::int32_t> hints(points.size(), MetricField::kNoHint);
  for (std::size_t i = 0; i < kInputs; ++i) {
    benchmark::DoNotOptimize(field.At(points[i], hints[i]));
  }
  Turn turn;
  for (auto _ : state) {
    const std::size_t i = turn.Next();
    benchmark::DoNotOptimize(field.At(points[i], hints[i]));
  }
}

void BM_FieldGaussianAnalytic(benchmark::State& state) {
  AskField(state, *testing::GaussianCase(10'000).field, RandomPoints(kInputs, 8));
}
BENCHMARK(BM_FieldGaussianAnalytic);

void BM_FieldGaussianExpression(benchmark::State& state) {
  const ExpressionMetric formulas{.m11 = "1344*max(0.01,exp(-(x^2+y^2)/2)*abs(x^2-1))+1",
                                  .m12 = "1344*exp(-(x^2+y^2)/2)*x*y*0.1",
                                  .m22 = "1344*max(0.01,exp(-(x^2+y^2)/2)*abs(y^2-1))+1"};
  const auto field =
      MakeMetricField({.source = formulas, .bounds = {.size_max = 10}}, {{-3, -3}, {3, 3}});
  if (!field.ok()) {
    state.SkipWithError(field.error().message.c_str());
    return;
  }
  AskField(state, **field, RandomPoints(kInputs, 9));
}
BENCHMARK(BM_FieldGaussianExpression);

/// The finished mesh of case A.
std::unique_ptr<Remesher> GaussianMesh(double nodes) {
  auto gaussian = testing::GaussianCase(nodes);
  auto remesher = Remesher::Create(gaussian.domain, std::move(gaussian.field), {});
  PLIANT_CHECK(remesher.ok() && (*remesher)->Step({}).ok());
  (void)(*remesher)->Commit();
  return std::move(*remesher);
}

void BM_FieldBackground(benchmark::State& state) {
  const auto remesher = GaussianMesh(static_cast<double>(state.range(0)));
  BackgroundMetric background{.mesh = ExportMesh(remesher->mesh()).data, .tensors = {}};
  std::int32_t hint = MetricField::kNoHint;
  for (const Vec2 p : background.mesh.points) {
    background.tensors.push_back(remesher->field().At(p, hint));
  }
  const auto field = BackgroundField::Make(background, {});
  PLIANT_CHECK(field.ok());
  AskField(state, **field, RandomPoints(kInputs, 10));
}
BENCHMARK(BM_FieldBackground)->Arg(10'000)->Arg(100'000);

void BM_Quality(benchmark::State& state) {
  const auto remesher = GaussianMesh(static_cast<double>(state.range(0)));
  for (auto _ : state) {
    benchmark::DoNotOptimize(MeasureQuality(remesher->mesh(), remesher->field()));
  }
  state.SetItemsProcessed(state.iterations() * remesher->mesh().vertex_count());
}
BENCHMARK(BM_Quality)->Arg(10'000)->Unit(benchmark::kMillisecond);

void BM_Triangulate(benchmark::State& state) {
  Domain domain = testing::Rectangle({-4, -4}, {4, 4});
  for (const Vec2 p : RandomPoints(static_cast<std::size_t>(state.range(0)), 11)) {
    domain.points.push_back(p);
  }
  for (auto _ : state) {
    auto mesh = TriangulateDomain(domain);
    PLIANT_CHECK(mesh.ok());
    benchmark::DoNotOptimize(mesh);
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(BM_Triangulate)->Arg(10'000)->Arg(100'000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace pliant
