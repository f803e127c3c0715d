#include "core/metric/background_field.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/rng.h"

namespace pliant {
namespace {

using ::testing::HasSubstr;

/// The unit square in n x n cells of two triangles.
MeshData Grid(int n) {
  MeshData mesh;
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      mesh.points.push_back({static_cast<double>(i) / n, static_cast<double>(j) / n});
    }
  }
  for (std::int32_t j = 0; j < n; ++j) {
    for (std::int32_t i = 0; i < n; ++i) {
      const std::int32_t a = j * (n + 1) + i;
      mesh.triangles.push_back({a, a + 1, a + n + 2});
      mesh.triangles.push_back({a, a + n + 2, a + n + 1});
    }
  }
  return mesh;
}

/// A metric whose logarithm is linear in x and y, which interpolation must reproduce.
Metric Linear(Vec2 p) { return Exp(LogMetric{2 + p.x, 0.5 * p.y - p.x, 1 - p.y}); }

BackgroundMetric Example(int n) {
  BackgroundMetric metric;
  metric.mesh = Grid(n);
  for (const Vec2 p : metric.mesh.points) metric.tensors.push_back(Linear(p));
  return metric;
}

Metric Ask(const MetricField& field, Vec2 p) {
  std::int32_t hint = MetricField::kNoHint;
  return field.At(p, hint);
}

double Difference(const Metric& a, const Metric& b) {
  return std::max({std::abs(a.m11 - b.m11), std::abs(a.m12 - b.m12), std::abs(a.m22 - b.m22)});
}

Error Refusal(const BackgroundMetric& metric, const SizeBounds& bounds = {}) {
  const auto field = BackgroundField::Make(metric, bounds);
  EXPECT_FALSE(field.ok());
  return field.ok() ? Error{} : field.error();
}

TEST(BackgroundField, ReproducesALinearLogarithm) {
  const auto field = BackgroundField::Make(Example(7), {}).value();
  Rng rng(1996);
  for (int i = 0; i < 2000; ++i) {
    const Vec2 p = {rng.Unit(), rng.Unit()};
    EXPECT_LT(Difference(Ask(*field, p), Linear(p)), 1e-12) << p.x << " " << p.y;
  }
}

// Goal: the hint is a speed-up and nothing else. Method: compare bits under random hints.
TEST(BackgroundField, GivesTheSameBitsWithAnyHint) {
  const auto field = BackgroundField::Make(Example(9), {}).value();
  Rng rng(1996);
  for (int i = 0; i < 2000; ++i) {
    const Vec2 p = {rng.Uniform(-0.2, 1.2), rng.Uniform(-0.2, 1.2)};
    const Metric expected = Ask(*field, p);
    auto hint = static_cast<std::int32_t>(rng.Below(300)) - 20;
    EXPECT_EQ(field->At(p, hint), expected);
    EXPECT_EQ(field->At(p, hint), expected);
    EXPECT_GE(hint, 0);
  }
}

// Goal: many points at once get the same bits, and a point without a hint begins where the search
// for the one before it ended.
TEST(BackgroundField, AnswersManyPointsAsOne) {
  const auto field = BackgroundField::Make(Example(9), {}).value();
  Rng rng(7);
  std::vector<Vec2> points(50);
  for (Vec2& p : points) p = {rng.Uniform(-0.2, 1.2), rng.Uniform(-0.2, 1.2)};
  std::vector<std::int32_t> hints(points.size(), MetricField::kNoHint);
  hints[10] = 3;
  std::vector<Metric> metrics(points.size());
  field->AtEach(points, hints, metrics);
  std::int32_t hint = MetricField::kNoHint;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i == 10) hint = 3;
    EXPECT_EQ(metrics[i], field->At(points[i], hint));
    EXPECT_EQ(hints[i], hint) << i;
  }
}

