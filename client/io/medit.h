#pragma once

#include <string>
#include <string_view>

#include "client/io/geometry.h"
#include "core/base/result.h"

namespace pliant::io {

/// Reads a Medit mesh, text (.mesh) or binary (.meshb, versions 1 to 4).
///
/// Vertices, Edges and Triangles count; other sections are skipped, except that elements which are
/// no triangles are refused. Dimension 3 is read if all z are equal. A file without triangles is
/// the domain of its edges. Tags are Medit's references; those of vertices are dropped.
///
/// Fails with kFileSyntax, kFileUnsupported, kIndexOutOfRange, kNotFinite, kOutOfRange, kTooLarge
/// or kEmpty; `index` is the line (text) or byte (binary), or the element for kIndexOutOfRange.
[[nodiscard]] Result<Geometry> ParseMedit(std::string_view bytes);

/// The mesh as Medit text, dimension 2.
[[nodiscard]] std::string FormatMedit(const MeshData& mesh);
/// The mesh as Medit binary, version 3 (32-bit numbers, 64-bit positions), little-endian.
[[nodiscard]] std::string FormatMeditBinary(const MeshData& mesh);

}  // namespace pliant::io
