#include "core/pliant/snap.h"

#include <optional>
#include <vector>

#include "core/geometry/predicates.h"

namespace pliant {
namespace {

/// The star's triangle through whose link edge the way from the center to `target` leaves.
std::optional<std::size_t> CrossedTriangle(const Mesh& mesh, const Star& star, Vec2 target) {
  const Vec2 p = mesh.position(star.center());
  for (std::size_t k = 0; k < star.triangles().size(); ++k) {
    const Vec2 a = mesh.position(star.ring()[k]);
    const Vec2 b = mesh.position(star.ring_after(k));
    if (Orient2d(p, a, target) >= 0 && Orient2d(p, target, b) > 0 && Orient2d(a, b, target) <= 0) {
      return k;
    }
  }
  return std::nullopt;
}

/// Where the way from p to target crosses the edge, as a parameter of its segment.
double CrossingParameter(const Mesh& mesh, const EdgeRecord& edge, Vec2 p, Vec2 target) {
  const Vec2 a = mesh.position(edge.vertices[0]);
  const Vec2 b = mesh.position(edge.vertices[1]);
  const double before = Cross(target - p, a - p);
  const double after = Cross(target - p, b - p);
  const double share = before / (before - after);
  return edge.parameters[0] + share * (edge.parameters[1] - edge.parameters[0]);
}

}  // namespace

bool SnapToCrossedEdge(MeshEdit& edit, const Star& star, Vec2 target) {
  const Mesh& mesh = edit.mesh();
  const VertexId center = star.center();
  const std::optional<std::size_t> crossed = CrossedTriangle(mesh, star, target);
  if (!crossed) return false;
  const VertexId a = star.ring()[*crossed];
  const VertexId b = star.ring_after(*crossed);
  const EdgeId edge_id = mesh.FindEdge(a, b);
  if (!edge_id.valid()) return false;
  const EdgeRecord& edge = mesh.edge(edge_id);
  if (edge.frozen) return false;
  const double t = CrossingParameter(mesh, edge, mesh.position(center), target);
  if (!(edge.parameters[0] < t && t < edge.parameters[1])) return false;
  const Vec2 point = mesh.PointOnSegment(edge.segment, t);

  // The triangle at the edge collapses; one behind an internal constraint is split in two.
  std::vector<TriangleId> cavity(star.triangles().begin(), star.triangles().end());
  std::vector<NewTriangle> triangles;
  for (std::size_t k = 0; k < star.triangles().size(); ++k) {
    if (k == *crossed) continue;
    triangles.push_back(
        {{center, star.ring()[k], star.ring_after(k)}, mesh.triangle(star.triangles()[k]).region});
  }
  const TriangleId at_edge = star.triangles()[*crossed];
  const TriangleId beyond =
      mesh.triangle(at_edge).neighbors[static_cast<std::size_t>(mesh.CornerOf(at_edge, center))];
  if (beyond.valid()) {
    const TriangleRecord& other = mesh.triangle(beyond);
    const VertexId far =
        other.vertices[static_cast<std::size_t>(mesh.SideTowards(beyond, at_edge))];
    cavity.push_back(beyond);
    triangles.push_back({{center, far, b}, other.region});
    triangles.push_back({{center, a, far}, other.region});
  }
  for (const NewTriangle& triangle : triangles) {
    if (Orient2d(point, mesh.position(triangle.vertices[1]), mesh.position(triangle.vertices[2])) <=
        0) {
      return false;
    }
  }
  edit.SplitConstrainedEdge(edge_id, center, t);
  edit.MoveVertex(center, point);
  edit.ReplaceCavity(cavity, triangles);
  return true;
}

}  // namespace pliant
