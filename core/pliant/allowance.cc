#include "core/pliant/allowance.h"

#include <algorithm>
#include <cmath>

namespace pliant {
namespace {

/// More insertions than anybody's memory can hold.
constexpr double kGrantMax = 1e15;

/// An estimate that grants less than this share more is no reason to go on: the metric asks for no
/// more than before.
constexpr std::int64_t kShareOfUsed = 4;

}  // namespace

double WantedNodeCount(const Mesh& mesh) {
  constexpr double kNodesPerArea = 1.1547005383792515;  // 2 / sqrt 3
  double area = 0;
  for (std::int32_t t = 0; t < mesh.triangle_slots(); ++t) {
    const TriangleRecord& triangle = mesh.triangle(TriangleId(t));
    if (!triangle.live) continue;
    const VertexRecord& a = mesh.vertex(triangle.vertices[0]);
    const VertexRecord& b = mesh.vertex(triangle.vertices[1]);
    const VertexRecord& c = mesh.vertex(triangle.vertices[2]);
    area += NormalizedArea(a.position, a.metric, b.position, b.metric, c.position, c.metric);
  }
  return kNodesPerArea * area;
}

void InsertionAllowance::BeginUpdate(const Mesh& mesh) {
  state_ = {0, kAllowanceFloor + kAllowancePerNode * mesh.vertex_count(), false};
}

bool InsertionAllowance::TakeMore(const Mesh& mesh) {
  if (state_.exhausted) return false;
  const double wanted = std::min(
      static_cast<double>(kAllowanceFloor) + kAllowancePerNode * WantedNodeCount(mesh), kGrantMax);
  const auto granted = static_cast<std::int64_t>(wanted);
  state_.exhausted = granted < state_.used + state_.used / kShareOfUsed;
  if (state_.exhausted) return false;
  state_.granted = granted;
  return state_.used < state_.granted && Use();
}

}  // namespace pliant
