#pragma once

#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/base/stop_signal.h"
#include "core/mesh/frozen_mesh.h"
#include "core/mesh/mesh_edit.h"
#include "core/metric/gradation.h"
#include "core/metric/limiter.h"
#include "core/metric/metric.h"
#include "core/metric/metric_field.h"
#include "core/metric/metric_functions.h"
#include "core/pliant/boundary_gaps.h"
#include "core/pliant/kept_tensors.h"
#include "core/pliant/metric_report.h"

namespace pliant {

/// Tensors that vertices shall have; Remesher wakes those that differ by more than the tolerance.
struct WantedTensors {
  std::vector<VertexId> vertices;
  std::vector<Metric> tensors;  ///< One for each vertex.
};

/// Tensors that vertices wanted before any limit, and before functions made them finer: what a way
/// back to a revision needs to know of its limits. Everything else about them follows from these,
/// the functions and the mesh.
struct RawTensors {
  bool all = false;  ///< Of every vertex, or else of those where they are to be others.
  std::vector<VertexId> vertices;  ///< Ascending.
  std::vector<Metric> tensors;     ///< One for each vertex.

  [[nodiscard]] std::size_t bytes() const {
    return vertices.size() * sizeof(VertexId) + tensors.size() * sizeof(Metric);
  }
};

/// Two of them, one after the other, as one. @par Cost O(first + second)
[[nodiscard]] RawTensors Merge(const RawTensors& first, const RawTensors& second);

/// The limits on a metric at the vertices of a mesh: averages over rings, size at short segments
/// and in gaps, gradation, rotation. Follows the mesh from revision to revision and back, at the
/// cost of what changes.
///
/// Before all of these comes the intersection with functions of place (MetricFunctions), if there
/// are any: raw tensors are then those without them, which vertices keep beside what the functions
/// make of these where the vertices are.
///
/// *Invariants*: after Update the limits are those of a full run over the raw tensors and the mesh
/// of that moment, to the bit, whatever the way to get there.
/// *Threads*: one caller at a time.
class MeshLimits {
 public:
  explicit MeshLimits(const MeshEdit& edit) : edit_(edit), mesh_(edit.mesh()) {}

  /// Also where there are only functions.
  [[nodiscard]] bool on() const { return limiter_ != nullptr; }
  /// Those of the last Load; null if there are none.
  [[nodiscard]] const MetricFunctions* functions() const { return functions_.get(); }
  /// Those of the last Load; all off where nothing limits.
  [[nodiscard]] const GradationOptions& options() const { return options_; }
  void TurnOff() {
    limiter_ = nullptr;
    kept_ = nullptr;
    functions_ = nullptr;
    options_ = {};
    report_ = {};
  }
  /// Begins anew with a raw tensor for every vertex. @par Cost O(mesh), and Update too
  /// @param stop  null: nobody; else kCancelled if it asks to, and Rollback must follow
  Status Load(const GradationOptions& options, std::span<const VertexId> vertices,
              std::span<const Metric> tensors, const StopSignal* stop = nullptr);
  /// What Load needs to know of its rules.
  struct Rules {
    GradationOptions options;
    std::shared_ptr<const MetricFunctions> functions;  ///< Null: none.
  };
  /// The same with functions. Where these have no value shows in their status().
  Status Load(const Rules& rules, std::span<const VertexId> vertices,
              std::span<const Metric> tensors, const StopSignal* stop);

  /// The functions that it has, in another object from now on. @pre AreSame
  void ShareFunctions(std::shared_ptr<const MetricFunctions> functions) {
    functions_ = std::move(functions);
  }

  /// A vertex wants another tensor. Takes effect with Update. @pre on()
  void SetRaw(VertexId vertex, const Metric& raw) { SetRawEach({&vertex, 1}, {&raw, 1}); }
  /// The same for several, for which functions are asked together.
  /// @param stop  null: nobody; else kCancelled if it asks to, and Rollback or TurnOff must follow
  Status SetRawOf(const WantedTensors& raw, const StopSignal* stop = nullptr);
  [[nodiscard]] bool Has(VertexId vertex) const { return limiter_->Has(vertex.value()); }
  [[nodiscard]] const Metric& Raw(VertexId vertex) const {
    return kept_ != nullptr ? kept_->At(vertex) : Met(vertex);
  }
  [[nodiscard]] Metric Limited(VertexId vertex) const { return limiter_->Limited(vertex.value()); }

