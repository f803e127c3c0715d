#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/geometry/domain.h"
#include "core/metric/background_field.h"
#include "core/metric/metric_field.h"
#include "core/metric/metric_spec.h"

namespace pliant {

/// A field with small background meshes laid over parts of it: where tensors at a few vertices
/// changed. Keeps an update of k tensors from copying a field of n.
///
/// *Invariants*: those of MetricField. The topmost layer that holds a point decides; where none
/// does, the field below.
/// *Threads*: those of MetricField.
class OverlayField final : public MetricField {
 public:
  /// `below` with one layer more. Layers are shared, so that an older field stays as it is.
  /// @param tensors  over the triangles at which something changed; at their rim the tensors of
  ///                 `below`, or the metric jumps there. Errors: those of BackgroundField::Make.
  [[nodiscard]] static Result<std::shared_ptr<OverlayField>> Lay(std::shared_ptr<MetricField> below,
                                                                 const BackgroundMetric& tensors,
                                                                 const SizeBounds& bounds);

  [[nodiscard]] Metric At(Vec2 p, std::int32_t& hint) const override;
  [[nodiscard]] Status status() const override { return base_->status(); }

  /// Names `known` as what the layers lie on, if it is: an update of k tensors takes O(k) bytes.
  [[nodiscard]] Status Save(ByteWriter& writer, const MetricField* known) const override;
  [[nodiscard]] std::size_t bytes(const MetricField* known) const override;

  /// What ReadField makes of it; nothing where the bytes cannot be one.
  [[nodiscard]] static std::shared_ptr<OverlayField> Read(
      ByteReader& reader, const std::shared_ptr<MetricField>& known);

  /// Layers, and triangles in all of them: each layer costs every question a comparison with its
  /// box, so that many of them should be replaced by one background mesh.
  [[nodiscard]] std::size_t layer_count() const { return layers_.size(); }
  [[nodiscard]] std::size_t triangle_count() const { return triangle_count_; }

 private:
  struct Layer {
    BoundingBox box;
    double tolerance = 0;  ///< Distance up to which a point counts as inside, for rounding.
    std::size_t triangle_count = 0;
    std::shared_ptr<const BackgroundField> field;
  };

  OverlayField() = default;
  /// Layers that are those of `known` too, from the lowest on; nothing if the base is another one.
  [[nodiscard]] std::optional<std::size_t> SharedLayers(const MetricField* known) const;

  std::shared_ptr<MetricField> base_;
  std::vector<Layer> layers_;  // The topmost last.
  std::size_t triangle_count_ = 0;
};

}  // namespace pliant
