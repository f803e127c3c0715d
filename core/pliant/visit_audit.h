#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/ids.h"
#include "core/mesh/mesh.h"

namespace pliant {

/// Watches the loop keep what its proof of termination rests on (core/README.md, "Why it ends"): a
/// visit makes its node older and nobody younger, makes at most one node, which is older than the
/// visited node was, and lowers the potential, the sum of 3^(age_max - age) over the nodes that the
/// update has reached. Exact: the change of the potential is computed in integers.
///
/// Knows the loop's rules only from there; keeps its own record of who lives and how old they are.
/// The loop uses it if kValidateEvery. *Threads*: one caller at a time.
class VisitAudit {
 public:
  /// Takes down the state of every node. Between visits only the update itself may change ages:
  /// call it again when it did. @par Cost O(mesh)
  void Sync(const Mesh& mesh);

  /// Right before a visit.
  void Begin(const Mesh& mesh, VertexId node, std::uint32_t epoch);

  /// Right after it. @return what the visit broke, empty if nothing.
  /// @par Cost O(nodes within two edges of the visited one)
  [[nodiscard]] std::string End(const Mesh& mesh);

  [[nodiscard]] std::int64_t visit_count() const { return visit_count_; }

 private:
  struct Known {
    bool live = false;
    std::uint32_t epoch = 0;
    std::uint8_t age = 0;
  };

  void AddSurroundings(const Mesh& mesh, VertexId node);
  void AddRing(const Mesh& mesh, VertexId node);
  [[nodiscard]] Known NowOf(const Mesh& mesh, VertexId node) const;

  std::vector<Known> known_;  // By slot.
  std::vector<VertexId> surroundings_;
  VertexId node_;
  std::uint32_t epoch_ = 0;
  std::uint8_t age_before_ = 0;
  std::int64_t visit_count_ = 0;
};

/// The sign of the sum of changes[age] * 3^(-age): how a potential changes when changes[age] nodes
/// of each age come (positive) or go.
[[nodiscard]] int SignOfPotentialChange(const std::vector<std::int64_t>& changes);

}  // namespace pliant
