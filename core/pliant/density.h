#pragma once

#include "core/base/ids.h"
#include "core/mesh/mesh.h"
#include "core/mesh/star.h"

namespace pliant {

/// Says whether a neighbourhood has as many nodes as its metric asks for. One edge that is a little
/// too long says nothing, because edges differ; where all of them are, nodes are missing.
///
/// *Threads*: one caller at a time.
class DensityProbe {
 public:
  explicit DensityProbe(const Mesh& mesh) : mesh_(mesh) {}

  /// Nodes that are missing (below 0: too many) among the triangles within two edges: their
  /// normalized area would be sqrt(3)/4 each, and a node more is two triangles more.
  /// @param star  of an interior node @par Cost O(neighbours of the ring), 0.5 us
  [[nodiscard]] double LackAround(const Star& star);

  /// The edges along a segment up to 10 on each side of a node, and how long they are in all.
  struct Stretch {
    double length = 0;
    int count = 0;

    /// Whether one edge more, or less, would be nearer to what the metric asks for, by some margin:
    /// where the next step would not be the way back. For one edge the bound is that of its extent.
    [[nodiscard]] bool lacks() const;
    [[nodiscard]] bool is_crowded() const;
  };
  /// @pre the node lies inside a segment
  [[nodiscard]] Stretch StretchAround(VertexId node) const;

 private:
  const Mesh& mesh_;
  Star star_;
};

}  // namespace pliant
