#pragma once

#include <cstdint>
#include <vector>

#include "core/base/ids.h"
#include "core/base/result.h"
#include "core/mesh/change_log.h"
#include "core/mesh/mesh.h"
#include "core/mesh/mesh_edit.h"
#include "core/pliant/options.h"

namespace pliant {

/// What a session must leave alone, from now on and until other constraints replace these.
struct Constraints {
  /// Stay in their place, bit for bit, and are not deleted.
  std::vector<VertexId> vertices = {};
  /// Constrained edges that are not split; their ends stay.
  std::vector<EdgeId> edges = {};
  /// Tags of regions whose triangles stay, with their corners and all their edges.
  std::vector<std::int32_t> regions = {};
  /// What the loop may do everywhere else.
  Permissions permissions = {};
};

/// Elements that carry the mark `frozen`, each list ascending.
struct FrozenElements {
  std::vector<VertexId> vertices;
  std::vector<EdgeId> edges;
  std::vector<TriangleId> triangles;

  [[nodiscard]] bool empty() const {
    return vertices.empty() && edges.empty() && triangles.empty();
  }
};

/// What constraints freeze on the mesh as it is: what they name, and what that stands on.
/// Errors: kIndexOutOfRange (no live element, or no triangle of a region), kDuplicateId; `field` is
/// "constraints.frozen_vertices" and so on, `index` the position there.
/// @par Cost O(k log k) for k ids; with regions O(mesh)
[[nodiscard]] Result<FrozenElements> WhatFreezes(const Mesh& mesh, const Constraints& constraints);

/// Every element that carries the mark now. @par Cost O(mesh)
[[nodiscard]] FrozenElements FrozenOf(const Mesh& mesh);

/// Freezes and thaws what differs between what is frozen and what shall be.
/// @return the live vertices at what has thawed, ascending: the loop may do better there now.
/// @par Cost O(what is frozen + what shall be)
std::vector<VertexId> ChangeFrozen(MeshEdit& edit, const FrozenElements& now,
                                   const FrozenElements& wanted);

/// Refuses a change of the mesh, known by the log of what stood there before it, that has moved,
/// removed or replaced anything frozen. Error: kFrozen, naming the first such thing.
/// @par Cost O(log)
[[nodiscard]] Status CheckFrozenKept(const Mesh& mesh, const ChangeLog& log);

}  // namespace pliant
