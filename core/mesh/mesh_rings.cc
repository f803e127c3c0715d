#include "core/mesh/mesh_rings.h"

namespace pliant {

std::span<const std::int32_t> MeshRings::Neighbors(std::int32_t vertex) {
  const VertexId id(vertex);
  ring_.clear();
  const auto add = [&](TriangleId fan) {
    star_.Gather(mesh_, id, fan);
    for (const VertexId neighbor : star_.ring()) ring_.push_back(neighbor.value());
  };
  if (mesh_.vertex(id).pinched) {
    for (const TriangleId fan : FansOf(mesh_, id)) add(fan);
  } else {
    add(mesh_.vertex(id).triangle);
  }
  return ring_;
}

}  // namespace pliant
