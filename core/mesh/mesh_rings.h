#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/mesh.h"
#include "core/mesh/star.h"
#include "core/metric/limiter.h"

namespace pliant {

/// The vertices of a mesh and the edges between them, as the metric's limits see them: numbered by
/// slot, both sides of a pinched vertex in one ring.
///
/// Rings are asked for again and again, from vertices nearby: the last ones are remembered, so that
/// this is for as long as the mesh does not change.
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
  static constexpr std::size_t kKnownMax = 1 << 12;  ///< Rings, some 250 KB.
  static constexpr std::size_t kRingMax = 13;        ///< Larger ones are gathered each time.

  /// A ring that was gathered.
  struct Known {
    std::int32_t vertex = -1;
    std::uint16_t count = 0;
    std::array<std::int32_t, kRingMax> ring;
  };

  template <class Visit>
  void ForEachFan(VertexId vertex, Visit visit);

  const Mesh& mesh_;
  Star star_;
  std::vector<TriangleId> triangles_;
  std::vector<std::int32_t> ring_;
  std::vector<Known> known_;  // By the last bits of the slot; empty until asked.
};

}  // namespace pliant
