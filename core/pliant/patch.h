#pragma once

#include <cstddef>

#include "core/geometry/vec2.h"
#include "core/mesh/mesh.h"
#include "core/mesh/star.h"
#include "core/metric/metric.h"
#include "core/pliant/crowd.h"

namespace pliant {

/// The surroundings of an interior node in columns, so that a visit loads every vertex once and its
/// arithmetic runs over all neighbours at a time, in vector instructions where the processor has
/// them.
///
/// Everything here has a plain counterpart that works on a Star and gives the same bits: each term
/// is computed by the same operations, and sums run in the order of the ring. A visit uses the
/// columns where they fit and the plain code elsewhere.
class Patch {
 public:
  /// Largest ring that fits. Nodes have six neighbours, rarely more than nine.
  static constexpr std::size_t kRingMax = 14;

  /// True if the star can be gathered: closed, not too large.
  [[nodiscard]] static bool Fits(const Star& star) {
    return star.closed() && star.ring().size() <= kRingMax;
  }

  /// Loads the ring of a star. @pre Fits(star)
  void Gather(const Mesh& mesh, const Star& star);

  /// SmoothingStep with Smoothing::kPliant.
  [[nodiscard]] Vec2 Step(double alpha) const;

  /// True if every triangle stays positive with the center at `target`.
  [[nodiscard]] bool StaysPositive(Vec2 target) const;

  /// Puts the center elsewhere, as MeshEdit does in the mesh.
  void MoveCenter(Vec2 position, const Metric& metric);

  /// Computes what the two questions below need. Again after a Gather or MoveCenter.
  void Measure();

  /// True if a spoke, or an edge of the link opposite a wide angle, passes WantsSwap: rare, and the
  /// cause for a search. @pre the mesh is as Gather saw it, but for the center
  [[nodiscard]] bool WantsSwaps(const Mesh& mesh, const Star& star) const;

  /// NodeExtent and the spoke of LargestSpokeExtent.
  struct Extents {
    double node = 0;
    std::size_t largest_spoke = 0;
    double largest = 0;
  };
  [[nodiscard]] Extents MeasureExtents() const;

 private:
  /// Ring vertex k stands at k + 1; its two neighbours across the seam are repeated at the ends.
  /// Kernels run over a multiple of four, so that none is left for scalar instructions; the slots
  /// beyond the ring hold copies whose results nobody reads.
  static constexpr std::size_t kLanes = 4;
  static constexpr std::size_t kSlots = (kRingMax + kLanes - 1) / kLanes * kLanes + 2;

  struct Columns {
    alignas(64) double x[kSlots];
    alignas(64) double y[kSlots];
    alignas(64) double m11[kSlots];
    alignas(64) double m12[kSlots];
    alignas(64) double m22[kSlots];

    void Set(std::size_t slot, const VertexRecord& vertex) {
      x[slot] = vertex.position.x;
      y[slot] = vertex.position.y;
      m11[slot] = vertex.metric.m11;
      m12[slot] = vertex.metric.m12;
      m22[slot] = vertex.metric.m22;
    }
    void Copy(std::size_t to, std::size_t from) {
      x[to] = x[from];
      y[to] = y[from];
      m11[to] = m11[from];
      m12[to] = m12[from];
      m22[to] = m22[from];
    }
  };

  [[nodiscard]] std::size_t padded_count() const { return (count_ + kLanes - 1) / kLanes * kLanes; }
  [[nodiscard]] Vec2 RingPosition(std::size_t slot) const { return {ring_.x[slot], ring_.y[slot]}; }
  [[nodiscard]] Metric RingMetric(std::size_t slot) const {
    return {ring_.m11[slot], ring_.m12[slot], ring_.m22[slot]};
  }
  [[nodiscard]] bool SpokeWantsSwap(std::size_t slot) const;
  [[nodiscard]] bool LinkWantsSwap(const Mesh& mesh, const Star& star, std::size_t k) const;

  std::size_t count_ = 0;
  Vec2 center_;
  Metric metric_;
  Columns ring_;
  Crowd crowd_;
  alignas(64) double area_[kSlots];
  alignas(64) double alert_[kSlots];
};

}  // namespace pliant
