#pragma once

#include <string>
#include <vector>

#include "client/io/geometry.h"

namespace pliant::io {

/// The mesh as a VTK unstructured grid in XML, for ParaView: triangles, then constrained edges as
/// lines, the cell array "tag" with the tag of each, and the fields as point arrays, tensors with
/// all 9 components. Numbers as inline base64, little-endian. @pre the lengths fit the mesh.
[[nodiscard]] std::string FormatVtu(const MeshData& mesh, const std::vector<PointField>& fields);

}  // namespace pliant::io
