#include "core/mesh/mesh_diff.h"

#include <bit>
#include <cstddef>
#include <numeric>

#include "core/base/touch_pages.h"
#include "core/mesh/close_gaps.h"

namespace pliant {
namespace {

/// Kinds enter the hash, so that a vertex and a triangle in the same slot cannot cancel.
enum class ElementKind : std::uint64_t { kVertex = 1, kTriangle = 2, kEdge = 3 };

/// The finalizer of splitmix64: every input bit reaches every output bit. [Steele2014]
std::uint64_t Scramble(std::uint64_t x) {
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9;
  x = (x ^ (x >> 27)) * 0x94d049bb133111eb;
  return x ^ (x >> 31);
}

class Hasher {
 public:
  Hasher(ElementKind kind, std::int32_t slot)
      : state_(Scramble((static_cast<std::uint64_t>(kind) << 32) + Word(slot))) {}
  Hasher& Add(std::uint64_t word) {
    state_ = Scramble(state_ + 0x9e3779b97f4a7c15 + word);
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
  return Hasher(ElementKind::kVertex, id.value())
      .Add(std::bit_cast<std::uint64_t>(position.x))
      .Add(std::bit_cast<std::uint64_t>(position.y))
      .value();
}

std::uint64_t TriangleHash(TriangleId id, const std::array<VertexId, 3>& vertices,
                           std::int32_t region) {
  Hasher hasher(ElementKind::kTriangle, id.value());
  for (const VertexId vertex : vertices) hasher.Add(vertex.value());
  return hasher.Add(region).value();
}

std::uint64_t EdgeHash(EdgeId id, const std::array<VertexId, 2>& vertices, std::int32_t tag) {
  return Hasher(ElementKind::kEdge, id.value())
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

namespace {

/// Calls function(slot, place) for the live slots, place counting them from 0, and adds up what it
/// returns.
template <class IsLive, class Function>
std::uint64_t SumOverLive(std::int32_t slot_count, const IsLive& is_live,
                          const std::vector<std::size_t>& before, Executor& executor,
                          const Function& function) {
  const Chunks chunks(slot_count);
  std::vector<std::uint64_t> sums(static_cast<std::size_t>(chunks.count()), 0);
  executor.Run(chunks.count(), [&](std::int32_t chunk) {
    std::size_t place = before[static_cast<std::size_t>(chunk)];
    for (std::int64_t i = chunks.begin(chunk); i < chunks.end(chunk); ++i) {
      if (!is_live(static_cast<std::size_t>(i))) continue;
      sums[static_cast<std::size_t>(chunk)] += function(static_cast<std::int32_t>(i), place++);
    }
  });
  return std::accumulate(sums.begin(), sums.end(), std::uint64_t{0});
}

template <class Vector>
void ResizeTouched(Vector& vector, std::size_t count, Executor& executor) {
  ReserveTouched(vector, count, executor);
  vector.resize(count);
}

/// Writes the vertices to the diff. @return the sum of their hashes
std::uint64_t TakeVertices(const Mesh& mesh, MeshDiff& diff, Executor& executor) {
  const auto is_live = [&](std::size_t i) { return mesh.vertex(VertexId::FromIndex(i)).live; };
  const auto before = LiveBefore(mesh.vertex_slots(), is_live, executor);
  ResizeTouched(diff.vertex_ids, before.back(), executor);
  ResizeTouched(diff.vertex_positions, before.back(), executor);
  ResizeTouched(diff.metric_vertex_ids, before.back(), executor);
  ResizeTouched(diff.metrics, before.back(), executor);
  const auto take = [&](std::int32_t slot, std::size_t place) {
    const VertexId id(slot);
    const VertexRecord& vertex = mesh.vertex(id);
    diff.vertex_ids[place] = diff.metric_vertex_ids[place] = id;
    diff.vertex_positions[place] = vertex.position;
    diff.metrics[place] = vertex.metric;
    return VertexHash(id, vertex.position);
  };
  return SumOverLive(mesh.vertex_slots(), is_live, before, executor, take);
}

/// The same for triangles.
std::uint64_t TakeTriangles(const Mesh& mesh, MeshDiff& diff, Executor& executor) {
  const auto is_live = [&](std::size_t i) { return mesh.triangle(TriangleId::FromIndex(i)).live; };
  const auto before = LiveBefore(mesh.triangle_slots(), is_live, executor);
  ResizeTouched(diff.triangle_ids, before.back(), executor);
  ResizeTouched(diff.triangle_vertices, before.back(), executor);
  ResizeTouched(diff.triangle_regions, before.back(), executor);
  const auto take = [&](std::int32_t slot, std::size_t place) {
    const TriangleId id(slot);
    const TriangleRecord& triangle = mesh.triangle(id);
    diff.triangle_ids[place] = id;
    diff.triangle_vertices[place] = CanonicalTriangle(triangle.vertices);
    diff.triangle_regions[place] = triangle.region;
    return TriangleHash(id, diff.triangle_vertices[place], triangle.region);
  };
  return SumOverLive(mesh.triangle_slots(), is_live, before, executor, take);
}

}  // namespace

MeshDiff SnapshotOf(const Mesh& mesh, Revision revision) {
  InlineExecutor alone;
  return SnapshotOf(mesh, revision, alone);
}

MeshDiff SnapshotOf(const Mesh& mesh, Revision revision, Executor& executor) {
  MeshDiff diff;
  diff.revision = revision;
  MeshSummary& summary = diff.summary;
  summary.state_hash = TakeVertices(mesh, diff, executor) + TakeTriangles(mesh, diff, executor);
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
