#pragma once

#include <cstddef>

#include "core/geometry/vec2.h"
#include "core/mesh/mesh.h"
#include "core/mesh/star.h"
#include "core/metric/metric.h"

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

  /// False if no spoke and no edge of the link would pass WantsSwap: the usual case, which needs
  /// no search. True says nothing. @pre the mesh is as Gather saw it, but for the center
  [[nodiscard]] bool MaySwap(const Mesh& mesh, const Star& star);

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
  };

  [[nodiscard]] std::size_t padded_count() const { return (count_ + kLanes - 1) / kLanes * kLanes; }

  std::size_t count_ = 0;
  Vec2 center_;
  Metric metric_;
  Columns ring_;
  Columns far_;  // Behind link edge k, at k + 1.
};

}  // namespace pliant
