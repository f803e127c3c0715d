#pragma once

#include <cstddef>

#include "core/mesh/mesh.h"
#include "core/mesh/star.h"
#include "core/pliant/crowd.h"
#include "core/pliant/options.h"

namespace pliant {

/// How much room a node takes, in normalized area: below 1 it is one too many.
///
/// Interior: 2.3 / sqrt(n (n - 2)) times the sum of the normalized areas of its n triangles. On a
/// segment: 0.5 times the squared sum of the normalized lengths of its two edges there.
/// [BossenHeckbert1996, sec. 3.2] @pre the star's center is not fixed
[[nodiscard]] double NodeExtent(const Mesh& mesh, const Star& star);
/// The same with as many neighbours as the crowd says; it was measured there.
[[nodiscard]] double NodeExtent(const Mesh& mesh, const Star& star, const Crowd& crowd);

/// A spoke of a star and its extent.
struct SpokeExtent {
  std::size_t spoke = 0;  ///< Index into Star::ring().
  double extent = 0;
};

/// The spoke of largest extent, the first of equals. Above 1 the edge is to be split.
///
/// Interior edge: 0.8 times the sum of the normalized areas of its two triangles. Constrained
/// edge: 0.5 times its squared normalized length. [BossenHeckbert1996, sec. 3.2]
[[nodiscard]] SpokeExtent LargestSpokeExtent(const Mesh& mesh, const Star& star);

/// Whether constraints let the edge at a spoke be split.
[[nodiscard]] bool MaySplit(const Mesh& mesh, const Star& star, std::size_t spoke,
                            const Permissions& permissions);

/// The same among the spokes that may be split; extent 0 if there is none.
[[nodiscard]] SpokeExtent LargestFreeSpokeExtent(const Mesh& mesh, const Star& star,
                                                 const Permissions& permissions);

}  // namespace pliant
