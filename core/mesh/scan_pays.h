#pragma once

#include <cstddef>

#include "core/mesh/mesh.h"

namespace pliant {

/// Whether the triangles at so many vertices are found faster by reading all triangles of the mesh
/// than by going around each vertex.
[[nodiscard]] inline bool ScanPays(const Mesh& mesh, std::ptrdiff_t vertex_count) {
  constexpr std::ptrdiff_t kTrianglesPerVertex = 12;
  return kTrianglesPerVertex * vertex_count > mesh.triangle_slots();
}

}  // namespace pliant
