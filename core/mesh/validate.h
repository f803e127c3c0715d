#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/mesh/mesh.h"

namespace pliant {

/// Checks everything that a mesh promises, from its records alone: slot counts, symmetric
/// neighbours that share two vertices the other way round, positive triangles by exact predicates,
/// edge lists, constrained bits, that every segment is covered from end to end by edges in order
/// with their ends on it, one closed fan around an interior vertex and one open one around a
/// boundary vertex (pinched ones excepted), finite positions and positive definite metrics.
///
/// @return what is wrong, at most 20 sentences; empty for a valid mesh.
/// @par Cost O(mesh). Tests call it after every operation.
[[nodiscard]] std::vector<std::string> Validate(const Mesh& mesh);

/// Signed area of all live triangles, summed in slot order, in domain units squared.
[[nodiscard]] double Area(const Mesh& mesh);

}  // namespace pliant
