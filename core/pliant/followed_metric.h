#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/mesh/mesh_edit.h"
#include "core/metric/gradation.h"
#include "core/metric/metric.h"
#include "core/metric/metric_field.h"
#include "core/metric/metric_spec.h"

namespace pliant {

/// Tensors that vertices shall have; Remesher wakes those that differ by more than the tolerance.
struct WantedTensors {
  std::vector<VertexId> vertices;
  std::vector<Metric> tensors;  ///< One for each vertex.
};

/// Live vertices in ascending order of slot, for a request that names none. @par Cost O(mesh)
[[nodiscard]] std::vector<VertexId> LiveVertices(const Mesh& mesh);

/// The metric that a session follows: as it was sent, and limited.
///
/// Reads the mesh and moves hints, but changes nothing of it: what vertices shall have comes back
/// as WantedTensors.
/// *Invariants*: `raw()` and `field()` answer at any time for the mesh as it was when they were
/// set; they are never changed afterwards, only replaced.
/// *Threads*: one caller at a time.
class FollowedMetric {
 public:
  /// All that decides later answers; a copy shares the fields, which do not change.
  struct State {
    std::shared_ptr<MetricField> raw;      ///< As it was sent, bounds applied.
    std::shared_ptr<MetricField> limited;  ///< What the loop sees: `raw` without gradation.
    std::optional<MetricSpec> spec;        ///< What `raw` was made from, if it can be compared.
    SizeBounds bounds;
    GradationOptions gradation;
    int limit_rounds_left = 0;
  };

  /// @param tolerance  Options::metric_tolerance.
  FollowedMetric(MeshEdit& edit, double tolerance)
      : edit_(edit), mesh_(edit.mesh()), tolerance_(tolerance) {}

  /// Refuses a specification that names impossible limits; the field is checked when it is made.
  [[nodiscard]] static Status Check(const MetricSpec& spec);

  /// True if `spec` is known to be what is followed already.
  [[nodiscard]] bool Follows(const MetricSpec& spec) const {
    return state_.spec.has_value() && *state_.spec == spec;
  }

  /// Follows another field from now on; until Limit it is followed as it is.
  /// @param spec  what it was made from, remembered to compare the next one with, unless it has a
  ///              background mesh: that is as large as the mesh, and comparing tensors at the
  ///              vertices finds the same. Null for a field of the caller's own.
  void Follow(std::shared_ptr<MetricField> field, const MetricSpec* spec);

  /// Refuses what SetTensors cannot take. Errors: those of Remesher::SetTensors.
  [[nodiscard]] Status CheckTensors(std::span<const VertexId> vertices,
                                    std::span<const Metric> tensors) const;

  /// Other tensors at some vertices from now on, bounds applied. Wants nothing if none differs from
  /// what is followed. @pre CheckTensors
  [[nodiscard]] Result<WantedTensors> SetTensors(std::span<const VertexId> vertices,
                                                 std::span<const Metric> tensors);

  /// Tensors that vertices brought along when they were moved: the field takes them over where they
  /// are now, and over the triangles at them. @pre the mesh has them already
  [[nodiscard]] Result<WantedTensors> Carry(std::span<const VertexId> vertices,
                                            std::span<const Metric> tensors);

  /// Limits the raw metric over the edges of the mesh as it is and follows the result.
  /// @pre limits_again()
  [[nodiscard]] Result<WantedTensors> Limit();

  /// True while the metric is to be limited on the mesh that the loop has made of it: that of
  /// before may be too coarse to know the metric.
  [[nodiscard]] bool limits_again() const { return state_.limit_rounds_left > 0; }

  /// True if a tensor is another one than a vertex has, by more than the tolerance.
  [[nodiscard]] bool Differs(const Metric& old, const Metric& now) const {
    return !(now == old) && RelativeChange(old, now) > tolerance_;
  }

  [[nodiscard]] const std::shared_ptr<MetricField>& raw() const { return state_.raw; }
  [[nodiscard]] const MetricField& field() const { return *state_.limited; }

  [[nodiscard]] const State& state() const { return state_; }
  void Restore(const State& state) { state_ = state; }

 private:
  [[nodiscard]] bool limits() const {
    return state_.gradation.gradation != 0 || state_.gradation.rotation != 0;
  }
  [[nodiscard]] Metric RawMetric(VertexId vertex);
  [[nodiscard]] Result<std::shared_ptr<MetricField>> FieldWith(std::span<const VertexId> vertices,
                                                               std::span<const Metric> tensors);

  MeshEdit& edit_;
  const Mesh& mesh_;
  const double tolerance_;
  State state_;
};

}  // namespace pliant
