#include "core/metric/overlay_field.h"

#include <algorithm>
#include <optional>
#include <utility>

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
  overlay->layers_.push_back({box, tolerance, std::move(field)});
  overlay->triangle_count_ += tensors.mesh.triangles.size();
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
