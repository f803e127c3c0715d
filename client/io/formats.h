#pragma once

#include <string>
#include <vector>

#include "client/io/geometry.h"
#include "core/base/result.h"

namespace pliant::io {

/// Reads a domain or a mesh; the extension says the format:
///   .poly            Triangle domain (with the .node file beside it if it has no points itself)
///   .node .ele       Triangle mesh: .node, .ele and, if it exists, .edge of the same base name
///   .mesh .meshb     Medit
///   .msh             Gmsh 2.2 and 4.1 (the file says which), also .msh2 .msh22 .msh4 .msh41
/// The message of an error starts with the path. Fails with kFileNotFound, kFileUnreadable,
/// kFileUnsupported (also for an unknown extension) and what the format's own reader says.
/// @par Cost one pass; about a second for 1M points; memory a few times the file's size.
[[nodiscard]] Result<Geometry> ReadGeometry(const std::string& path);

/// Reads sizes or tensors at points: .sol, .solb (Medit) or .mtr (BAMG).
[[nodiscard]] Result<PointField> ReadField(const std::string& path);

/// Writes a mesh; the extension says the format: .mesh, .meshb, .msh (Gmsh 4.1; .msh2 for
/// Gmsh 2.2), .vtu, and .node or .ele for Triangle's .node, .ele and .edge of that base name.
///
/// `fields` go into .msh and .vtu; the other formats have no place for them and refuse them with
/// kFileUnsupported (write them beside the mesh with WriteField). Each file is replaced in one
/// step. Fails with kFileUnwritable, kFileUnsupported or kArrayLength (a field or an array of tags
/// whose length does not fit the mesh).
[[nodiscard]] Status WriteMesh(const std::string& path, const MeshData& mesh,
                               const std::vector<PointField>& fields = {});

/// Writes a domain: .poly, or .mesh (only without holes and regions, for which it has no place).
[[nodiscard]] Status WriteDomain(const std::string& path, const Domain& domain);

/// Writes a field: .sol.
[[nodiscard]] Status WriteField(const std::string& path, const PointField& field);

}  // namespace pliant::io
