#pragma once

#include <cstddef>
#include <span>

#include "core/base/bytes.h"
#include "core/base/result.h"
#include "core/mesh/mesh_diff.h"

namespace pliant {

/// A whole mesh, with its metric and fields, as bytes to keep: versioned, little-endian, with a
/// checksum. What a diff has beyond a snapshot (transfer rows, names of dropped fields) is not
/// written.
///
/// @pre `snapshot` is a diff from nothing: base_revision is kNone and nothing is removed.
/// @par Cost O(mesh), about 45 bytes a vertex and its triangles, and 32 with its metric.
[[nodiscard]] Bytes WriteMeshSnapshot(const MeshDiff& snapshot);

/// What WriteMeshSnapshot wrote, checked so far that whoever reads it may index by it: ids ascend,
/// and corners, ends, metric and fields name elements that are there. Errors: kDataCorrupt,
/// kDataVersion.
[[nodiscard]] Result<MeshDiff> ReadMeshSnapshot(std::span<const std::byte> bytes);

}  // namespace pliant
