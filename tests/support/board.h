#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/ids.h"
#include "core/delaunay/overtaken.h"
#include "core/geometry/predicates.h"
#include "core/geometry/vec2.h"
#include "tests/support/mesh_testing.h"

namespace pliant::testing {

/// A grid of 8 x 8 cells of which some vertices have been put elsewhere.
struct Board {
  void Put(VertexId vertex, Vec2 to) {
    before[vertex.index()] = grid->mesh.position(vertex);
    grid->edit.PlaceVertex(vertex, to);
    moved.push_back(vertex);
  }
  [[nodiscard]] std::vector<TriangleId> Inverted() const {
    std::vector<TriangleId> inverted;
    for (std::int32_t t = 0; t < grid->mesh.triangle_slots(); ++t) {
      const auto& v = grid->mesh.triangle(TriangleId(t)).vertices;
      if (Orient2d(grid->mesh.position(v[0]), grid->mesh.position(v[1]),
                   grid->mesh.position(v[2])) <= 0) {
        inverted.emplace_back(t);
      }
    }
    return inverted;
  }
  [[nodiscard]] bool Moved(VertexId vertex) const {
    return std::find(moved.begin(), moved.end(), vertex) != moved.end();
  }
  [[nodiscard]] SuddenMove Move() const {
    return {.before =
                [this](VertexId vertex) {
                  return Moved(vertex) ? before[vertex.index()] : grid->mesh.position(vertex);
                },
            .is_free =
                [this](VertexId vertex) {
                  return !grid->mesh.vertex(vertex).fixed &&
                         !grid->mesh.vertex(vertex).edge.valid();
                }};
  }

  std::unique_ptr<EditedMesh> grid = ImportedMesh(GridData(8, 8));
  std::vector<Vec2> before = std::vector<Vec2>(81);
  std::vector<VertexId> moved;
};

}  // namespace pliant::testing
