#include "core/pliant/insert.h"

#include "core/geometry/predicates.h"

namespace pliant {
namespace {

/// The side of the star's triangle that is the given spoke.
Side SideOfSpoke(const Mesh& mesh, const Star& star, std::size_t spoke) {
  // Spoke k is the side of triangle k opposite its far ring vertex; the last spoke of an open fan
  // belongs to the triangle before it.
  if (spoke < star.triangles().size()) {
    const TriangleId id = star.triangles()[spoke];
    return {id, mesh.CornerOf(id, star.ring_after(spoke))};
  }
  const TriangleId id = star.triangles()[spoke - 1];
  return {id, mesh.CornerOf(id, star.ring()[spoke - 1])};
}

/// True if splitting the side at `point` leaves positive triangles on this side of it.
bool SplitsOneWell(const Mesh& mesh, Side side, Vec2 point) {
  const auto& corners = mesh.triangle(side.triangle).vertices;
  const Vec2 apex = mesh.position(corners[static_cast<std::size_t>(side.corner)]);
  const Vec2 a = mesh.position(corners[static_cast<std::size_t>(NextCorner(side.corner))]);
  const Vec2 b = mesh.position(corners[static_cast<std::size_t>(PreviousCorner(side.corner))]);
  return Orient2d(apex, a, point) > 0 && Orient2d(apex, point, b) > 0;
}

}  // namespace

bool SplitsWell(const Mesh& mesh, Side side, Vec2 point) {
  if (!SplitsOneWell(mesh, side, point)) return false;
  const TriangleId beyond =
      mesh.triangle(side.triangle).neighbors[static_cast<std::size_t>(side.corner)];
  return !beyond.valid() ||
         SplitsOneWell(mesh, {beyond, mesh.SideTowards(beyond, side.triangle)}, point);
}

std::optional<Insertion> InsertOnSpoke(MeshEdit& edit, MetricFlipper& flipper,
                                       const MetricField& field, const Star& star,
                                       std::size_t spoke, AfterInsertion after) {
  const Mesh& mesh = edit.mesh();
  const VertexId end = star.ring()[spoke];
  const Side side = SideOfSpoke(mesh, star, spoke);
  Vec2 point = 0.5 * (mesh.position(star.center()) + mesh.position(end));
  double t = 0;
  const EdgeId constrained = mesh.FindEdge(star.center(), end);
  if (constrained.valid()) {
    const EdgeRecord& edge = mesh.edge(constrained);
    t = 0.5 * (edge.parameters[0] + edge.parameters[1]);
    if (!(edge.parameters[0] < t && t < edge.parameters[1])) return std::nullopt;
    point = mesh.PointOnSegment(edge.segment, t);
  }
  if (!SplitsWell(mesh, side, point)) return std::nullopt;
  std::int32_t hint = mesh.hint(star.center());
  const Metric metric = field.At(point, hint);
  Insertion insertion{edit.SplitEdge(side, point, t), 0};
  edit.SetMetric(insertion.vertex, metric);
  edit.Hint(insertion.vertex) = hint;
  if (after == AfterInsertion::kSwapEdges)
    insertion.swaps = flipper.AroundInserted(insertion.vertex);
  return insertion;
}

}  // namespace pliant
