#include "core/pliant/nodal_field.h"

#include <array>

namespace pliant {

Metric NodalField::At(Vec2 p, std::int32_t& hint) const {
  const Location location = mesh_->Locate(p, hint);
  hint = location.triangle;
  const std::array<VertexId, 3> corners = mesh_->triangle(TriangleId(hint)).vertices;
  LogMetric mean = location.weights[0] * mesh_->Log(corners[0]);
  for (std::size_t k = 1; k < 3; ++k) {
    mean = mean + location.weights[k] * mesh_->Log(corners[k]);
  }
  return Exp(mean);
}

}  // namespace pliant
