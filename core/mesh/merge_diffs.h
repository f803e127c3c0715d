#pragma once

#include <cstddef>

#include "core/mesh/mesh_diff.h"

namespace pliant {

/// Two diffs in a row as one: what takes the mesh of `first.base_revision` to that of
/// `second.revision`. An element that comes in the first and goes in the second is absent. One that
/// changes in the first and changes back in the second is named, with the contents that it had: the
/// diffs do not tell what was before. Transfer rows are left out: merged they would have more than
/// three sources.
/// @pre second.base_revision == first.revision
/// @par Cost O(first + second)
[[nodiscard]] MeshDiff MergeDiffs(const MeshDiff& first, const MeshDiff& second);

/// Memory that a diff's columns hold, in bytes.
[[nodiscard]] std::size_t BytesOf(const MeshDiff& diff);

}  // namespace pliant
