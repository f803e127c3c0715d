#include "client/io/formats.h"

#include <cstddef>
#include <utility>

#include "client/io/file.h"
#include "client/io/gmsh.h"
#include "client/io/gmsh_writer.h"
#include "client/io/medit.h"
#include "client/io/sol.h"
#include "client/io/triangle.h"
#include "client/io/vtu.h"

namespace pliant::io {
namespace {

template <class T>
Result<T> InPath(const std::string& path, Result<T> result) {
  if (result.ok()) return result;
  Error error = result.error();
  error.message = path + ": " + error.message;
  return error;
}

Error UnknownExtension(const std::string& path, const char* known) {
  return {.code = ErrorCode::kFileUnsupported,
          .message = path + ": the extension '" + Extension(path) + "' is none of " + known,
          .field = path};
}

// Gmsh's own names for its formats; without a number it means the newest.
bool IsGmsh22(const std::string& extension) {
  return extension == ".msh2" || extension == ".msh22";
}
bool IsGmsh41(const std::string& extension) {
  return extension == ".msh" || extension == ".msh4" || extension == ".msh41";
}

Result<Geometry> ReadPoly(const std::string& path) {
  PLIANT_ASSIGN_OR_RETURN(const std::string poly, ReadFile(path));
  std::string node;
  if (PolyRefersToNodeFile(poly)) {
    PLIANT_ASSIGN_OR_RETURN(node, ReadFile(WithoutExtension(path) + ".node"));
  }
  PLIANT_ASSIGN_OR_RETURN(Domain domain, InPath(path, ParsePoly(poly, node)));
  return Geometry(std::move(domain));
}

Result<Geometry> ReadTriangleMesh(const std::string& path) {
  const std::string base = WithoutExtension(path);
  TriangleFiles files;
  PLIANT_ASSIGN_OR_RETURN(files.node, ReadFile(base + ".node"));
  PLIANT_ASSIGN_OR_RETURN(files.ele, ReadFile(base + ".ele"));
  if (FileExists(base + ".edge")) {
    PLIANT_ASSIGN_OR_RETURN(files.edge, ReadFile(base + ".edge"));
  }
  PLIANT_ASSIGN_OR_RETURN(MeshData mesh, InPath(base, ParseTriangleMesh(files)));
  return Geometry(std::move(mesh));
}

Error WrongLength(const std::string& name, std::size_t expected, std::size_t found) {
  return {.code = ErrorCode::kArrayLength,
          .message = name + " has " + std::to_string(found) + " values, but the mesh needs " +
                     std::to_string(expected),
          .field = name};
}

Status CheckLengths(const MeshData& mesh, const std::vector<PointField>& fields) {
  PLIANT_RETURN_IF_ERROR(CheckIndices(mesh));
  if (!mesh.triangle_tags.empty() && mesh.triangle_tags.size() != mesh.triangles.size()) {
    return WrongLength("triangle_tags", mesh.triangles.size(), mesh.triangle_tags.size());
  }
  if (!mesh.edge_tags.empty() && mesh.edge_tags.size() != mesh.edges.size()) {
    return WrongLength("edge_tags", mesh.edges.size(), mesh.edge_tags.size());
  }
  for (const PointField& field : fields) {
    if (field.component_count != 1 && field.component_count != 3) {
      return Error{
          .code = ErrorCode::kOutOfRange,
          .message = "a field has 1 or 3 components, not " + std::to_string(field.component_count),
          .field = field.name};
    }
    const std::size_t expected =
        mesh.points.size() * static_cast<std::size_t>(field.component_count);
    if (field.values.size() != expected) {
      return WrongLength(field.name, expected, field.values.size());
    }
  }
  return {};
}

Status WriteTriangleMesh(const std::string& path, const MeshData& mesh) {
  const std::string base = WithoutExtension(path);
  const TriangleFiles files = FormatTriangleMesh(mesh);
  PLIANT_RETURN_IF_ERROR(WriteFileAtomically(base + ".node", files.node));
  PLIANT_RETURN_IF_ERROR(WriteFileAtomically(base + ".ele", files.ele));
  return WriteFileAtomically(base + ".edge", *files.edge);
}

}  // namespace

Result<Geometry> ReadGeometry(const std::string& path) {
  const std::string extension = Extension(path);
  if (extension == ".poly") return ReadPoly(path);
  if (extension == ".node" || extension == ".ele") return ReadTriangleMesh(path);
  if (extension == ".mesh" || extension == ".meshb") {
    PLIANT_ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
    return InPath(path, ParseMedit(bytes));
  }
  if (IsGmsh22(extension) || IsGmsh41(extension)) {
    PLIANT_ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
    PLIANT_ASSIGN_OR_RETURN(GmshGeometry gmsh, InPath(path, ParseGmsh(bytes)));
    return std::move(gmsh.geometry);
  }
  return UnknownExtension(path, ".poly .node .ele .mesh .meshb .msh");
}

Result<PointField> ReadField(const std::string& path) {
  const std::string extension = Extension(path);
  if (extension != ".sol" && extension != ".solb" && extension != ".mtr") {
    return UnknownExtension(path, ".sol .solb .mtr");
  }
  PLIANT_ASSIGN_OR_RETURN(const std::string bytes, ReadFile(path));
  return InPath(path, extension == ".mtr" ? ParseMtr(bytes) : ParseSol(bytes));
}

Status WriteMesh(const std::string& path, const MeshData& mesh,
                 const std::vector<PointField>& fields) {
  const std::string extension = Extension(path);
  PLIANT_RETURN_IF_ERROR(CheckLengths(mesh, fields));
  if (extension == ".vtu") return WriteFileAtomically(path, FormatVtu(mesh, fields));
  if (IsGmsh22(extension)) return WriteFileAtomically(path, FormatGmsh22(mesh, fields));
  if (IsGmsh41(extension)) return WriteFileAtomically(path, FormatGmsh41(mesh, fields));
  if (!fields.empty()) {
    return Error{.code = ErrorCode::kFileUnsupported,
                 .message = path +
                            ": this format has no place for fields; write them to a .sol "
                            "file, or the mesh to .msh or .vtu",
                 .field = path};
  }
  if (extension == ".mesh") return WriteFileAtomically(path, FormatMedit(mesh));
  if (extension == ".meshb") return WriteFileAtomically(path, FormatMeditBinary(mesh));
  if (extension == ".node" || extension == ".ele") return WriteTriangleMesh(path, mesh);
  return UnknownExtension(path, ".mesh .meshb .msh .msh2 .vtu .node .ele");
}

Status WriteDomain(const std::string& path, const Domain& domain) {
  const std::string extension = Extension(path);
  if (extension == ".poly") return WriteFileAtomically(path, FormatPoly(domain));
  if (extension != ".mesh") return UnknownExtension(path, ".poly .mesh");
  if (!domain.holes.empty() || !domain.regions.empty()) {
    return Error{.code = ErrorCode::kFileUnsupported,
                 .message = path +
                            ": a Medit file has no place for the holes and regions of this "
                            "domain; write it to a .poly file",
                 .field = path};
  }
  MeshData mesh;
  mesh.points = domain.points;
  for (const Segment& s : domain.segments) {
    mesh.edges.push_back({s.a, s.b});
    mesh.edge_tags.push_back(s.tag);
  }
  PLIANT_RETURN_IF_ERROR(CheckIndices(mesh));
  return WriteFileAtomically(path, FormatMedit(mesh));
}

Status WriteField(const std::string& path, const PointField& field) {
  if (Extension(path) != ".sol") return UnknownExtension(path, ".sol");
  return WriteFileAtomically(path, FormatSol(field));
}

}  // namespace pliant::io
