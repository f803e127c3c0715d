#pragma once

#include "core/mesh/mesh_diff.h"
#include "core/mesh/mesh_edit.h"

namespace pliant {

/// The mesh of the last commit as a diff from nothing, whatever has changed since: the change log
/// knows what stood where something else stands now.
/// @param revision  of that commit. @pre there was one
/// @par Cost O(mesh + changed log changed)
[[nodiscard]] MeshDiff CommittedSnapshot(const MeshEdit& edit, Revision revision);

}  // namespace pliant
