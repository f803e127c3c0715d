#pragma once

#include <cstdint>

#include "core/mesh/mesh.h"

namespace pliant {

/// How many nodes the metric asks for, by what the mesh's vertices know of it: its area in the
/// metric over that of an ideal triangle, two nodes for four triangles. @par Cost O(mesh)
[[nodiscard]] double WantedNodeCount(const Mesh& mesh);

/// A guard on the insertions of one update: at most kAllowancePerNode for every node that there was
/// or that the metric asks for. The proof of termination bounds the visits by 3^age_max; with the
/// guard the bound is linear (core/README.md). Loops on metrics that no mesh can meet take less
/// than half of it.
class InsertionAllowance {
 public:
  void BeginUpdate(const Mesh& mesh);

  /// True if one more node may be made, and counts it. Asks for WantedNodeCount when the allowance
  /// is used up, and grants more if the metric asks for more; a refusal holds for the update.
  /// @par Cost O(1), amortised: the mesh is looked at once in as many insertions as it had nodes
  [[nodiscard]] bool Take(const Mesh& mesh) {
    return state_.used < state_.granted ? Use() : TakeMore(mesh);
  }

  /// All that it remembers.
  struct State {
    std::int64_t used = 0;
    std::int64_t granted = 0;
    bool exhausted = false;
  };
  [[nodiscard]] const State& state() const { return state_; }
  static InsertionAllowance At(const State& state) {
    InsertionAllowance allowance;
    allowance.state_ = state;
    return allowance;
  }

 private:
  bool Use() {
    ++state_.used;
    return true;
  }
  bool TakeMore(const Mesh& mesh);

  State state_;
};

/// Insertions per node, and what every update may insert.
inline constexpr std::int64_t kAllowancePerNode = 32;
inline constexpr std::int64_t kAllowanceFloor = 1'000;

}  // namespace pliant
