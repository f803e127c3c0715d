#include "core/metric/solution_metric.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "core/mesh/export_mesh.h"
#include "core/pliant/remesher.h"
#include "tests/support/cases.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using Function = std::function<double(Vec2)>;

double Shock(Vec2 p) { return std::tanh(40 * (p.x - 0.5 + 0.2 * (p.y - 0.5) * (p.y - 0.5))); }
double Layer(Vec2 p) { return std::exp(-30 * p.y) + 0.2 * p.x * p.x; }
double Gaussian(Vec2 p) {
  const Vec2 d = p - Vec2{0.45, 0.55};
  return std::exp(-40 * Dot(d, d));
}

std::vector<double> ValuesOf(const MeshData& mesh, const Function& f) {
  std::vector<double> values;
  for (const Vec2 p : mesh.points) values.push_back(f(p));
  return values;
}

/// What a user does: adapt to the solution on the mesh so far, evaluate it on the new one, repeat.
ExportedMesh Adapted(const std::vector<Function>& fields, const SolutionTarget& target) {
  MetricSpec spec;
  spec.source = SizeMetric{"0.05"};
  auto made = Remesher::Create(testing::Rectangle({0, 0}, {1, 1}), spec, {});
  PLIANT_CHECK(made.ok() && (*made)->Step({}).ok());
  (void)(*made)->Commit();
  for (int round = 0; round < 6; ++round) {
    const ExportedMesh mesh = ExportMesh((*made)->mesh());
    std::vector<std::vector<double>> values;
    for (const Function& f : fields) values.push_back(ValuesOf(mesh.data, f));
    const auto metric = MetricOfSolution(mesh.data, values, target);
    PLIANT_CHECK(metric.ok(), "error", metric.error().message);
    PLIANT_CHECK((*made)->SetTensors({}, *metric).ok() && (*made)->Step({}).ok());
    (void)(*made)->Commit();
  }
  return ExportMesh((*made)->mesh());
}

/// L1 or L2 norm of f less its linear interpolant, on 64 subtriangles of each triangle.
double InterpolationError(const MeshData& mesh, const Function& f, int exponent) {
  constexpr int kCuts = 8;
  double sum = 0;
  for (const auto& [ia, ib, ic] : mesh.triangles) {
    const Vec2 a = mesh.points[static_cast<std::size_t>(ia)];
    const Vec2 b = mesh.points[static_cast<std::size_t>(ib)] - a;
    const Vec2 c = mesh.points[static_cast<std::size_t>(ic)] - a;
    const double area = 0.5 * Cross(b, c) / (kCuts * kCuts);
    const double fa = f(a);
    const double fb = f(a + b) - fa;
    const double fc = f(a + c) - fa;
    const auto add = [&](double s, double t) {
      const double e = std::fabs(f(a + s * b + t * c) - (fa + s * fb + t * fc));
      sum += area * (exponent == 1 ? e : e * e);
    };
    for (int i = 0; i < kCuts; ++i) {
      for (int j = 0; i + j < kCuts; ++j) {
        add((i + 1.0 / 3) / kCuts, (j + 1.0 / 3) / kCuts);
        if (i + j + 1 < kCuts) add((i + 2.0 / 3) / kCuts, (j + 2.0 / 3) / kCuts);
      }
    }
  }
  return exponent == 1 ? sum : std::sqrt(sum);
}

struct Feature {
  const char* name;
  Function f;
};
const std::vector<Feature>& Features() {
  static const std::vector<Feature> features{
      {"layer", Layer}, {"shock", Shock}, {"Gaussian", Gaussian}};
  return features;
}

// Goal: the error that is promised: for each function it falls like 1 / N, in L1 and in L2, which
// no mesh of N vertices can better, and the vertex count is what the complexity says.
TEST(MetricOfSolution, MakesTheErrorFallAtTheOptimalRate) {
  for (const Feature& feature : Features()) {
    for (const int exponent : {1, 2}) {
      SCOPED_TRACE(::testing::Message() << feature.name << " in L" << exponent);
      std::vector<double> log_counts;
      std::vector<double> log_errors;
      for (const double complexity : {400.0, 800.0, 1600.0, 3200.0}) {
        SolutionTarget target{.target = TargetComplexity{complexity}};
        target.norm_exponent = exponent;
        const ExportedMesh mesh = Adapted({feature.f}, target);
        const auto triangles = static_cast<double>(mesh.data.triangles.size());
        // Small meshes have a few more, because of their boundary.
        EXPECT_NEAR(triangles * std::sqrt(3) / 4 / complexity, 1, complexity > 1000 ? 0.05 : 0.08)
            << complexity;
        log_counts.push_back(std::log(static_cast<double>(mesh.data.points.size())));
        log_errors.push_back(std::log(InterpolationError(mesh.data, feature.f, exponent)));
      }
      // The slope of the line of least squares.
      double nx = 0;
      double ny = 0;
      double xx = 0;
      double xy = 0;
      for (std::size_t i = 0; i < log_counts.size(); ++i) {
        nx += log_counts[i] / 4;
        ny += log_errors[i] / 4;
      }
      for (std::size_t i = 0; i < log_counts.size(); ++i) {
        xx += (log_counts[i] - nx) * (log_counts[i] - nx);
        xy += (log_counts[i] - nx) * (log_errors[i] - ny);
      }
      EXPECT_LT(xy / xx, -0.93);
      EXPECT_GT(xy / xx, -1.25);
    }
  }
}

