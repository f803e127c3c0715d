#include "core/mesh/mesh_diff.h"

#include <bit>

namespace pliant {
namespace {

/// Kinds enter the hash, so that a vertex and a triangle in the same slot cannot cancel.
enum class Kind : std::uint64_t { kVertex = 1, kTriangle = 2, kEdge = 3 };

/// The finalizer of splitmix64: every input bit reaches every output bit. [Steele2014]
std::uint64_t Mix(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
  x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
  return x ^ (x >> 31);
}

class Hasher {
 public:
  Hasher(Kind kind, std::int32_t slot)
      : state_(Mix((static_cast<std::uint64_t>(kind) << 32) + Word(slot))) {}
  Hasher& Add(std::uint64_t word) {
    state_ = Mix(state_ + 0x9e3779b97f4a7c15 + word);
    return *this;
  }
  Hasher& Add(std::int32_t value) { return Add(Word(value)); }
  [[nodiscard]] std::uint64_t value() const { return state_; }

 private:
  static std::uint64_t Word(std::int32_t value) { return static_cast<std::uint32_t>(value); }
  std::uint64_t state_;
};

}  // namespace

std::uint64_t VertexHash(VertexId id, Vec2 position) {
  return Hasher(Kind::kVertex, id.value())
      .Add(std::bit_cast<std::uint64_t>(position.x))
      .Add(std::bit_cast<std::uint64_t>(position.y))
      .value();
}

std::uint64_t TriangleHash(TriangleId id, const std::array<VertexId, 3>& vertices,
                           std::int32_t region) {
  Hasher hasher(Kind::kTriangle, id.value());
  for (const VertexId vertex : vertices) hasher.Add(vertex.value());
  return hasher.Add(region).value();
}

std::uint64_t EdgeHash(EdgeId id, const std::array<VertexId, 2>& vertices, std::int32_t tag) {
  return Hasher(Kind::kEdge, id.value())
      .Add(vertices[0].value())
      .Add(vertices[1].value())
      .Add(tag)
      .value();
}

std::array<VertexId, 3> CanonicalTriangle(const std::array<VertexId, 3>& v) {
  if (v[1] < v[0] && v[1] < v[2]) return {v[1], v[2], v[0]};
  if (v[2] < v[0] && v[2] < v[1]) return {v[2], v[0], v[1]};
  return v;
}

MeshDiff SnapshotOf(const Mesh& mesh, Revision revision) {
  MeshDiff diff;
  diff.revision = revision;
  MeshSummary& summary = diff.summary;
  for (std::int32_t i = 0; i < mesh.vertex_slots(); ++i) {
    const VertexRecord& vertex = mesh.vertex(VertexId(i));
    if (!vertex.live) continue;
    diff.vertex_ids.push_back(VertexId(i));
    diff.vertex_positions.push_back(vertex.position);
    diff.metric_vertex_ids.push_back(VertexId(i));
    diff.metrics.push_back(vertex.metric);
    summary.state_hash += VertexHash(VertexId(i), vertex.position);
  }
  for (std::int32_t i = 0; i < mesh.triangle_slots(); ++i) {
    const TriangleRecord& triangle = mesh.triangle(TriangleId(i));
    if (!triangle.live) continue;
    diff.triangle_ids.push_back(TriangleId(i));
    diff.triangle_vertices.push_back(CanonicalTriangle(triangle.vertices));
    diff.triangle_regions.push_back(triangle.region);
    summary.state_hash +=
        TriangleHash(TriangleId(i), diff.triangle_vertices.back(), triangle.region);
  }
  for (std::int32_t i = 0; i < mesh.edge_slots(); ++i) {
    const EdgeRecord& edge = mesh.edge(EdgeId(i));
    if (!edge.live) continue;
    diff.edge_ids.push_back(EdgeId(i));
    diff.edge_vertices.push_back(edge.vertices);
    diff.edge_tags.push_back(edge.tag);
    summary.state_hash += EdgeHash(EdgeId(i), edge.vertices, edge.tag);
  }
  summary.vertex_count = mesh.vertex_count();
  summary.triangle_count = mesh.triangle_count();
  summary.edge_count = mesh.edge_count();
  return diff;
}

}  // namespace pliant
