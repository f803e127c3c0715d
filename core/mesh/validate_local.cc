#include "core/mesh/validate_local.h"

#include <atomic>
#include <cstddef>
#include <vector>

#include "core/base/check.h"
#include "core/base/sentence.h"
#include "core/geometry/predicates.h"
#include "core/mesh/star.h"

namespace pliant {
namespace {

// Sessions of one process count together.
std::atomic<std::int64_t> validated_operation_count{0};

bool IsLive(const Mesh& mesh, TriangleId id) {
  return id.valid() && id.value() < mesh.triangle_slots() && mesh.triangle(id).live;
}

std::string FaultOfCorner(const Mesh& mesh, TriangleId id, VertexId vertex) {
  const TriangleId named = mesh.vertex(vertex).triangle;
  if (!IsLive(mesh, named) || !mesh.triangle(named).HasCorner(vertex)) {
    return Sentence("corner ", vertex, " of triangle ", id, " names triangle ", named,
                    ", which does not have it");
  }
  if (!IsFinite(mesh.position(vertex))) return Sentence("vertex ", vertex, " is not finite");
  return {};
}

std::string FaultOfEdge(const Mesh& mesh, EdgeId id) {
  const EdgeRecord& edge = mesh.edge(id);
  if (!edge.live) return Sentence("edge ", id, " is dead");
  if (!IsLive(mesh, edge.triangle) || !mesh.triangle(edge.triangle).HasCorner(edge.vertices[0]) ||
      !mesh.triangle(edge.triangle).HasCorner(edge.vertices[1])) {
    return Sentence("edge ", id, " names triangle ", edge.triangle, ", which does not have it");
  }
  if (!(0 <= edge.parameters[0] && edge.parameters[0] < edge.parameters[1] &&
        edge.parameters[1] <= 1)) {
    return Sentence("edge ", id, " runs backwards on its segment");
  }
  return {};
}

std::string FaultOfSide(const Mesh& mesh, TriangleId id, int side) {
  const TriangleRecord& triangle = mesh.triangle(id);
  const VertexId a = triangle.vertices[static_cast<std::size_t>(NextCorner(side))];
  const VertexId b = triangle.vertices[static_cast<std::size_t>(PreviousCorner(side))];
  const bool constrained = triangle.IsConstrained(side);
  const EdgeId edge = mesh.FindEdge(a, b);
  if (constrained != edge.valid()) {
    return Sentence("side ", side, " of triangle ", id,
                    constrained ? " has no edge" : " hides an edge");
  }
  if (edge.valid()) {
    std::string fault = FaultOfEdge(mesh, edge);
    if (!fault.empty()) return fault;
  }
  const TriangleId beyond = triangle.neighbors[static_cast<std::size_t>(side)];
  if (!beyond.valid()) {
    return constrained ? "" : Sentence("side ", side, " of triangle ", id, " lies open");
  }
  if (!IsLive(mesh, beyond)) return Sentence("triangle ", id, " has dead neighbour ", beyond);
  const TriangleRecord& other = mesh.triangle(beyond);
  for (int k = 0; k < 3; ++k) {
    if (other.neighbors[static_cast<std::size_t>(k)] == id &&
        other.vertices[static_cast<std::size_t>(NextCorner(k))] == b &&
        other.vertices[static_cast<std::size_t>(PreviousCorner(k))] == a) {
      return {};
    }
  }
  return Sentence("triangles ", id, " and ", beyond, " are not neighbours both ways");
}

std::string FaultOfTriangle(const Mesh& mesh, TriangleId id) {
  if (!IsLive(mesh, id)) return Sentence("triangle ", id, " is dead");
  const auto& v = mesh.triangle(id).vertices;
  for (const VertexId vertex : v) {
    if (!mesh.IsLive(vertex)) return Sentence("triangle ", id, " has dead vertex ", vertex);
  }
  if (Orient2d(mesh.position(v[0]), mesh.position(v[1]), mesh.position(v[2])) <= 0) {
    return Sentence("triangle ", id, " (", v[0], " ", v[1], " ", v[2],
                    ") is not counter-clockwise");
  }
  for (const VertexId vertex : v) {
    std::string fault = FaultOfCorner(mesh, id, vertex);
    if (!fault.empty()) return fault;
  }
  for (int side = 0; side < 3; ++side) {
    std::string fault = FaultOfSide(mesh, id, side);
    if (!fault.empty()) return fault;
  }
  return {};
}

}  // namespace

std::string FaultAround(const Mesh& mesh, std::span<const TriangleId> triangles) {
  for (const TriangleId id : triangles) {
    std::string fault = FaultOfTriangle(mesh, id);
    if (!fault.empty()) return fault;
  }
  return {};
}

void CheckOperation(const Mesh& mesh, std::span<const TriangleId> triangles) {
  const std::string fault = FaultAround(mesh, triangles);
  PLIANT_CHECK(fault.empty(), "fault", fault);
  validated_operation_count.fetch_add(1, std::memory_order_relaxed);
}

void CheckOperation(const Mesh& mesh, VertexId vertex) {
  Star star;
  if (!mesh.vertex(vertex).pinched) {
    star.Gather(mesh, vertex);
    CheckOperation(mesh, star.triangles());
    return;
  }
  std::vector<TriangleId> all;
  for (const TriangleId fan : FansOf(mesh, vertex)) {
    star.Gather(mesh, vertex, fan);
    all.insert(all.end(), star.triangles().begin(), star.triangles().end());
  }
  CheckOperation(mesh, all);
}

std::int64_t ValidatedOperationCount() {
  return validated_operation_count.load(std::memory_order_relaxed);
}

}  // namespace pliant
