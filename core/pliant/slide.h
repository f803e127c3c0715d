#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/base/ids.h"
#include "core/geometry/vec2.h"
#include "core/mesh/mesh.h"

namespace pliant {

/// A vertex inside a segment that is to move along it, by parameters of the segment.
struct Slide {
  VertexId vertex;
  double from = 0;
  double to = 0;
};

/// What a motion of vertices along their segments comes to.
struct SlidePlan {
  std::vector<Slide> slides;        ///< By segment, ascending along it, before and afterwards.
  std::vector<VertexId> overtaken;  ///< Vertices inside segments whose place is taken.
};

/// True for a vertex inside a segment that is neither given nor frozen.
[[nodiscard]] bool IsSlidable(const Mesh& mesh, VertexId vertex);

/// Where a slidable vertex comes to lie that follows a displacement along its segment; nothing if
/// the displacement leads away from the segment.
[[nodiscard]] std::optional<Vec2> PlaceAlongWall(const Mesh& mesh, VertexId vertex, Vec2 by);

/// A slidable vertex and the place on its segment, or near it, where it is to lie.
struct PlaceOnWall {
  VertexId vertex;
  Vec2 to;
};

/// Plans how vertices slide along their segments in one go. Others that stand where they come to
/// lie, or too close before them, are overtaken; so is a vertex that would come to the end of its
/// segment. Where some would change places, nobody on that segment slides.
/// @param list  slidable vertices, none twice
/// @par Cost O(k log k) for k vertices and those that they overtake
[[nodiscard]] SlidePlan PlanSlides(const Mesh& mesh, std::span<const PlaceOnWall> list);

}  // namespace pliant
