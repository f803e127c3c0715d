#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "core/base/ids.h"
#include "core/mesh/mesh.h"

namespace pliant {

/// Checks what one operation may have broken: that some triangles are alive, positive by exact
/// predicates and neighbours both ways with all around them, that their constrained bits tell of
/// edges that are there, name an incident triangle and lie in order on their segment, and that
/// their corners name a triangle that has them. Validate without what needs a look at the whole
/// mesh.
///
/// @return the first fault, empty if there is none.
/// @par Cost O(triangles and the constrained edges at their corners)
[[nodiscard]] std::string FaultAround(const Mesh& mesh, std::span<const TriangleId> triangles);

/// Fails a PLIANT_CHECK with what FaultAround finds, and counts an operation as validated. MeshEdit
/// calls it after every operation if kValidateEvery.
void CheckOperation(const Mesh& mesh, std::span<const TriangleId> triangles);
/// The same for all triangles at a vertex.
void CheckOperation(const Mesh& mesh, VertexId vertex);

/// Operations that CheckOperation has passed in this process.
[[nodiscard]] std::int64_t ValidatedOperationCount();

}  // namespace pliant
