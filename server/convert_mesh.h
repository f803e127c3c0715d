#pragma once

#include <string>

#include "core/base/result.h"
#include "core/geometry/domain.h"
#include "core/geometry/mesh_data.h"
#include "pliant/v1/mesh.pb.h"

/// Domains and meshes of the wire as core types: types, lengths, indices and finiteness of each
/// array are checked here; how the arrays fit together is the core's to check. Any thread.
namespace pliant::server {

/// Errors: kArrayType, kArrayLength, kIndexOutOfRange, kNotFinite, kEmpty; `field` is
/// "domain.points" and so on.
[[nodiscard]] Result<Domain> ConvertDomain(const v1::Domain& wire);

/// The same for a mesh. @param path  prefix of `field`: "mesh", or where a background mesh stands.
[[nodiscard]] Result<MeshData> ConvertMesh(const v1::MeshInput& wire, const std::string& path);

}  // namespace pliant::server
