#pragma once

#include <string>
#include <vector>

#include "client/io/geometry.h"

namespace pliant::io {

/// The mesh as Gmsh text: tags become physical groups (0: none), one entity of the model for each,
/// elements in their order, and fields as $NodeData, tensors with all 9 components.
/// @pre the lengths of tags and fields fit the mesh
[[nodiscard]] std::string FormatGmsh22(const MeshData& mesh, const std::vector<PointField>& fields);
[[nodiscard]] std::string FormatGmsh41(const MeshData& mesh, const std::vector<PointField>& fields);

}  // namespace pliant::io
