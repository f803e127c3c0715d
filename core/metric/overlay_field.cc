#include "core/metric/overlay_field.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/metric/saved_field.h"

namespace pliant {
namespace {

/// A vertex that slid along a segment lies off it by rounding, and so perhaps off the layer's
/// triangles: this share of the layer's extent still counts as inside.
constexpr double kInsideTolerance = 1e-9;

}  // namespace

Result<std::shared_ptr<OverlayField>> OverlayField::Lay(std::shared_ptr<MetricField> below,
                                                        const BackgroundMetric& tensors,
                                                        const SizeBounds& bounds) {
  PLIANT_ASSIGN_OR_RETURN(std::shared_ptr<const BackgroundField> field,
                          BackgroundField::Make(tensors, bounds));
  std::shared_ptr<OverlayField> overlay(new OverlayField());
  if (const auto* lower = dynamic_cast<const OverlayField*>(below.get())) {
    *overlay = *lower;
  } else {
    overlay->base_ = std::move(below);
  }
  BoundingBox box{tensors.mesh.points.front(), tensors.mesh.points.front()};
  for (const Vec2 p : tensors.mesh.points) {
    box.low = {std::min(box.low.x, p.x), std::min(box.low.y, p.y)};
    box.high = {std::max(box.high.x, p.x), std::max(box.high.y, p.y)};
  }
  const double tolerance = kInsideTolerance * Length(box.high - box.low);
  box.low = box.low - Vec2{tolerance, tolerance};
  box.high = box.high + Vec2{tolerance, tolerance};
  overlay->layers_.push_back({box, tolerance, tensors.mesh.triangles.size(), std::move(field)});
  overlay->triangle_count_ += tensors.mesh.triangles.size();
  return overlay;
}

std::optional<std::size_t> OverlayField::SharedLayers(const MetricField* known) const {
  if (known == base_.get()) return 0;
  const auto* overlay = dynamic_cast<const OverlayField*>(known);
  if (overlay == nullptr || overlay->base_ != base_) return {};
  const auto same = [](const Layer& a, const Layer& b) { return a.field == b.field; };
  const auto [own, other] = std::mismatch(layers_.begin(), layers_.end(), overlay->layers_.begin(),
                                          overlay->layers_.end(), same);
  return static_cast<std::size_t>(own - layers_.begin());
}

Status OverlayField::Save(ByteWriter& writer, const MetricField* known) const {
  PutFieldKind(SavedFieldKind::kOverlay, writer);
  const std::optional<std::size_t> shared = SharedLayers(known);
  writer.Put(static_cast<std::int64_t>(shared ? static_cast<std::int64_t>(*shared) : -1));
  if (!shared) PLIANT_RETURN_IF_ERROR(base_->Save(writer, nullptr));
  const std::size_t first = shared.value_or(0);
  writer.Put(static_cast<std::uint32_t>(layers_.size() - first));
  for (std::size_t i = first; i < layers_.size(); ++i) {
    const Layer& layer = layers_[i];
    for (const double number :
         {layer.box.low.x, layer.box.low.y, layer.box.high.x, layer.box.high.y, layer.tolerance}) {
      writer.Put(number);
    }
    writer.Put(static_cast<std::uint64_t>(layer.triangle_count));
    PLIANT_RETURN_IF_ERROR(layer.field->Save(writer, nullptr));
  }
  return {};
}

std::size_t OverlayField::bytes(const MetricField* known) const {
  if (known == this) return 0;
  const std::optional<std::size_t> shared = SharedLayers(known);
  std::size_t bytes = shared ? 0 : base_->bytes(nullptr);
  for (std::size_t i = shared.value_or(0); i < layers_.size(); ++i) {
    bytes += layers_[i].field->bytes(nullptr);
  }
  return bytes;
}

std::shared_ptr<OverlayField> OverlayField::Read(ByteReader& reader,
                                                 const std::shared_ptr<MetricField>& known) {
  std::shared_ptr<OverlayField> overlay(new OverlayField());
  const auto shared = reader.Take<std::int64_t>();
  const auto* below = dynamic_cast<const OverlayField*>(known.get());
  if (shared < 0) {
    overlay->base_ = ReadPlainField(reader);
  } else if (below != nullptr && static_cast<std::size_t>(shared) <= below->layers_.size()) {
    overlay->base_ = below->base_;
    overlay->layers_.assign(below->layers_.begin(), below->layers_.begin() + shared);
  } else if (below == nullptr && shared == 0) {
    overlay->base_ = known;
  }
  if (overlay->base_ == nullptr) return nullptr;
  const auto count = reader.Take<std::uint32_t>();
  for (std::uint32_t i = 0; i < count && reader.ok(); ++i) {
    Layer layer;
    layer.box.low.x = reader.Take<double>();
    layer.box.low.y = reader.Take<double>();
    layer.box.high.x = reader.Take<double>();
    layer.box.high.y = reader.Take<double>();
    layer.tolerance = reader.Take<double>();
    layer.triangle_count = static_cast<std::size_t>(reader.Take<std::uint64_t>());
    layer.field = std::dynamic_pointer_cast<const BackgroundField>(ReadPlainField(reader));
    if (layer.field == nullptr) return nullptr;
    overlay->layers_.push_back(std::move(layer));
  }
  for (const Layer& layer : overlay->layers_) overlay->triangle_count_ += layer.triangle_count;
  return overlay;
}

Metric OverlayField::At(Vec2 p, std::int32_t& hint) const {
  for (auto layer = layers_.rbegin(); layer != layers_.rend(); ++layer) {
    const BoundingBox& box = layer->box;
    if (p.x < box.low.x || p.x > box.high.x || p.y < box.low.y || p.y > box.high.y) continue;
    const std::optional<Metric> metric = layer->field->AtInside(p, layer->tolerance);
    if (metric) return *metric;
  }
  return base_->At(p, hint);
}

}  // namespace pliant
