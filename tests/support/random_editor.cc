// RandomEditor of mesh_testing.h.

#include <optional>

#include "core/geometry/predicates.h"
#include "core/mesh/star.h"
#include "core/pliant/remove.h"
#include "tests/support/mesh_testing.h"

namespace pliant::testing {
namespace {

VertexId CornerAt(const TriangleRecord& triangle, int corner) {
  return triangle.vertices[static_cast<std::size_t>(corner)];
}

TriangleId Beyond(const Mesh& mesh, Side side) {
  return mesh.triangle(side.triangle).neighbors[static_cast<std::size_t>(side.corner)];
}

bool SplitsWell(const Mesh& mesh, Side side, Vec2 point) {
  const TriangleRecord& triangle = mesh.triangle(side.triangle);
  const Vec2 apex = mesh.position(CornerAt(triangle, side.corner));
  const Vec2 a = mesh.position(CornerAt(triangle, NextCorner(side.corner)));
  const Vec2 b = mesh.position(CornerAt(triangle, PreviousCorner(side.corner)));
  return Orient2d(apex, a, point) > 0 && Orient2d(apex, point, b) > 0;
}

bool StaysPositive(const Mesh& mesh, const Star& star, Vec2 center) {
  for (std::size_t k = 0; k < star.triangles().size(); ++k) {
    const Vec2 a = mesh.position(star.ring()[k]);
    if (Orient2d(center, a, mesh.position(star.ring_after(k))) <= 0) return false;
  }
  return true;
}

}  // namespace

std::string RandomEditor::Step() {
  switch (rng_.Below(6)) {
    case 0:
      return Swap() ? "swap" : "";
    case 1:
      return Split() ? "split" : "";
    case 2:
      return Move() ? "move" : "";
    case 3:
      return Slide() ? "slide" : "";
    case 4:
      return Remove() ? "remove" : "";
    default:
      return ChangeMetric() ? "metric" : "";
  }
}

Side RandomEditor::RandomSide() {
  const std::vector<TriangleId> live = LiveTriangles(target_.mesh);
  return {live[rng_.Below(live.size())], static_cast<int>(rng_.Below(3))};
}

VertexId RandomEditor::RandomVertex() {
  const std::vector<VertexId> live = LiveVertices(target_.mesh);
  return live[rng_.Below(live.size())];
}

bool RandomEditor::Swap() {
  const Mesh& mesh = target_.mesh;
  const Side side = RandomSide();
  const TriangleRecord& t = mesh.triangle(side.triangle);
  const TriangleId other = Beyond(mesh, side);
  if (t.IsConstrained(side.corner) || !other.valid()) return false;
  const Vec2 p = mesh.position(CornerAt(t, side.corner));
  const Vec2 a = mesh.position(CornerAt(t, NextCorner(side.corner)));
  const Vec2 b = mesh.position(CornerAt(t, PreviousCorner(side.corner)));
  const Vec2 q =
      mesh.position(CornerAt(mesh.triangle(other), mesh.SideTowards(other, side.triangle)));
  if (Orient2d(p, a, q) <= 0 || Orient2d(q, b, p) <= 0) return false;
  target_.edit.SwapEdge(side);
  return true;
}

bool RandomEditor::Split() {
  const Mesh& mesh = target_.mesh;
  const Side side = RandomSide();
  const TriangleRecord& t = mesh.triangle(side.triangle);
  const VertexId a = CornerAt(t, NextCorner(side.corner));
  const VertexId b = CornerAt(t, PreviousCorner(side.corner));
  const double share = rng_.Uniform(0.2, 0.8);
  Vec2 point = mesh.position(a) + share * (mesh.position(b) - mesh.position(a));
  double parameter = 0;
  if (const EdgeId id = mesh.FindEdge(a, b); id.valid()) {
    const EdgeRecord& edge = mesh.edge(id);
    parameter = edge.parameters[0] + share * (edge.parameters[1] - edge.parameters[0]);
    if (!(edge.parameters[0] < parameter && parameter < edge.parameters[1])) return false;
    point = mesh.PointOnSegment(edge.segment, parameter);
  }
  const TriangleId other = Beyond(mesh, side);
  if (!SplitsWell(mesh, side, point)) return false;
  if (other.valid() && !SplitsWell(mesh, {other, mesh.SideTowards(other, side.triangle)}, point)) {
    return false;
  }
  target_.edit.SplitEdge(side, point, parameter);
  return true;
}

bool RandomEditor::Move() {
  const Mesh& mesh = target_.mesh;
  const VertexId vertex = RandomVertex();
  if (mesh.vertex(vertex).fixed || mesh.vertex(vertex).edge.valid()) return false;
  Star star;
  star.Gather(mesh, vertex);
  const Vec2 towards = mesh.position(star.ring()[rng_.Below(star.ring().size())]);
  const Vec2 at = mesh.position(vertex);
  const Vec2 target = at + rng_.Uniform(0.01, 0.6) * (towards - at);
  if (!StaysPositive(mesh, star, target)) return false;
  target_.edit.MoveVertex(vertex, target);
  return true;
}

bool RandomEditor::Slide() {
  const Mesh& mesh = target_.mesh;
  const VertexId vertex = RandomVertex();
  if (mesh.vertex(vertex).fixed || !mesh.vertex(vertex).edge.valid()) return false;
  const auto [before, after] = mesh.SegmentEdges(vertex);
  const double low = mesh.edge(before).parameters[0];
  const double high = mesh.edge(after).parameters[1];
  const double t = low + rng_.Uniform(0.1, 0.9) * (high - low);
  Star star;
  star.Gather(mesh, vertex);
  if (!(low < t && t < high)) return false;
  if (!StaysPositive(mesh, star, mesh.PointOnSegment(mesh.edge(before).segment, t))) return false;
  target_.edit.SlideVertex(vertex, t);
  return true;
}

bool RandomEditor::Remove() {
  const VertexId vertex = RandomVertex();
  if (target_.mesh.vertex(vertex).fixed) return false;
  Star star;
  star.Gather(target_.mesh, vertex);
  return RemoveNode(target_.edit, flipper_, star).has_value();
}

bool RandomEditor::ChangeMetric() {
  const VertexId vertex = RandomVertex();
  target_.edit.SetMetric(vertex, Metric::Isotropic(rng_.Uniform(0.5, 2)));
  target_.edit.Visit(vertex).age = static_cast<std::uint8_t>(rng_.Below(80));
  return true;
}

}  // namespace pliant::testing
