#pragma once

#include <cstdint>
#include <optional>

#include "core/delaunay/metric_flip.h"
#include "core/mesh/mesh_edit.h"
#include "core/mesh/star.h"
#include "core/metric/metric_field.h"

namespace pliant {

/// True if splitting a side at `point` leaves positive triangles on both sides of it.
[[nodiscard]] bool SplitsWell(const Mesh& mesh, Side side, Vec2 point);

/// A vertex that an insertion made, and the swaps it caused.
struct Insertion {
  VertexId vertex;
  std::int32_t swaps = 0;
};

/// How InsertOnSpoke restores the Delaunay criterion.
enum class AfterInsertion { kSwapEdges, kLeaveEdges };

/// Splits a spoke of a star at its midpoint (a constrained edge at the middle of its parameters),
/// gives the new vertex the field's metric, and swaps edges around it.
/// [BossenHeckbert1996, sec. 3.2]
/// @return nothing (and the mesh untouched) if a new triangle would not be positive.
std::optional<Insertion> InsertOnSpoke(MeshEdit& edit, MetricFlipper& flipper,
                                       const MetricField& field, const Star& star,
                                       std::size_t spoke, AfterInsertion after);

}  // namespace pliant
