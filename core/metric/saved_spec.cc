#include "core/metric/saved_spec.h"

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>

#include "core/base/row_bytes.h"
#include "core/metric/saved_field.h"

namespace pliant {
namespace {

// Part of the format: add, never renumber.
enum class SpecKind : std::uint8_t {
  kNone = 0,
  kTensor = 1,
  kSize = 2,
  kBackground = 3,
  kIntersected = 4,
};

SpecKind TakeKind(ByteReader& reader) { return static_cast<SpecKind>(reader.Take<std::uint8_t>()); }
void PutKind(SpecKind kind, ByteWriter& writer) { writer.Put(static_cast<std::uint8_t>(kind)); }

void PutSource(const ExpressionMetric& tensor, ByteWriter& writer) {
  PutKind(SpecKind::kTensor, writer);
  for (const std::string* text : {&tensor.m11, &tensor.m12, &tensor.m22}) writer.PutText(*text);
}

void PutSource(const SizeMetric& size, ByteWriter& writer) {
  PutKind(SpecKind::kSize, writer);
  writer.PutText(size.size);
}

void PutSource(const BackgroundMetric& background, ByteWriter& writer) {
  PutKind(SpecKind::kBackground, writer);
  PutMeshData(background.mesh, writer);
  PutRows<double>(background.tensors, writer);
}

void PutSource(const IntersectedMetric& intersected, ByteWriter& writer) {
  PutKind(SpecKind::kIntersected, writer);
  writer.Put(static_cast<std::uint32_t>(intersected.parts.size()));
  for (const PlainMetric& part : intersected.parts) {
    std::visit([&](const auto& source) { PutSource(source, writer); }, part);
  }
}

PlainMetric TakePlain(SpecKind kind, ByteReader& reader) {
  if (kind == SpecKind::kTensor) {
    ExpressionMetric tensor;
    for (std::string* text : {&tensor.m11, &tensor.m12, &tensor.m22}) *text = reader.TakeText();
    return tensor;
  }
  if (kind == SpecKind::kSize) return SizeMetric{reader.TakeText()};
  if (kind != SpecKind::kBackground) reader.Fail();
  BackgroundMetric background;
  background.mesh = TakeMeshData(reader);
  background.tensors = TakeRows<double, Metric>(reader);
  return background;
}

IntersectedMetric TakeIntersected(ByteReader& reader) {
  IntersectedMetric intersected;
  const auto count = reader.Take<std::uint32_t>();
  for (std::uint32_t i = 0; i < count && reader.ok(); ++i) {
    intersected.parts.push_back(TakePlain(TakeKind(reader), reader));
  }
  return intersected;
}

}  // namespace

void PutSpec(const MetricSpec* spec, ByteWriter& writer) {
  if (spec == nullptr) return PutKind(SpecKind::kNone, writer);
  std::visit([&](const auto& source) { PutSource(source, writer); }, spec->source);
  writer.Put(spec->time);
  PutBounds(spec->bounds, writer);
  PutGradation(spec->gradation, writer);
}

std::optional<MetricSpec> TakeSpec(ByteReader& reader) {
  const SpecKind kind = TakeKind(reader);
  if (!reader.ok() || kind == SpecKind::kNone) return std::nullopt;
  MetricSpec spec;
  if (kind == SpecKind::kIntersected) {
    spec.source = TakeIntersected(reader);
  } else {
    std::visit([&](auto&& source) { spec.source = std::forward<decltype(source)>(source); },
               TakePlain(kind, reader));
  }
  spec.time = reader.Take<double>();
  spec.bounds = TakeBounds(reader);
  spec.gradation = TakeGradation(reader);
  return spec;
}

void PutMeshData(const MeshData& mesh, ByteWriter& writer) {
  PutRows<double>(mesh.points, writer);
  PutRows<std::int32_t>(mesh.triangles, writer);
  writer.PutColumn(mesh.triangle_tags);
  PutRows<std::int32_t>(mesh.edges, writer);
  writer.PutColumn(mesh.edge_tags);
}

MeshData TakeMeshData(ByteReader& reader) {
  MeshData mesh;
  mesh.points = TakeRows<double, Vec2>(reader);
  mesh.triangles = TakeRows<std::int32_t, std::array<std::int32_t, 3>>(reader);
  mesh.triangle_tags = reader.TakeColumn<std::int32_t>();
  mesh.edges = TakeRows<std::int32_t, std::array<std::int32_t, 2>>(reader);
  mesh.edge_tags = reader.TakeColumn<std::int32_t>();
  return mesh;
}

}  // namespace pliant
