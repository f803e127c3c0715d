#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/io/geometry.h"
#include "core/base/result.h"

namespace pliant::io {

/// The text formats of the mesh generator Triangle [Shewchuk1996]. Comments run from # to the end
/// of the line; elements count from 0 or from 1, as the first point says.
///
/// All fail with kFileSyntax, kFileUnsupported (dimension other than 2), kIndexOutOfRange,
/// kNotFinite, kOutOfRange or kTooLarge; `index` is the line, or the element for kIndexOutOfRange.

/// True if the text of a .poly has no points of its own: they stand in the .node file beside it.
[[nodiscard]] bool PolyRefersToNodeFile(std::string_view poly);

/// Reads a .poly: points, segments with markers as tags, holes, regional attributes as region tags
/// (which must be integers). `node` is the .node file for a .poly without points of its own.
[[nodiscard]] Result<Domain> ParsePoly(std::string_view poly, std::string_view node = {});
[[nodiscard]] std::string FormatPoly(const Domain& domain);

/// The text of the files that make up one mesh.
struct TriangleFiles {
  std::string node;
  std::string ele;
  std::optional<std::string> edge;
};

/// Reads a mesh. The first attribute of a triangle is its tag. Triangle itself lists all edges in
/// .edge, marking the constrained ones; so if the list has more edges than any proper part of them
/// could (2 edges > 3 triangles), those with marker 0 are left out.
[[nodiscard]] Result<MeshData> ParseTriangleMesh(const TriangleFiles& files);
/// The mesh with its constrained edges in .edge; counts from 1.
[[nodiscard]] TriangleFiles FormatTriangleMesh(const MeshData& mesh);

}  // namespace pliant::io
