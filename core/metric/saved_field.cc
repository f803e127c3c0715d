#include "core/metric/saved_field.h"

#include <array>
#include <utility>
#include <vector>

#include "core/metric/background_field.h"
#include "core/metric/expression_field.h"
#include "core/metric/intersected_field.h"

namespace pliant {
namespace {

/// Rows of three numbers.
template <class Row, class Number>
std::vector<Row> Triples(ByteReader& reader) {
  const std::vector<Number> numbers = reader.TakeColumn<Number>();
  if (numbers.size() % 3 != 0) reader.Fail();
  std::vector<Row> rows;
  rows.reserve(numbers.size() / 3);
  for (std::size_t i = 0; i + 2 < numbers.size(); i += 3) {
    rows.push_back({numbers[i], numbers[i + 1], numbers[i + 2]});
  }
  return rows;
}

std::shared_ptr<MetricField> ReadBackground(ByteReader& reader) {
  const std::vector<double> numbers = reader.TakeColumn<double>();
  if (numbers.size() % 2 != 0) reader.Fail();
  std::vector<Vec2> points;
  points.reserve(numbers.size() / 2);
  for (std::size_t i = 0; i + 1 < numbers.size(); i += 2) {
    points.push_back({numbers[i], numbers[i + 1]});
  }
  const auto triangles = Triples<std::array<std::int32_t, 3>, std::int32_t>(reader);
  const auto logs = Triples<LogMetric, double>(reader);
  if (!reader.ok()) return nullptr;
  return BackgroundField::Restore(points, triangles, logs);
}

ExpressionField::Settings TakeSettings(ByteReader& reader) {
  ExpressionField::Settings settings;
  settings.time = reader.Take<double>();
  settings.bounds = TakeBounds(reader);
  settings.fallback.m11 = reader.Take<double>();
  settings.fallback.m12 = reader.Take<double>();
  settings.fallback.m22 = reader.Take<double>();
  return settings;
}

std::shared_ptr<MetricField> ReadTensorExpression(ByteReader& reader) {
  ExpressionMetric source;
  source.m11 = reader.TakeText();
  source.m12 = reader.TakeText();
  source.m22 = reader.TakeText();
  const ExpressionField::Settings settings = TakeSettings(reader);
  if (!reader.ok()) return nullptr;
  Result<std::unique_ptr<ExpressionField>> field = MakeTensorField(source, settings);
  return field.ok() ? std::move(*field) : nullptr;
}

std::shared_ptr<MetricField> ReadSizeExpression(ByteReader& reader) {
  const SizeMetric source{reader.TakeText()};
  const ExpressionField::Settings settings = TakeSettings(reader);
  if (!reader.ok()) return nullptr;
  Result<std::unique_ptr<ExpressionField>> field = MakeSizeField(source, settings);
  return field.ok() ? std::move(*field) : nullptr;
}

std::shared_ptr<MetricField> ReadOf(ByteReader& reader, SavedFieldKind kind);

std::shared_ptr<MetricField> ReadIntersected(ByteReader& reader) {
  const SizeBounds bounds = TakeBounds(reader);
  const auto count = reader.Take<std::uint32_t>();
  if (count == 0 || count > IntersectedMetric::kPartsMax) return nullptr;
  std::vector<std::shared_ptr<MetricField>> parts;
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto kind = static_cast<SavedFieldKind>(reader.Take<std::uint8_t>());
    // One inside another is never written, and bytes that go on so would never end.
    std::shared_ptr<MetricField> part =
        kind == SavedFieldKind::kIntersected ? nullptr : ReadOf(reader, kind);
    if (part == nullptr) return nullptr;
    parts.push_back(std::move(part));
  }
  return std::make_shared<IntersectedField>(std::move(parts), bounds);
}

std::shared_ptr<MetricField> ReadOf(ByteReader& reader, SavedFieldKind kind) {
  switch (kind) {
    case SavedFieldKind::kTensorExpression:
      return ReadTensorExpression(reader);
    case SavedFieldKind::kSizeExpression:
      return ReadSizeExpression(reader);
    case SavedFieldKind::kBackground:
      return ReadBackground(reader);
    case SavedFieldKind::kIntersected:
      return ReadIntersected(reader);
  }
  return nullptr;
}

}  // namespace

std::shared_ptr<MetricField> ReadField(ByteReader& reader) {
  const auto kind = static_cast<SavedFieldKind>(reader.Take<std::uint8_t>());
  std::shared_ptr<MetricField> field = ReadOf(reader, kind);
  if (!reader.ok()) field = nullptr;
  if (field == nullptr) reader.Fail();
  return field;
}

void PutFieldKind(SavedFieldKind kind, ByteWriter& writer) {
  writer.Put(static_cast<std::uint8_t>(kind));
}

void PutBounds(const SizeBounds& bounds, ByteWriter& writer) {
  writer.Put(bounds.size_min);
  writer.Put(bounds.size_max);
  writer.Put(bounds.anisotropy_max);
}

SizeBounds TakeBounds(ByteReader& reader) {
  SizeBounds bounds;
  bounds.size_min = reader.Take<double>();
  bounds.size_max = reader.Take<double>();
  bounds.anisotropy_max = reader.Take<double>();
  return bounds;
}

constexpr double kMoreFollows = -1;
constexpr double kIsAutomatic = -2;

void PutGradation(const GradationOptions& gradation, ByteWriter& writer) {
  writer.Put(gradation.gradation);
  writer.Put(gradation.rotation);
  // What came later follows numbers that `geometry` cannot be.
  if (gradation.automatic) writer.Put(kIsAutomatic);
  if (gradation.smoothing_count != 0 || gradation.gap_element_count != 0) {
    writer.Put(kMoreFollows);
    writer.Put(gradation.smoothing_count);
    writer.Put(gradation.gap_element_count);
  }
  writer.Put(gradation.geometry);
}

GradationOptions TakeGradation(ByteReader& reader) {
  GradationOptions gradation;
  gradation.gradation = reader.Take<double>();
  gradation.rotation = reader.Take<double>();
  gradation.geometry = reader.Take<double>();
  gradation.automatic = gradation.geometry == kIsAutomatic;
  if (gradation.automatic) gradation.geometry = reader.Take<double>();
  if (gradation.geometry == kMoreFollows) {
    gradation.smoothing_count = reader.Take<std::int32_t>();
    gradation.gap_element_count = reader.Take<double>();
    gradation.geometry = reader.Take<double>();
  }
  return gradation;
}

}  // namespace pliant
