#pragma once

#include "core/base/stop_signal.h"
#include "core/geometry/locate.h"
#include "core/mesh/mesh.h"

namespace pliant {

/// The live triangles of a mesh, numbered like those of ExportMesh, with their neighbours.
struct MeshTriangles {
  LinkedTriangles linked;
  std::vector<std::int32_t> rank_of;  ///< By slot of a live triangle, its number.
};

/// @param stop  if given and it asks to, the rest is left out: then only to be thrown away.
/// @par Cost O(mesh)
[[nodiscard]] MeshTriangles LinkTriangles(const Mesh& mesh, const StopSignal* stop = nullptr);

}  // namespace pliant
