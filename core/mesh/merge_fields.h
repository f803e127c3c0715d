#pragma once

#include "core/mesh/mesh_diff.h"

namespace pliant {

/// What two diffs in a row do to fields, as one: of values that both name the later ones, and none
/// of elements that the second removes or of fields that it drops.
/// @pre second.base_revision == first.revision @par Cost O(first + second)
[[nodiscard]] FieldChanges MergeFields(const MeshDiff& first, const MeshDiff& second);

}  // namespace pliant
