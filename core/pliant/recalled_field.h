#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/vec2.h"
#include "core/mesh/frozen_mesh.h"
#include "core/mesh/slot_rows.h"
#include "core/metric/background_field.h"
#include "core/metric/metric_field.h"

namespace pliant {

/// Tensors that were sent at the vertices of a mesh, and what is known of the metric between them.
///
/// A front that moves comes to lie where the mesh is coarser than the front is thin: the tensors at
/// the corners of a triangle there do not know what lies between them, and their mean misses it.
/// But the metric of before knew it, where the front was. In triangles that are told so, and whose
/// corners have what the metric of before has one shift back, the answer is that, plus what is
/// left of the differences at the corners: what was sent holds at the vertices to the last bit of a
/// logarithm, and the metric stays continuous there. Everywhere else it is log-Euclidean, as in a
/// BackgroundField.
///
/// *Invariants*: those of MetricField, between two calls of Recall and SetShift.
/// *Threads*: one at a time, those of FrozenMesh: for updates only, not for builds in blocks.
class RecalledField final : public MetricField {
 public:
  /// @param sent    the tensors that were sent, at the vertices of the mesh as it was then
  /// @param before  the metric before that
  RecalledField(std::unique_ptr<BackgroundField> sent, std::shared_ptr<FrozenMesh> before);

  /// What was at p before is at p + by now, as far as tensors at vertices can tell. Forgets what
  /// was recalled before.
  void SetShift(Vec2 by);

  /// A vertex of the mesh of before that is carried along.
  struct Arrival {
    Metric tensor;                   ///< That it had there.
    Vec2 place;                      ///< Where it comes to lie, in the mesh.
    std::int32_t triangle = 0;       ///< Of `sent`, around that: the hint of an answer.
    std::int32_t from_triangle = 0;  ///< Of the mesh of before, at the vertex.
  };
  /// Lets answers in a triangle be those of before, if it is larger than the vertex that arrives
  /// there wants it and its corners agree.
  /// @return nothing where nothing is recalled; else what At has now, up to rounding, if the place
  ///         is one shift from where the vertex was
  /// @pre SetShift
  [[nodiscard]] std::optional<Metric> Recall(const Arrival& arrival);

  [[nodiscard]] Metric At(Vec2 p, std::int32_t& hint) const override;
  [[nodiscard]] std::optional<Metric> Probe(Vec2 p, std::int32_t& hint) const override;
  void ProbeEach(std::span<Question> questions) const override;
  void ProbeLogEach(std::span<LogQuestion> questions) const override;
  void PrefetchHint(std::int32_t hint) const override { sent_->PrefetchHint(hint); }
  void PrefetchBehindHint(std::int32_t hint) const override { sent_->PrefetchBehindHint(hint); }
  [[nodiscard]] std::size_t bytes() const override;

 private:
  static constexpr std::int32_t kUnknown = -1;
  static constexpr std::int32_t kForgotten = -2;

  /// What a corner has that the metric of before does not have one shift back.
  struct Rest {
    bool agrees = false;
    LogMetric log;
  };

  [[nodiscard]] bool Knows(const Arrival& arrival);
  [[nodiscard]] Rest RestAt(std::int32_t corner, std::int32_t& from_triangle);
  [[nodiscard]] LogMetric RestIn(const Location& location) const;
  [[nodiscard]] bool IsCoarse(std::int32_t triangle, const Metric& tensor) const;

  std::unique_ptr<BackgroundField> sent_;
  std::shared_ptr<FrozenMesh> before_;
  Vec2 by_;
  bool recalls_ = false;
  mutable SlotRows<Rest> rests_;  ///< By point, of those that were asked for. At only reads.
  /// By triangle of `sent`: where in the mesh of before the answers lie, or kUnknown, or
  /// kForgotten where the corners do not agree. It is a hint, only ever a speed-up.
  mutable std::vector<std::int32_t> recalled_;
};

}  // namespace pliant
