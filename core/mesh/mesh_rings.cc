#include "core/mesh/mesh_rings.h"

#include <algorithm>

namespace pliant {

/// Gathers each fan of a vertex into star_.
template <class Visit>
void MeshRings::ForEachFan(VertexId vertex, Visit visit) {
  if (!mesh_.vertex(vertex).pinched) {
    star_.Gather(mesh_, vertex);
    visit();
    return;
  }
  for (const TriangleId fan : FansOf(mesh_, vertex)) {
    star_.Gather(mesh_, vertex, fan);
    visit();
  }
}

std::span<const std::int32_t> MeshRings::Neighbors(std::int32_t vertex) {
  if (known_.empty()) known_.resize(kKnownMax);
  Known& known = known_[static_cast<std::size_t>(vertex) % kKnownMax];
  if (known.vertex == vertex) return std::span(known.ring).first(known.count);
  const VertexId id(vertex);
  ring_.clear();
  ForEachFan(id, [&] {
    for (const VertexId neighbor : star_.ring()) ring_.push_back(neighbor.value());
  });
  if (ring_.size() <= kRingMax) {
    known.vertex = vertex;
    known.count = static_cast<std::uint16_t>(ring_.size());
    std::ranges::copy(ring_, known.ring.begin());
  }
  return ring_;
}

double MeshRings::Area(std::int32_t vertex) {
  const VertexId id(vertex);
  // Slots in ascending order, so that the sum does not depend on where the fan begins.
  triangles_.clear();
  ForEachFan(id, [&] {
    triangles_.insert(triangles_.end(), star_.triangles().begin(), star_.triangles().end());
  });
  std::sort(triangles_.begin(), triangles_.end());
  double doubled = 0;
  for (const TriangleId triangle : triangles_) {
    const int corner = mesh_.CornerOf(triangle, id);
    const auto& v = mesh_.triangle(triangle).vertices;
    const Vec2 center = mesh_.position(id);
    doubled += Cross(mesh_.position(v[static_cast<std::size_t>(NextCorner(corner))]) - center,
                     mesh_.position(v[static_cast<std::size_t>(PreviousCorner(corner))]) - center);
  }
  return doubled / 6;
}

}  // namespace pliant
