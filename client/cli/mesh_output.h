#pragma once

#include <string>
#include <vector>

#include "client/cpp/mesh_replica.h"
#include "core/base/result.h"

namespace pliant::cli {

/// Says at once, before hours of work, that a mesh cannot be written there: kFileUnsupported for an
/// unknown extension, kFileUnwritable for a folder that does not exist.
[[nodiscard]] Status CheckMeshOutput(const std::string& path);

/// Writes the mesh, its metric (if known) with it as point data in .vtu files.
[[nodiscard]] Status WriteCompactMesh(const std::string& path, const client::CompactMesh& mesh);

}  // namespace pliant::cli
