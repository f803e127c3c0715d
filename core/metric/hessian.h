#pragma once

#include <span>
#include <vector>

#include "core/geometry/mesh_data.h"
#include "core/metric/metric.h"

namespace pliant {

/// The second derivatives of a function that is known at the vertices of a mesh.
///
/// Around each vertex a quadratic polynomial is fitted by least squares to the values at its
/// neighbours of first, second and, where those are few (on the boundary), further rings; nearer
/// ones weigh more. The fit is made in coordinates in which the patch is round, so that thin
/// patches of an anisotropic mesh are as well conditioned as others. [ZhangNaga2005]
///
/// Exact for quadratic polynomials, on the boundary too; of first order on general meshes. A vertex
/// whose patch does not determine a quadratic polynomial (a mesh of very few vertices, or no
/// triangle) has the Hessian 0.
/// @param values  one per point, finite.
/// @return one per point; a Hessian is symmetric but in general no metric.
/// @par Cost  O(n), about 2 us a vertex.
[[nodiscard]] std::vector<Metric> RecoverHessians(const MeshData& mesh,
                                                  std::span<const double> values);

/// The symmetric tensor with the same axes and the eigenvalues' absolute values.
[[nodiscard]] Metric AbsoluteValue(const Metric& hessian);

}  // namespace pliant
