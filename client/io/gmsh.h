#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "client/io/geometry.h"
#include "core/base/result.h"

namespace pliant::io {

/// What a Gmsh file holds.
struct GmshGeometry {
  Geometry geometry;
  /// The file's number of each point. Nodes of no triangle and no line (centres of circles, say)
  /// are left out, and numbers may have gaps, so this is not simply 1, 2, 3...
  std::vector<std::int64_t> node_numbers;
};

/// Reads a Gmsh mesh, version 2.2 or 4.1, text or binary (either byte order).
///
/// Triangles and lines count, with their physical groups as tags (the first one, 0 if none); points
/// of the model are skipped. All nodes must have the same z. A file without triangles is the domain
/// of its lines.
///
/// Fails with kFileSyntax, kFileUnsupported (other versions, other elements, a surface in space,
/// partitions), kIndexOutOfRange (an element names a node that is not there), kDuplicateId (two
/// nodes with one number), kNotFinite, kOutOfRange, kTooLarge or kEmpty.
[[nodiscard]] Result<GmshGeometry> ParseGmsh(std::string_view bytes);

}  // namespace pliant::io