// Goal: to fetch memory ahead is safe with whatever number a hint has, for kept hints may be those
// of another field.
// Goal: walks that go side by side lead where each would alone, in the mesh and outside.
TEST(BackgroundField, AnswersManyPointsWithHintsAsOne) {
  const auto field = BackgroundField::Make(Example(9), {}).value();
  Rng rng(12);
  std::vector<Vec2> points(150);
  std::vector<std::int32_t> hints(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i] = {rng.Uniform(-0.2, 1.2), rng.Uniform(-0.2, 1.2)};
    hints[i] = static_cast<std::int32_t>(rng.Below(162));
  }
  std::vector<Metric> metrics(points.size());
  field->AtEach(points, hints, metrics);
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::int32_t hint = MetricField::kNoHint;
    EXPECT_EQ(metrics[i], field->At(points[i], hint));
    EXPECT_EQ(hints[i], hint);
  }
}

TEST(BackgroundField, FetchesAheadWithAnyHint) {
  const auto field = BackgroundField::Make(Example(3), {}).value();
  for (const std::int32_t hint : {-1, 0, 1, 2, 1'000'000'000, INT32_MIN, INT32_MAX}) {
    field->PrefetchHint(hint);
    field->PrefetchBehindHint(hint);
  }
}

TEST(BackgroundField, HoldsTheNearestValueOutside) {
  const auto field = BackgroundField::Make(Example(4), {}).value();
  EXPECT_LT(Difference(Ask(*field, {0.3, 7}), Linear({0.3, 1})), 1e-12);
  EXPECT_LT(Difference(Ask(*field, {-5, -1}), Linear({0, 0})), 1e-12);
}

TEST(BackgroundField, IsNotLookedForOutsideItsBox) {
  const auto field = BackgroundField::Make(Example(4), {}).value();
  std::int32_t hint = MetricField::kNoHint;
  EXPECT_FALSE(field->Probe({0.3, 1.01}, hint).has_value());
  EXPECT_FALSE(field->Probe({-0.01, 0.5}, hint).has_value());
  for (const Vec2 p : {Vec2{0.3, 0.7}, Vec2{1, 1}}) {
    EXPECT_EQ(field->Probe(p, hint), field->At(p, hint));
  }
}

// Goal: many who look around get what each would get alone, those outside the box nothing.
TEST(BackgroundField, ProbesManyPointsAsOne) {
  const auto field = BackgroundField::Make(Example(9), {}).value();
  Rng rng(11);
  std::vector<MetricField::Question> questions(150);
  for (auto& one : questions) {
    one.place = {rng.Uniform(-0.2, 1.2), rng.Uniform(-0.2, 1.2)};
    one.hint = static_cast<std::int32_t>(rng.Below(40)) - 5;
    one.answer = Metric::Isotropic(1);
  }
  std::vector<MetricField::LogQuestion> log_questions;
  for (const auto& one : questions) log_questions.push_back({one.place, one.hint, LogMetric{}});
  field->ProbeEach(questions);
  field->ProbeLogEach(log_questions);
  for (std::size_t i = 0; i < questions.size(); ++i) {
    const auto& log = log_questions[i].answer;
    EXPECT_EQ(questions[i].answer, log ? std::optional(Exp(*log)) : std::nullopt);
    EXPECT_EQ(questions[i].hint, log_questions[i].hint);
  }
  std::int64_t outside = 0;
  for (const auto& one : questions) {
    std::int32_t hint = MetricField::kNoHint;
    EXPECT_EQ(one.answer, field->Probe(one.place, hint));
    if (one.answer) {
      EXPECT_EQ(one.hint, hint);
    }
    outside += one.answer ? 0 : 1;
  }
  EXPECT_GT(outside, 20);
  EXPECT_LT(outside, 130);
}

TEST(BackgroundField, KeepsTheBoundsInBetween) {
  BackgroundMetric metric = Example(3);
  Rng rng(1996);
  for (Metric& tensor : metric.tensors) {
    const double t = rng.Uniform(0, 3);
    tensor = MetricFromAxes({std::pow(10, rng.Uniform(-1, 2)),
                             std::pow(10, rng.Uniform(-4, -1)),
                             {std::cos(t), std::sin(t)}});
  }
  const SizeBounds bounds = {.size_min = 0.01, .size_max = 2, .anisotropy_max = 20};
  const auto field = BackgroundField::Make(metric, bounds).value();
  for (int i = 0; i < 2000; ++i) {
    const MetricAxes axes = AxesFromMetric(Ask(*field, {rng.Unit(), rng.Unit()}));
    ASSERT_GT(axes.minor_radius, 0.01 * (1 - 1e-9));
    ASSERT_LT(axes.major_radius, 2 * (1 + 1e-9));
    ASSERT_LT(axes.major_radius / axes.minor_radius, 20 * (1 + 1e-9));
  }
}

TEST(BackgroundField, AdmitsSemiDefiniteTensorsWithASizeMax) {
  BackgroundMetric metric = Example(1);
  metric.tensors[2] = {1, 1, 1};
  EXPECT_EQ(Refusal(metric).code, ErrorCode::kNotPositiveDefinite);
  EXPECT_TRUE(BackgroundField::Make(metric, {.size_max = 10}).ok());
  metric.tensors[2] = {1, 2, 1};
  EXPECT_EQ(Refusal(metric, {.size_max = 10}).code, ErrorCode::kNotPositiveDefinite);
}

TEST(BackgroundField, NamesTheFirstBadTensor) {
  BackgroundMetric metric = Example(2);
  metric.tensors[5].m12 = std::numeric_limits<double>::quiet_NaN();
  metric.tensors[7] = {-1e-8, 0, 1};
  Error error = Refusal(metric);
  EXPECT_EQ(error.code, ErrorCode::kNotFinite);
  EXPECT_EQ(error.field, "metric.tensors");
  EXPECT_EQ(error.index, 5);
  metric.tensors[5] = {};
  error = Refusal(metric);
  EXPECT_EQ(error.code, ErrorCode::kNotPositiveDefinite);
  EXPECT_EQ(error.index, 7);
  EXPECT_THAT(error.message, HasSubstr("eigenvalues -1e-08 and 1"));
  metric.tensors.pop_back();
  EXPECT_EQ(Refusal(metric).code, ErrorCode::kArrayLength);
}

TEST(BackgroundField, NamesTheFirstBadPartOfTheMesh) {
  const auto refuse = [](auto change) {
    BackgroundMetric metric = Example(2);
    change(metric.mesh);
    return Refusal(metric);
  };
  Error error = refuse([](MeshData& m) { m.points[3].y = std::nan(""); });
  EXPECT_EQ(error.code, ErrorCode::kNotFinite);
  EXPECT_EQ(error.field, "metric.mesh.points");
  EXPECT_EQ(error.index, 3);
  EXPECT_EQ(refuse([](MeshData& m) { m.triangles.clear(); }).code, ErrorCode::kEmpty);
  for (const std::int32_t bad : {-1, 9}) {
    error = refuse([&](MeshData& m) { m.triangles[2][1] = bad; });
    EXPECT_EQ(error.code, ErrorCode::kIndexOutOfRange);
    EXPECT_EQ(error.field, "metric.mesh.triangles");
    EXPECT_EQ(error.index, 2);
  }
  error = refuse([](MeshData& m) { m.triangles[4][0] = m.triangles[4][1]; });
  EXPECT_EQ(error.code, ErrorCode::kTriangleDegenerate);
  EXPECT_EQ(error.index, 4);
  error = refuse([](MeshData& m) { std::swap(m.triangles[6][0], m.triangles[6][1]); });
  EXPECT_EQ(error.code, ErrorCode::kTriangleOrientation);
  EXPECT_EQ(error.index, 6);
  error = refuse([](MeshData& m) { m.triangles.push_back(m.triangles[1]); });
  EXPECT_EQ(error.code, ErrorCode::kNonManifoldEdge);
  EXPECT_EQ(error.index, 1);
  EXPECT_EQ(error.other_index, 8);
}

}  // namespace
}  // namespace pliant
