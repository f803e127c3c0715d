#pragma once

#include <cstdint>
#include <memory>

#include "core/transfer/transfer.h"
#include "tests/support/mesh_testing.h"

namespace pliant::testing {

/// A mesh after random edits since its last commit, with a copy of it as it was then.
struct RandomTransfer {
  RandomTransfer(const MeshData& data, std::uint64_t seed, int steps) : now(ImportedMesh(data)) {
    RandomEditor editor(*now, seed);
    for (int i = 0; i < 3 * steps; ++i) editor.Step();
    (void)now->edit.Commit(Revision(1));
    before = now->mesh;
    for (int i = 0; i < steps; ++i) editor.Step();
    transfer = std::make_unique<MeshTransfer>(now->mesh, now->edit.log());
  }

  std::unique_ptr<EditedMesh> now;
  Mesh before;
  std::unique_ptr<MeshTransfer> transfer;
};

/// The square (0, 10)^2 as a grid whose cells a shear and a stretch have made thin.
[[nodiscard]] inline MeshData ThinGrid() {
  MeshData data = GridData(10, 10);
  for (Vec2& p : data.points) p = {p.x + 0.37 * p.y, 0.02 * p.y + 0.0013 * p.x};
  return data;
}

/// Corners of a live triangle.
[[nodiscard]] inline std::array<Vec2, 3> CornersIn(const Mesh& mesh, TriangleId id) {
  const auto& v = mesh.triangle(id).vertices;
  return {mesh.position(v[0]), mesh.position(v[1]), mesh.position(v[2])};
}

}  // namespace pliant::testing
