#include "core/metric/metric_functions.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/rng.h"
#include "core/metric/background_field.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

constexpr BoundingBox kBox{{0, 0}, {4, 4}};
constexpr SizeBounds kBounds{.size_min = 0.05, .size_max = 1.5};

BackgroundMetric Tensors(double size) {
  BackgroundMetric background{testing::GridData(8, 8), {}};
  for (const Vec2 p : background.mesh.points) {
    background.tensors.push_back({1 / (size * size), 0.1 * p.x, 2 + p.y});
  }
  return background;
}

FunctionsSpec Example() {
  return {.parts = {SizeMetric{"0.2 + 0.2*x + t"}, Tensors(0.7),
                    ExpressionMetric{"1 + y", "0.2", "20"}},
          .before_count = 2,
          .time = 0.1};
}

std::shared_ptr<const MetricFunctions> Make(const FunctionsSpec& spec) {
  auto made = MetricFunctions::Make(spec, kBounds, kBox);
  EXPECT_TRUE(made.ok());
  return *std::move(made);
}

std::vector<Vec2> RandomPoints() {
  Rng rng(7);
  std::vector<Vec2> points;
  for (int i = 0; i < 300; ++i) points.push_back({rng.Uniform(-1, 5), rng.Uniform(-1, 5)});
  return points;
}

// Goal: what comes out is the intersection in the order sent, to the bit, at many points at once
// and at one. Method: against the intersected field with the tensors as a background mesh.
TEST(MetricFunctions, MeetTensorsAsAPartOfAnIntersectionDoes) {
  const FunctionsSpec spec = Example();
  const auto functions = Make(spec);
  MetricSpec whole{.time = spec.time, .bounds = kBounds};
  whole.source = IntersectedMetric{{spec.parts[0], spec.parts[1], Tensors(0.3), spec.parts[2]}};
  const auto expected = MakeMetricField(whole, kBox);
  ASSERT_TRUE(expected.ok());
  auto alone = BackgroundField::Make(Tensors(0.3), kBounds);
  ASSERT_TRUE(alone.ok());
  const std::shared_ptr<MetricField> tensors = *std::move(alone);
  const auto over = functions->Over(tensors);

  const std::vector<Vec2> points = RandomPoints();
  std::vector<Metric> met;
  std::int32_t hint = MetricField::kNoHint;
  for (const Vec2 p : points) met.push_back(tensors->At(p, hint));
  functions->MeetEach(points, met);
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::int32_t any = 0;
    EXPECT_EQ(met[i], (*expected)->At(points[i], any)) << i;
    EXPECT_EQ(met[i], over->At(points[i], any)) << i;
  }
  functions->MeetEach({}, {});
}

TEST(MetricFunctions, ComeBackFromBytesWithTheSameBits) {
  const auto functions = Make(Example());
  ByteWriter writer;
  functions->Save(writer);
  const Bytes bytes = std::move(writer).Take();
  ByteReader reader(bytes);
  const auto read = MetricFunctions::Read(reader);
  ASSERT_NE(read, nullptr);
  EXPECT_TRUE(reader.AtEnd());
  EXPECT_TRUE(read->IsMadeFrom(Example(), kBounds));
  EXPECT_FALSE(read->IsMadeFrom(Example(), {}));
  const std::vector<Vec2> points = RandomPoints();
  std::vector<Metric> first(points.size(), Metric::Isotropic(0.3));
  std::vector<Metric> second = first;
  functions->MeetEach(points, first);
  read->MeetEach(points, second);
  EXPECT_EQ(first, second);
  for (std::size_t size = 0; size < bytes.size(); size += 97) {
    ByteReader cut(std::span<const std::byte>(bytes).first(size));
    EXPECT_EQ(MetricFunctions::Read(cut), nullptr) << size;
    EXPECT_FALSE(cut.ok());
  }
}

TEST(MetricFunctions, RefuseWhatCannotBeOneAndSayWhichSource) {
  const auto error = [](FunctionsSpec spec) {
    const auto made = MetricFunctions::Make(std::move(spec), {}, kBox);
    EXPECT_FALSE(made.ok());
    return made.ok() ? Error{} : made.error();
  };
  EXPECT_EQ(error({}).code, ErrorCode::kEmpty);
  FunctionsSpec many;
  many.parts.assign(FunctionsSpec::kPartsMax + 1, SizeMetric{"1"});
  EXPECT_EQ(error(many).code, ErrorCode::kTooLarge);
  EXPECT_EQ(error({.parts = {SizeMetric{"1"}}, .before_count = 2}).code, ErrorCode::kOutOfRange);
  for (const std::size_t before_count : {0U, 1U, 2U}) {
    const Error syntax =
        error({.parts = {SizeMetric{"1"}, SizeMetric{"1 +"}}, .before_count = before_count});
    EXPECT_EQ(syntax.code, ErrorCode::kExpressionSyntax);
    const std::string source = before_count < 2 ? "metric.sources[2]: " : "metric.sources[1]: ";
    EXPECT_EQ(syntax.message.rfind(source, 0), 0U) << syntax.message;
  }
}

TEST(MetricFunctions, TellWhereTheyHaveNoValue) {
  const auto functions = Make({.parts = {SizeMetric{"0.5"}, SizeMetric{"sqrt(x - 1)"}}});
  EXPECT_TRUE(functions->status().ok());
  std::vector<Metric> tensors(1, Metric::Isotropic(0.3));
  const std::vector<Vec2> points{{0.5, 1}};
  functions->MeetEach(points, tensors);
  ASSERT_FALSE(functions->status().ok());
  EXPECT_EQ(functions->status().error().code, ErrorCode::kExpressionValue);
}

}  // namespace
}  // namespace pliant
