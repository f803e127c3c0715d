#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "core/mesh/mesh_edit.h"
#include "core/metric/metric_field.h"
#include "core/pliant/block_loop.h"
#include "core/pliant/helpers.h"
#include "core/pliant/loop.h"

namespace pliant {

/// A field times a constant: the metric of a coarser level.
class ScaledField final : public MetricField {
 public:
  ScaledField(std::shared_ptr<const MetricField> field, double scale)
      : field_(std::move(field)), scale_(scale) {}
  [[nodiscard]] Metric At(Vec2 p, std::int32_t& hint) const override {
    return scale_ * field_->At(p, hint);
  }
  void AtEach(std::span<const Vec2> points, std::span<std::int32_t> hints,
              std::span<Metric> metrics) const override {
    field_->AtEach(points, hints, metrics);
    for (Metric& metric : metrics) metric = scale_ * metric;
  }
  void PrefetchHint(std::int32_t hint) const override { field_->PrefetchHint(hint); }
  void PrefetchBehindHint(std::int32_t hint) const override { field_->PrefetchBehindHint(hint); }
  [[nodiscard]] Status status() const override { return field_->status(); }

 private:
  std::shared_ptr<const MetricField> field_;
  double scale_;
};

/// The first mesh from coarse to fine.
///
/// A mesh that has converged for the metric M/4 (edges twice as long), with all its edges halved,
/// is almost converged for M: lattices of equilateral triangles stay such lattices, and the number
/// of defects does not grow with the number of nodes. So a level needs two or three visits a node
/// instead of nine, and the mesh is better.
///
/// *Invariants*: between calls the mesh is valid and its metric is that of the current level.
class NestedBuild {
 public:
  /// Chooses the number of levels from an estimate of the field's complexity over the mesh, which
  /// must be the triangulation of the domain, and sets up the coarsest one: its metric at all
  /// vertices, all of them awake.
  NestedBuild(MeshEdit& edit, PliantLoop& loop, std::shared_ptr<const MetricField> field,
              const Options& options);

  /// Runs the loop on this level, as PliantLoop::Run does; a large one in blocks.
  StopReason Run(const Budget& budget, const Helpers& helpers);

  /// Nodes that wait on this level; all of them if those of the next one are to be woken.
  [[nodiscard]] std::int64_t active_count() const;

  /// Levels still to come after this one; 0 on the last.
  [[nodiscard]] int levels_left() const { return level_; }

  /// Refines the converged mesh and sets up the next level; the last one without refinement if that
  /// would pass the limit of vertices. @pre levels_left() > 0, and Run has ended
  /// @param stop  null: nobody. @return false if it asked to stop: then nothing has changed
  [[nodiscard]] bool NextLevel(const Helpers& helpers, const StopSignal* stop);

  /// Gives up the levels that are left: the full metric at all vertices, all of them awake, with
  /// the settings of an update.
  void Finish(const Helpers& helpers);

 private:
  void StartLevel(int level, const LoopSettings& settings);
  [[nodiscard]] bool Wake(Executor& executor);

  MeshEdit& edit_;
  PliantLoop& loop_;
  std::shared_ptr<const MetricField> field_;
  std::shared_ptr<const MetricField> level_field_;
  const Options options_;
  const LoopSettings settings_;
  int level_ = 0;
  bool is_coarsest_ = true;          // No level was refined yet: slots are in order of insertion.
  double refined_by_ = 0;            // How the metric grew to this level; 0: the field is asked.
  bool waking_ = false;              // The level's nodes are still to be woken.
  bool begun_ = false;               // Run has been called on this level,
  std::optional<BlockLoop> blocks_;  // and found that it is large.
};

}  // namespace pliant
