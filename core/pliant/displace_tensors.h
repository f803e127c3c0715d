#pragma once

#include <span>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/mesh/mesh_edit.h"
#include "core/metric/metric.h"
#include "core/pliant/mesh_change.h"
#include "core/pliant/mesh_limits.h"
#include "core/pliant/remesher.h"
#include "core/pliant/tensors_ahead.h"

namespace pliant {

/// A displacement (DisplaceVertices) that tensors are known for: those of the places where it
/// leads. Nobody can know beforehand which vertices get there: who was run over needs no tensor any
/// more; whoever must stay, slid along a wall instead, or met a blocked way has what the tensors
/// are where he is, interpolated between the places; and so have the new vertices in the gap.
///
/// The mesh has its old tensors afterwards, carried along; vertices() and tensors() are what is to
/// be followed. Errors of Apply: those of DisplaceVertices, and of Remesher::SetTensors for the
/// tensors; index = position in the given span.
class DisplaceWithTensors final : public MeshChange {
 public:
  explicit DisplaceWithTensors(const TensorsAhead& request) : request_(request) {}

  void Permit(const Permissions& permissions) override { permissions_ = permissions; }
  Result<Outcome> Apply(MeshEdit& edit) override;

  /// After Apply: who gets a tensor, none twice; if all vertices had one, all live ones, ascending.
  [[nodiscard]] std::span<const VertexId> vertices() const { return wanted_.vertices; }
  /// One for each of them.
  [[nodiscard]] std::span<const Metric> tensors() const { return wanted_.tensors; }

 private:
  const TensorsAhead request_;
  Permissions permissions_;
  WantedTensors wanted_;
};

/// What tensors at vertices come with.
struct TensorsBeside {
  const MetricLimits& limits;
  const FunctionsSpec* functions = nullptr;  ///< As for Remesher::SetTensors; null: as without.
};

/// Carries out the displacement and follows the tensors from now on: one update instead of two. The
/// mesh and the metric are those of a displacement, and SetTensors with the tensors of the
/// vertices where that has put them.
/// Errors: those of DisplaceWithTensors and Remesher::SetTensors. After one of limits or functions
/// the displacement has been carried out: the caller should then Rollback.
/// @par Cost O(k log k) for k displaced vertices and those of SetTensors
Status SetTensorsAhead(Remesher& remesher, const TensorsAhead& request, const TensorsBeside& terms);

}  // namespace pliant
