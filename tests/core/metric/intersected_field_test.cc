#include "core/metric/intersected_field.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "core/base/rng.h"
#include "core/metric/metric_spec.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

constexpr BoundingBox kBox{{0, 0}, {4, 4}};

BackgroundMetric Tensors(double size) {
  BackgroundMetric background{testing::GridData(8, 8), {}};
  for (const Vec2 p : background.mesh.points) {
    background.tensors.push_back({1 / (size * size), 0.1 * p.x, 2 + p.y});
  }
  return background;
}

MetricSpec Example() {
  return {.source = IntersectedMetric{{Tensors(0.3), SizeMetric{"0.2 + 0.2*x"},
                                       ExpressionMetric{"1 + y", "0.2", "20"}, Tensors(0.7)}}};
}

std::unique_ptr<MetricField> Make(const MetricSpec& spec) {
  auto field = MakeMetricField(spec, kBox);
  EXPECT_TRUE(field.ok());
  return std::move(*field);
}

// Goal: the finest holds in every direction, and no finer than needed.
// Method: 64 directions at random points; of two of the parts that do not cross, the finer is the
// answer.
TEST(IntersectedField, IsAsFineAsEveryPartInEveryDirection) {
  const MetricSpec spec = Example();
  const auto field = Make(spec);
  std::vector<std::unique_ptr<MetricField>> parts;
  for (const PlainMetric& part : std::get<IntersectedMetric>(spec.source).parts) {
    MetricSpec alone;
    std::visit([&](const auto& source) { alone.source = source; }, part);
    parts.push_back(Make(alone));
  }
  Rng rng(5);
  std::int32_t hint = MetricField::kNoHint;
  for (int i = 0; i < 500; ++i) {
    const Vec2 p{rng.Uniform(0, 4), rng.Uniform(0, 4)};
    const Metric metric = field->At(p, hint);
    for (const auto& part : parts) {
      std::int32_t near = MetricField::kNoHint;
      const Metric alone = part->At(p, near);
      for (int k = 0; k < 64; ++k) {
        const Vec2 e{std::cos(0.05 * k), std::sin(0.05 * k)};
        EXPECT_GE(SquaredLength(metric, e), (1 - 1e-9) * SquaredLength(alone, e)) << i;
      }
    }
  }
}

TEST(IntersectedField, TakesTheFinerOfTwoSizes) {
  const auto field = Make({.source = IntersectedMetric{{SizeMetric{"0.1"}, SizeMetric{"x"}}}});
  std::int32_t hint = MetricField::kNoHint;
  EXPECT_LT(RelativeChange(Metric::Isotropic(0.05), field->At({0.05, 1}, hint)), 1e-12);
  EXPECT_LT(RelativeChange(Metric::Isotropic(0.1), field->At({3, 1}, hint)), 1e-12);
}

// Goal: two thin ellipses across each other meet in one that is smaller than either is thin.
TEST(IntersectedField, KeepsTheBounds) {
  const ExpressionMetric a{"100", "0", "1"};
  const ExpressionMetric b{"50.5", "49.5", "50.5"};
  MetricSpec spec{.source = IntersectedMetric{{a, b}}};
  std::int32_t hint = MetricField::kNoHint;
  const Eigenvalues free = EigenvaluesOf(Make(spec)->At({1, 1}, hint));
  EXPECT_GT(free.high, 101);
  spec.bounds.size_min = 0.1;
  EXPECT_NEAR(EigenvaluesOf(Make(spec)->At({1, 1}, hint)).high, 100, 1e-9);
}

// Goal: hints decide nothing. Method: the same questions in another order, with other hints.
TEST(IntersectedField, GivesTheSameBitsWithAnyHint) {
  const auto first = Make(Example());
  const auto second = Make(Example());
  Rng rng(6);
  std::vector<Vec2> points;
  for (int i = 0; i < 500; ++i) points.push_back({rng.Uniform(-1, 5), rng.Uniform(-1, 5)});
  std::vector<Metric> answers;
  std::int32_t hint = MetricField::kNoHint;
  for (const Vec2 p : points) answers.push_back(first->At(p, hint));
  for (std::size_t i = points.size(); i-- > 0;) {
    hint = static_cast<std::int32_t>(rng.Below(200)) - 20;
    EXPECT_EQ(second->At(points[i], hint), answers[i]);
  }
}

TEST(IntersectedField, NamesThePartThatIsWrong) {
  const auto refusal = [](std::vector<PlainMetric> parts) {
    const auto field = MakeMetricField({.source = IntersectedMetric{std::move(parts)}}, kBox);
    EXPECT_FALSE(field.ok());
    return field.ok() ? Error{} : field.error();
  };
  const Error syntax = refusal({SizeMetric{"1"}, SizeMetric{"1 +"}});
  EXPECT_EQ(syntax.code, ErrorCode::kExpressionSyntax);
  EXPECT_EQ(syntax.field, "metric.size");
  EXPECT_EQ(syntax.message.find("metric.sources[1]: "), 0U) << syntax.message;
  EXPECT_EQ(refusal({}).code, ErrorCode::kEmpty);
  EXPECT_EQ(refusal(std::vector<PlainMetric>(17, SizeMetric{"1"})).code, ErrorCode::kTooLarge);
}

TEST(IntersectedField, ReportsAPartWithoutAValue) {
  const auto field =
      Make({.source = IntersectedMetric{{SizeMetric{"1"}, SizeMetric{"x < 1 ? 1 : -1"}}}});
  std::int32_t hint = MetricField::kNoHint;
  static_cast<void>(field->At({0.5, 1}, hint));
  EXPECT_TRUE(field->status().ok());
  EXPECT_FALSE(field->Probe({2, 1}, hint).has_value());
  EXPECT_TRUE(field->status().ok()) << "who only looks around leaves no trace";
  static_cast<void>(field->At({2, 1}, hint));
  ASSERT_FALSE(field->status().ok());
  EXPECT_EQ(field->status().error().code, ErrorCode::kExpressionValue);
}

}  // namespace
}  // namespace pliant
