#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/mesh/star.h"
#include "core/metric/limiter.h"

namespace pliant {

/// The vertices of a mesh and the edges between them, as the metric's limits see them: numbered by
/// slot, both sides of a pinched vertex in one ring.
class MeshRings final : public VertexRings {
 public:
  explicit MeshRings(const Mesh& mesh) : mesh_(mesh) {}

  [[nodiscard]] Vec2 position(std::int32_t vertex) const override {
    return mesh_.position(VertexId(vertex));
  }
  /// @pre the vertex is live
  [[nodiscard]] std::span<const std::int32_t> Neighbors(std::int32_t vertex) override;
  [[nodiscard]] double Area(std::int32_t vertex) override;

 private:
  template <class Visit>
  void ForEachFan(VertexId vertex, Visit visit);

  const Mesh& mesh_;
  Star star_;
  std::vector<TriangleId> triangles_;
  std::vector<std::int32_t> ring_;
};

}  // namespace pliant