// Goal: a wanted error is what comes out, by the model within a third.
TEST(MetricOfSolution, ReachesAWantedError) {
  for (const Feature& feature : Features()) {
    SolutionTarget target{.target = TargetError{2e-3}};
    target.norm_exponent = 1;
    const double error = InterpolationError(Adapted({feature.f}, target).data, feature.f, 1);
    EXPECT_GT(error, 2e-3 * 0.5) << feature.name;
    EXPECT_LT(error, 2e-3 * 1.33) << feature.name;
  }
}

TEST(MetricOfSolution, IntersectsFieldsAndKeepsTheTargetWithBounds) {
  const MeshData mesh = [] {
    MeshData data = testing::GridData(60, 60);
    for (Vec2& p : data.points) p = {p.x / 60, p.y / 60};
    return data;
  }();
  SolutionTarget target{.target = TargetComplexity{2000}};
  target.bounds = {.size_min = 0.01, .size_max = 0.1, .anisotropy_max = 10};
  const std::vector<std::vector<double>> both{ValuesOf(mesh, Shock), ValuesOf(mesh, Layer)};
  const auto metric = MetricOfSolution(mesh, both, target);
  ASSERT_TRUE(metric.ok());
  EXPECT_NEAR(ComplexityOf(mesh, *metric), 2000, 1e-3);
  for (const Metric& tensor : *metric) {
    const MetricAxes axes = AxesFromMetric(tensor);
    EXPECT_GE(axes.minor_radius, 0.01 * (1 - 1e-12));
    EXPECT_LE(axes.major_radius, 0.1 * (1 + 1e-12));
    EXPECT_LE(axes.major_radius, 10 * axes.minor_radius * (1 + 1e-9));
  }
  // Without bounds the intersection is as fine, in every direction, as a common multiple of each.
  target.bounds = {};
  const auto intersected = MetricOfSolution(mesh, both, target);
  ASSERT_TRUE(intersected.ok());
  for (const auto& field : both) {
    const auto single = MetricOfSolution(mesh, std::span(&field, 1), target);
    ASSERT_TRUE(single.ok());
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < single->size(); ++i) {
      for (const Vec2 d : {Vec2{1, 0}, Vec2{0, 1}, Vec2{1, 1}, Vec2{1, -1}}) {
        least =
            std::min(least, SquaredLength((*intersected)[i], d) / SquaredLength((*single)[i], d));
      }
    }
    EXPECT_GT(least, 0.2);
    EXPECT_LT(least, 1);
  }
}

TEST(MetricOfSolution, GivesAConstantFieldAUniformMetric) {
  const MeshData mesh = testing::GridData(10, 10);
  const std::vector<std::vector<double>> fields{std::vector<double>(mesh.points.size(), 3.0)};
  const auto metric = MetricOfSolution(mesh, fields, {.target = TargetComplexity{400}});
  ASSERT_TRUE(metric.ok());
  for (const Metric& tensor : *metric) {
    EXPECT_NEAR(tensor.m11, 4, 1e-12);
    EXPECT_NEAR(tensor.m12, 0, 1e-12);
    EXPECT_NEAR(tensor.m22, 4, 1e-12);
  }
}

// Method: against the closed form of the integral of an exponential along one direction.
TEST(ComplexityOf, IntegratesAMetricThatIsLogEuclideanBetweenVertices) {
  MeshData mesh = testing::GridData(4, 4);
  std::vector<Metric> tensors;
  for (const Vec2 p : mesh.points) tensors.push_back(Metric::Isotropic(std::exp(-0.4 * p.x)));
  // sqrt(det) = exp(0.8 x).
  EXPECT_NEAR(ComplexityOf(mesh, tensors) / (4 * (std::exp(3.2) - 1) / 0.8), 1, 1e-7);
}

TEST(MetricOfSolution, RefusesWhatItCannotUse) {
  const MeshData mesh = testing::GridData(3, 3);
  const std::vector<std::vector<double>> good{std::vector<double>(16, 1.0)};
  const auto code = [&](std::vector<std::vector<double>> fields, const SolutionTarget& target) {
    const auto result = MetricOfSolution(mesh, fields, target);
    return result.ok() ? ErrorCode::kInternal : result.error().code;
  };
  EXPECT_EQ(code({}, {}), ErrorCode::kEmpty);
  EXPECT_EQ(code({std::vector<double>(15, 1.0)}, {}), ErrorCode::kArrayLength);
  EXPECT_EQ(code(good, {.norm_exponent = 0.5}), ErrorCode::kOutOfRange);
  EXPECT_EQ(code(good, {.target = TargetComplexity{0}}), ErrorCode::kOutOfRange);
  EXPECT_EQ(code(good, {.target = TargetError{-1}}), ErrorCode::kOutOfRange);
  auto bad = good;
  bad[0][7] = std::numeric_limits<double>::infinity();
  const auto refused = MetricOfSolution(mesh, bad, {});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kNotFinite);
  EXPECT_EQ(refused.error().index, 7);
}

}  // namespace
}  // namespace pliant
