#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/base/executor.h"
#include "core/mesh/mesh_edit.h"
#include "core/mesh/territory.h"
#include "core/metric/metric_field.h"
#include "core/pliant/helpers.h"
#include "core/pliant/loop.h"
#include "core/pliant/options.h"

namespace pliant {

/// The loop on a large mesh: on many blocks of it at once, with the same bits for any executor.
///
/// The plane is cut into blocks with equal numbers of vertices. In a round each block has a loop of
/// its own, with its own queue and slots, that visits the nodes whose neighbours all lie in the
/// block; the others wait aside. A second and third round with other borders take up most of what
/// waited, and the loop for the whole mesh does the rest. Blocks and slots depend on the mesh
/// alone, and core/mesh/territory.h says why no block sees what another does.
///
/// *Invariants*: between calls, the mesh is valid, the nodes that the loop for the whole mesh had
/// are active, and each is in one queue. Ages go on from round to round: it is one update.
/// *Threads*: one caller at a time; the tasks it gives to the executor do not meet.
class BlockLoop {
 public:
  /// @param loop  of the whole mesh, in the midst of an update.
  BlockLoop(MeshEdit& edit, PliantLoop& loop, const Options& options, const BlockRule& rule);
  ~BlockLoop();
  BlockLoop(const BlockLoop&) = delete;
  BlockLoop& operator=(const BlockLoop&) = delete;

  /// True if the rule asks for blocks and slots for all of them keep the limit of vertices.
  [[nodiscard]] static bool Suits(const Mesh& mesh, const Options& options, const BlockRule& rule);

  /// As PliantLoop::Run; how the budget is shared among the blocks does not change the result.
  /// @pre the field answers any number of threads at once
  StopReason Run(const MetricField& field, const Budget& budget, Executor& executor);

  /// Ends the blocks, at any point between calls of Run: all active nodes go back to the loop for
  /// the whole mesh.
  void Leave();

  /// Nodes that wait in the blocks, an upper bound as PliantLoop::active_count is.
  [[nodiscard]] std::int64_t active_count() const;

 private:
  struct Block;

  [[nodiscard]] bool WantsRound() const;
  void BeginRound(Executor& executor);
  /// Gives every vertex slot its owner in this round.
  void ShareOut(Executor& executor, std::int32_t part_count);
  /// Moves the active nodes to the blocks that own them, in order.
  void Distribute(Executor& executor);
  StopReason RunRound(const MetricField& field, Budget& budget, Executor& executor);
  /// Lets every block with active nodes use its part of the budget.
  StopReason RunSlice(const MetricField& field, Budget& budget, Executor& executor);
  void EndRound();

  MeshEdit& edit_;
  PliantLoop& loop_;
  const Options options_;
  const BlockRule rule_;
  std::vector<Territory::Owner> owners_;
  std::vector<Territory> territories_;
  std::vector<std::unique_ptr<Block>> blocks_;
  int round_ = 0;
  bool in_round_ = false;
};

}  // namespace pliant
