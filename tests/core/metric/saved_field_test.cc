#include "core/metric/saved_field.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <memory>
#include <string>
#include <vector>

#include "core/base/rng.h"
#include "core/metric/background_field.h"
#include "core/metric/function_field.h"
#include "core/metric/metric_spec.h"
#include "tests/support/mesh_testing.h"

namespace pliant {
namespace {

using FieldPointer = std::shared_ptr<MetricField>;

FieldPointer FromSpec(const MetricSpec& spec) {
  return std::move(*MakeMetricField(spec, {{0, 0}, {4, 4}}));
}

/// A tensor of its own at every point of a grid of n x n cells.
BackgroundMetric Tensors(std::int32_t n, double size) {
  BackgroundMetric background{testing::GridData(n, n), {}};
  for (const Vec2 p : background.mesh.points) {
    background.tensors.push_back(Metric::Isotropic(size * (1 + 0.1 * p.x + 0.07 * p.y)));
  }
  return background;
}

Bytes Saved(const MetricField& field) {
  ByteWriter writer;
  const Status status = field.Save(writer);
  EXPECT_TRUE(status.ok()) << (status.ok() ? "" : status.error().message);
  return std::move(writer).Take();
}

FieldPointer Read(const Bytes& bytes) {
  ByteReader reader(bytes);
  FieldPointer field = ReadField(reader);
  EXPECT_TRUE(reader.AtEnd());
  return field;
}

void ExpectTheSameBits(const MetricField& a, const MetricField& b) {
  Rng rng(8);
  std::int32_t hint_a = MetricField::kNoHint;
  std::int32_t hint_b = MetricField::kNoHint;
  for (int i = 0; i < 300; ++i) {
    const Vec2 p{rng.Uniform(-1, 6), rng.Uniform(-1, 6)};
    const auto x = std::bit_cast<std::array<std::uint64_t, 3>>(a.At(p, hint_a));
    const auto y = std::bit_cast<std::array<std::uint64_t, 3>>(b.At(p, hint_b));
    ASSERT_EQ(x, y) << "at (" << p.x << ", " << p.y << ")";
  }
}

std::vector<FieldPointer> AllKinds() {
  MetricSpec size{.source = SizeMetric{"0.1 + 0.01*t*x"}, .time = 3};
  size.bounds = {.size_min = 0.11, .size_max = 0.2};
  const MetricSpec tensor{.source = ExpressionMetric{"100 + x^2", "sin(x*y)", "50 + exp(y)"}};
  MetricSpec background{.source = Tensors(4, 0.3)};
  background.bounds.size_min = 0.35;
  MetricSpec several{.source = IntersectedMetric{{SizeMetric{"0.4 - 0.02*x"}, Tensors(3, 0.3)}}};
  several.bounds.size_min = 0.35;
  return {FromSpec(size), FromSpec(tensor), FromSpec(background), FromSpec(several)};
}

TEST(SavedField, AnswersWithTheSameBits) {
  for (const FieldPointer& field : AllKinds()) {
    const Bytes bytes = Saved(*field);
    const FieldPointer back = Read(bytes);
    ASSERT_NE(back, nullptr);
    ExpectTheSameBits(*field, *back);
    EXPECT_EQ(Saved(*back), bytes);
    EXPECT_GT(field->bytes(), 0U);
  }
}

TEST(SavedField, AFieldOfTheCallersOwnIsRefused) {
  const FunctionField own([](Vec2) { return Metric::Isotropic(1); });
  ByteWriter writer;
  const Status status = own.Save(writer);
  ASSERT_FALSE(status.ok());
  EXPECT_EQ(status.error().code, ErrorCode::kUnimplemented);
  EXPECT_THAT(status.error().message, ::testing::HasSubstr("of the caller's own"));
}

TEST(SavedField, RefusesWhatIsCutOffAndKindsThatAreNone) {
  for (const FieldPointer& field : AllKinds()) {
    const Bytes bytes = Saved(*field);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      ByteReader reader(std::span<const std::byte>(bytes).first(size));
      EXPECT_EQ(ReadField(reader), nullptr);
      EXPECT_FALSE(reader.ok());
    }
  }
  // Intersections that hold themselves would read themselves for ever.
  ByteWriter nested;
  for (int depth = 0; depth < 100'000; ++depth) {
    PutFieldKind(SavedFieldKind::kIntersected, nested);
    PutBounds({}, nested);
    nested.Put(std::uint32_t{1});
  }
  const Bytes deep = std::move(nested).Take();
  ByteReader deep_reader(deep);
  EXPECT_EQ(ReadField(deep_reader), nullptr);
  const Bytes unknown{std::byte{77}, std::byte{0}};
  ByteReader reader(unknown);
  EXPECT_EQ(ReadField(reader), nullptr);
}

}  // namespace
}  // namespace pliant
