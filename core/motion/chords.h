#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/ids.h"
#include "core/mesh/mesh.h"

namespace pliant {

/// Segments one behind the other that may become one: the corners between them go onto the straight
/// line from the first end to the last.
struct Chord {
  std::vector<VertexId> corners;       ///< From end to end, both included; at least 3.
  std::vector<double> parameters;      ///< Where on the chord each of them comes to lie, ascending
                                       ///< from exactly 0 to exactly 1.
  std::vector<std::int32_t> segments;  ///< One between each corner and the next.

  /// The bits of Mesh::PointOnSegment for the segment that the chord will be.
  [[nodiscard]] Vec2 PositionOf(const Mesh& mesh, std::size_t corner) const;
};

/// True for a given vertex without which the boundary would go on: two segments meet there and
/// nothing else, their tags are the same, and nothing there is frozen.
[[nodiscard]] bool IsSoftCorner(const Mesh& mesh, VertexId vertex);

/// Chooses chords in place of segments that are shorter than the metric asks for.
///
/// A chord comes into question if every corner between its ends lies within `tolerance` of it, and
/// if it asks for fewer edges than it has segments: corners are too dense there. Of all ways to cut
/// a chain of segments into chords and segments that stay the one is taken whose edges come nearest
/// to length 1; among equals, the one that moves less.
/// @param corners  soft ones: only these may go; none twice
/// @param tolerance  in domain units, > 0. What lies on the chord up to rounding is within any.
/// @return chords that have no segment in common, and no two of which, nor one and a segment that
///         stays, have both ends in common. Whether boundaries would meet is not looked at.
/// @par Cost O(k + edges of their segments) for k corners
[[nodiscard]] std::vector<Chord> ChooseChords(const Mesh& mesh, std::span<const VertexId> corners,
                                              double tolerance);

}  // namespace pliant
