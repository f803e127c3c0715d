#pragma once

#include <vector>

#include "core/geometry/mesh_data.h"
#include "core/mesh/mesh.h"

namespace pliant {

/// A mesh as plain arrays, live elements only, in ascending order of slot.
struct ExportedMesh {
  MeshData data;
  std::vector<VertexId> vertex_ids;      ///< Slot of each point.
  std::vector<TriangleId> triangle_ids;  ///< Slot of each triangle.
  std::vector<EdgeId> edge_ids;          ///< Slot of each edge.
};

/// @par Cost O(mesh)
[[nodiscard]] ExportedMesh ExportMesh(const Mesh& mesh);

}  // namespace pliant
