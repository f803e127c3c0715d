#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/base/stop_signal.h"
#include "core/geometry/vec2.h"
#include "core/metric/metric.h"
#include "core/metric/vertex_rings.h"

namespace pliant {

/// A tensor where it holds.
struct PlacedLog {
  Vec2 position;
  LogMetric log;
};

/// The mean of a vertex and its neighbours, each with the same weight, log-Euclidean. Its bits do
/// not depend on the order of `ring`, which is sorted by place, and where all are the same, they
/// are what comes out.
[[nodiscard]] LogMetric RingMean(const LogMetric& own, std::span<PlacedLog> ring);

/// Tensors averaged over the rings of a mesh, a few times over, for metrics with noise: a change of
/// k tensors, places or edges costs what it changes, and the result is the one of averaging
/// everything anew, to the bit.
///
/// In every pass the logarithm of the tensor at a vertex becomes RingMean of what the pass before
/// has left there and at its neighbours. That may also make a metric coarser.
/// *Invariants*: after Update, At(v) is that mean for the tensors and the mesh of that moment.
/// *Threads*: one caller at a time.
class TensorSmoothing {
 public:
  static constexpr std::int32_t kPassesMax = 8;

  /// @param pass_count  0 to kPassesMax; at 0 there is nothing to call.
  explicit TensorSmoothing(std::int32_t pass_count);

  [[nodiscard]] bool on() const { return pass_count_ > 0; }

  /// Makes room for vertices below this number at once.
  void Reserve(std::int32_t slot_count) {
    if (on()) logs_.reserve(Row(slot_count));
  }
  /// A vertex that is new, or whose tensor is another one. Takes effect with Update.
  void Set(std::int32_t vertex, const Metric& raw);

  /// Averages over the mesh as it is now. Every vertex has a tensor.
  /// @param touched  those that were set, that moved, or whose ring is another one; all are there.
  /// @param stop     null: nobody; else it ends where it is if that asks to, what it returns means
  ///                 nothing, and Rollback must follow.
  /// @return  vertices whose average may be another one, in no order; some perhaps twice.
  /// @par Cost O(changed), times the vertices within `pass_count` edges.
  [[nodiscard]] std::vector<std::int32_t> Update(VertexRings& rings,
                                                 std::span<const std::int32_t> touched,
                                                 const StopSignal* stop = nullptr);

  /// Whether the average differs from the vertex's own tensor.
  [[nodiscard]] bool Differs(std::int32_t vertex) const;
  [[nodiscard]] Metric At(std::int32_t vertex) const;

  /// From now on Rollback returns to here. @par Cost O(changed since the last Commit)
  void Commit();
  /// Back to the last Commit, to the bit. @par Cost O(changed since then)
  void Rollback();

 private:
  [[nodiscard]] std::size_t Row(std::int32_t vertex) const {
    return static_cast<std::size_t>(vertex) * static_cast<std::size_t>(pass_count_ + 1);
  }
  void Write(std::int32_t vertex, std::int32_t pass, const LogMetric& log);
  [[nodiscard]] LogMetric Mean(VertexRings& rings, std::int32_t vertex, std::int32_t pass);
  void Add(std::int32_t vertex, std::vector<std::int32_t>& list);

  std::int32_t pass_count_;
  /// Of each vertex the logarithm of its tensor, then that after each pass.
  std::vector<LogMetric> logs_;
  std::vector<char> listed_;  ///< In this pass of Update.
  std::vector<PlacedLog> ring_;

  struct Old {
    std::size_t index;
    LogMetric log;
  };
  std::vector<Old> undo_;
  std::size_t committed_size_ = 0;
};

}  // namespace pliant
