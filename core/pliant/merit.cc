#include "core/pliant/merit.h"

#include <cstddef>

#include "core/mesh/segment_edges.h"

namespace pliant {
namespace {

/// The squared room at a given vertex, of the squared length of its shortest given edge: with 2
/// this edge has a merit of 1.18, and one of 0.92 of its length is just good enough.
constexpr double kRoomOfGiven = 2;
constexpr double kRoomOfCrowd = kRoomOfGiven * kSquaredShortest;
/// Less than this is a fifth of the wanted length to two fifths: a triangle on such an edge is good
/// only if its other corner is near, and rows grow coarser step by step.
constexpr double kRoomOfDense = kRoomOfGiven * 0.4 * 0.4;

/// Q that is good enough beside crowded vertices. Where two edges together are as long as the
/// wanted one, a corner at a good distance makes 0.73; more would draw the first row of nodes
/// nearer than that.
constexpr double kQualityOfCrowd = 0.75;
/// Asking for more than the 0.8 of other triangles lets a node come in earlier.
constexpr double kQualityOfDense = 0.82;

/// A mended node so near to crowded vertices may have edges of 0.65 times 0.5.
constexpr double kSquaredBeside = 0.85 * 0.85;
constexpr double kSquaredRoomBeside = 0.25;

double RoomOfGiven(const Mesh& mesh, VertexId vertex) {
  const VertexRecord& record = mesh.vertex(vertex);
  double room = 1;
  ForEachEdgeAt(mesh, vertex, [&](EdgeId id) {
    const EdgeRecord& edge = mesh.edge(id);
    const VertexRecord& far = mesh.vertex(edge.vertices[edge.vertices[0] == vertex ? 1 : 0]);
    if (far.fixed) room = std::min(room, kRoomOfGiven * SquaredEdgeLength(record, far));
  });
  return room;
}

bool IsBesideCrowd(const Mesh& mesh, VertexId node) {
  const VertexRecord& record = mesh.vertex(node);
  const auto is_near = [&](VertexId neighbor) {
    const VertexRecord& other = mesh.vertex(neighbor);
    return other.fixed && SquaredEdgeLength(record, other) < kSquaredBeside &&
           RoomOfGiven(mesh, neighbor) < kRoomOfCrowd;
  };
  // Without a Star: it is asked of many, and would be gathered for one look.
  const TriangleId first = mesh.FanStart(node, record.triangle);
  for (TriangleId id = first; id.valid();) {
    const TriangleRecord& triangle = mesh.triangle(id);
    const int corner = mesh.CornerOf(id, node);
    const auto next = static_cast<std::size_t>(NextCorner(corner));
    const auto previous = static_cast<std::size_t>(PreviousCorner(corner));
    if (is_near(triangle.vertices[next])) return true;
    id = triangle.neighbors[next];
    if (!id.valid()) return is_near(triangle.vertices[previous]);
    if (id == first) return false;
  }
  return false;
}

}  // namespace

MeritCorner CrowdedMeritCorner(const Mesh& mesh, VertexId vertex) {
  const VertexRecord& record = mesh.vertex(vertex);
  MeritCorner corner{record.position, record.metric};
  if (!record.fixed) {
    if (IsBesideCrowd(mesh, vertex)) corner.squared_room = kSquaredRoomBeside;
    return corner;
  }
  corner.squared_room = RoomOfGiven(mesh, vertex);
  if (IsCrowded(corner)) {
    corner.quality_wanted = corner.squared_room < kRoomOfDense ? kQualityOfDense : kQualityOfCrowd;
  }
  return corner;
}

bool IsMendedBesideCrowd(const Mesh& mesh, VertexId node) {
  const VertexRecord& record = mesh.vertex(node);
  return record.visit.mended && !record.fixed && IsBesideCrowd(mesh, node);
}

MeritCorner BornBesideCrowd(Vec2 place, const Metric& metric) {
  return {place, metric, kSquaredRoomBeside};
}

bool IsCrowded(const MeritCorner& corner) { return corner.squared_room < kRoomOfCrowd; }

}  // namespace pliant
