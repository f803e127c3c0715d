#include "core/metric/saved_spec.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace pliant {
namespace {

using Source = decltype(MetricSpec::source);

std::vector<Source> OneOfEachKind() {
  BackgroundMetric background;
  background.mesh.points = {{0, 0}, {1, 0}, {0, 1}};
  background.mesh.triangles = {{0, 1, 2}};
  background.mesh.triangle_tags = {4};
  background.mesh.edges = {{0, 1}};
  background.mesh.edge_tags = {5};
  background.tensors.assign(3, Metric::Isotropic(0.5));
  const ExpressionMetric tensor{"1", "x", "y"};
  const SizeMetric size{"t"};
  return {tensor, size, background, IntersectedMetric{{size, background, tensor}}};
}

Bytes Written(const Source& source) {
  const MetricSpec spec{
      .source = source, .time = 3, .bounds = {0.1, 2, 5}, .gradation = {1.5, 0.2, 0.3}};
  ByteWriter writer;
  PutSpec(&spec, writer);
  return std::move(writer).Take();
}

TEST(SavedSpec, KeepsEverySpecification) {
  for (const Source& source : OneOfEachKind()) {
    const Bytes bytes = Written(source);
    ByteReader reader(bytes);
    const std::optional<MetricSpec> spec = TakeSpec(reader);
    ASSERT_TRUE(spec && reader.AtEnd()) << source.index();
    EXPECT_TRUE(spec->source == source) << source.index();
    EXPECT_EQ(spec->time, 3);
    EXPECT_EQ(spec->bounds, (SizeBounds{0.1, 2, 5}));
    EXPECT_EQ(spec->gradation.gradation, 1.5);
    EXPECT_EQ(spec->gradation.rotation, 0.2);
    EXPECT_EQ(spec->gradation.geometry, 0.3);
  }
}

// Goal: specifications that were stored before there were smoothing and gaps are read as they were
// meant.
TEST(SavedSpec, HasSmoothingAndGapsOnlyWhereTheyAreOn) {
  MetricSpec spec{.source = SizeMetric{"1"}, .gradation = {1.5, 0.2, 0.3}};
  const auto written = [&] {
    ByteWriter writer;
    PutSpec(&spec, writer);
    return std::move(writer).Take();
  };
  const Bytes without = written();
  spec.gradation.smoothing_count = 3;
  spec.gradation.gap_element_count = 2;
  const Bytes with = written();
  EXPECT_EQ(with.size(), without.size() + 20);
  for (const Bytes& bytes : {without, with}) {
    ByteReader reader(bytes);
    const std::optional<MetricSpec> found = TakeSpec(reader);
    ASSERT_TRUE(found && reader.AtEnd());
    EXPECT_EQ(found->gradation.smoothing_count, bytes == with ? 3 : 0);
    EXPECT_EQ(found->gradation.gap_element_count, bytes == with ? 2 : 0);
    EXPECT_EQ(found->gradation.geometry, 0.3);
  }
}

TEST(SavedSpec, KeepsThatThereIsNone) {
  ByteWriter writer;
  PutSpec(nullptr, writer);
  const Bytes bytes = std::move(writer).Take();
  ByteReader reader(bytes);
  EXPECT_EQ(TakeSpec(reader), std::nullopt);
  EXPECT_TRUE(reader.AtEnd());
}

// Goal: no beginning of the bytes passes for all of them.
TEST(SavedSpec, FailsWhereBytesEnd) {
  for (const Source& source : OneOfEachKind()) {
    const Bytes bytes = Written(source);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      ByteReader reader(std::span<const std::byte>(bytes).first(size));
      static_cast<void>(TakeSpec(reader));
      ASSERT_FALSE(reader.ok()) << "kind " << source.index() << ", " << size << " bytes";
    }
  }
}

TEST(SavedSpec, RefusesKindsThatDoNotExist) {
  for (const std::byte kind : {std::byte{5}, std::byte{255}}) {
    Bytes bytes = Written(SizeMetric{"1"});
    bytes[0] = kind;
    ByteReader reader(bytes);
    static_cast<void>(TakeSpec(reader));
    EXPECT_FALSE(reader.ok());
  }
}

}  // namespace
}  // namespace pliant