  /// What the raw tensors make of the space between the vertices of `base`, which must be the mesh
  /// of the last Update; good until the next one.
  [[nodiscard]] std::shared_ptr<MetricField> RawField(std::shared_ptr<FrozenMesh> base) const;

  /// Takes note of what has become of the mesh since it was `base`. Vertices that moved or are new
  /// want the tensor that `raw` has where they are now. Takes effect with Update.
  /// @param stop  null: nobody; else kCancelled if it asks to, and Rollback or TurnOff must follow
  /// @par Cost O(changed)
  Status Follow(FrozenMesh& base, const MetricField& raw, const StopSignal* stop = nullptr);

  /// Lays the limits on the mesh as it is now.
  /// @param stop  null: nobody; else kCancelled if it asks to, and Rollback or TurnOff must follow
  /// @return the vertices whose limited tensors may be others than before.
  /// @par Cost O(changed log changed)
  Result<WantedTensors> Update(const StopSignal* stop = nullptr);

  [[nodiscard]] const MetricReport& report() const { return report_; }
  /// True if any vertex has another tensor than it wanted.
  [[nodiscard]] bool limits_anything() const { return report_.limits_anything(); }

  /// Makes this what Rollback comes back to. @return what leads back to the commit before.
  /// @pre nothing happened since Update @par Cost O(changed)
  RawTensors Commit();
  void Rollback();
  /// True if there is nothing to go back from.
  [[nodiscard]] bool as_committed() const {
    return limiter_ == committed_ && (limiter_ == nullptr || limiter_->as_committed()) &&
           kept_ == committed_kept_ && (kept_ == nullptr || kept_->as_committed());
  }

  /// Raw tensors of all vertices, or of some where they have one.
  [[nodiscard]] RawTensors All() const;
  [[nodiscard]] RawTensors At(std::span<const VertexId> vertices) const;
  /// Takes over other raw tensors, for the mesh as it is now. @param touched  vertices that differ
  /// from those of the last Update, or whose neighbours do; perhaps others. @pre on()
  void Apply(const RawTensors& raw, std::span<const VertexId> touched);

 private:
  /// What a vertex wants with functions, before limits.
  [[nodiscard]] const Metric& Met(VertexId vertex) const { return limiter_->Raw(vertex.value()); }
  void SetRawEach(std::span<const VertexId> vertices, std::span<const Metric> raw);
  void Remove(VertexId vertex);
  [[nodiscard]] RawTensors RawOfCommit();
  [[nodiscard]] double SizeCap(VertexId vertex, const Metric& raw) const;
  [[nodiscard]] double SegmentCap(VertexId vertex) const;
  [[nodiscard]] double ReachOf(const Metric& raw) const;
  void RenewSegments();
  void RenewCap(VertexId vertex);
  void RenewCaps(std::vector<VertexId> vertices);
  void GiveRaw(VertexId vertex);

  const MeshEdit& edit_;
  const Mesh& mesh_;
  GradationOptions options_;
  std::shared_ptr<const MetricFunctions> functions_;  // Null: none.
  std::shared_ptr<MetricLimiter> limiter_;            // Null: off.
  std::shared_ptr<KeptTensors> kept_;                 // Raw tensors; null: the limiter has them.
  std::shared_ptr<const BoundaryGaps> segments_;      // Null: they do not limit.
  std::shared_ptr<MetricLimiter> committed_;     // Of the last commit; goes back by its own log.
  std::shared_ptr<KeptTensors> committed_kept_;  // Likewise.
  std::shared_ptr<const MetricFunctions> committed_functions_;
  MetricReport report_;
  MetricReport committed_report_;
  GradationOptions committed_options_;
  std::shared_ptr<const BoundaryGaps> committed_segments_;
};

}  // namespace pliant
