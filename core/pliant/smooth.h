#pragma once

#include <span>

#include "core/geometry/vec2.h"
#include "core/mesh/mesh.h"
#include "core/metric/metric.h"
#include "core/pliant/options.h"

namespace pliant {

/// f(d): how strongly a neighbour at distance d pushes (positive) or pulls (negative) a node.
/// @param d  metric distance by eq. 4, > 0. @return finite. [BossenHeckbert1996, fig. 6]
[[nodiscard]] double SmoothingForce(Smoothing smoothing, double d);

/// The step of eq. 2: alpha * sum over neighbours of f(d_ij) u_ij, with u_ij = (p_i - p_j) / d_ij.
///
/// @param neighbors  the vertices that share an edge with `node`, in a fixed order.
/// @param weights    of their forces, one for each neighbour (crowd.h); empty: 1. Not Laplacian's.
/// @param alpha      the step; Laplacian smoothing uses 1/n instead, whatever is given.
/// @return displacement in domain units.
[[nodiscard]] Vec2 SmoothingStep(const Mesh& mesh, VertexId node,
                                 std::span<const VertexId> neighbors, Smoothing smoothing,
                                 double alpha, std::span<const double> weights = {});

}  // namespace pliant
