#include "client/cli/mesh_output.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <string_view>

#include "client/io/file.h"
#include "client/io/formats.h"

namespace pliant::cli {
namespace {

/// What io::WriteMesh can write.
constexpr std::array<std::string_view, 10> kExtensions = {
    ".mesh", ".meshb", ".msh", ".msh2", ".msh22", ".msh4", ".msh41", ".vtu", ".node", ".ele"};

}  // namespace

Status CheckMeshOutput(const std::string& path) {
  const std::string extension = io::Extension(path);
  if (std::ranges::find(kExtensions, extension) == kExtensions.end()) {
    return Error{.code = ErrorCode::kFileUnsupported,
                 .message = path +
                            ": meshes are written as .mesh .meshb .msh .msh2 .vtu .node or "
                            ".ele, not '" +
                            extension + "'",
                 .field = "--output"};
  }
  const std::filesystem::path folder = std::filesystem::path(path).parent_path();
  std::error_code ignored;
  if (!folder.empty() && !std::filesystem::is_directory(folder, ignored)) {
    return Error{
        .code = ErrorCode::kFileUnwritable,
        .message = path + ": the folder " + folder.string() + " does not exist; create it first",
        .field = "--output"};
  }
  return {};
}

Status WriteCompactMesh(const std::string& path, const client::CompactMesh& mesh) {
  std::vector<io::PointField> fields;
  if (io::Extension(path) == ".vtu" && !mesh.metrics.empty()) {
    fields.push_back(io::FieldFromMetrics(mesh.metrics));
  }
  return io::WriteMesh(path, mesh.mesh, fields);
}

}  // namespace pliant::cli
