#pragma once

#include <cstdint>
#include <memory>

#include "core/pliant/remesher.h"

namespace pliant::testing {

/// A session's life, reproducible from a seed: the nth update depends on the seed, n and the state
/// of the session alone. Sizes by expression, full tensors by expression, background meshes, bounds
/// and gradation, tensors at few and at all vertices, functions beside them, displacements with
/// tensors; fields that are set,
/// carried and dropped; loops that are cut short and taken up again.
class SessionScript {
 public:
  explicit SessionScript(std::uint64_t seed) : seed_(seed) {}

  /// The session before its first commit: small, with a variant that the seed chooses.
  [[nodiscard]] std::unique_ptr<Remesher> Start() const;

  /// Update n >= 1 and its commit; the first one is no update, only the commit.
  MeshDiff Run(Remesher& session, int n) const;

 private:
  std::uint64_t seed_;
};

}  // namespace pliant::testing
