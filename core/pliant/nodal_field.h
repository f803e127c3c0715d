#pragma once

#include <memory>

#include "core/mesh/frozen_mesh.h"
#include "core/metric/metric_field.h"

namespace pliant {

/// The tensors at the vertices of a frozen mesh, log-Euclidean in between. [Arsigny2006] Hints are
/// triangle slots. Outside the mesh the value at its nearest point holds.
///
/// *Invariants*: those of MetricField. *Threads*: one at a time, those of FrozenMesh: for updates
/// only, not for builds in blocks.
class NodalField final : public MetricField {
 public:
  explicit NodalField(std::shared_ptr<FrozenMesh> mesh) : mesh_(std::move(mesh)) {}

  /// @par Cost  a walk of a few triangles from a good hint, one exponential, and a logarithm for
  ///            each vertex that is asked for the first time.
  [[nodiscard]] Metric At(Vec2 p, std::int32_t& hint) const override;
  void ProbeLogEach(std::span<LogQuestion> questions) const override;

 private:
  std::shared_ptr<FrozenMesh> mesh_;
};

}  // namespace pliant
