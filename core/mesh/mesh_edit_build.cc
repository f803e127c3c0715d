// MeshEdit, the part that sets a mesh up and renumbers it: runs once per session.

#include <algorithm>
#include <iterator>
#include <numeric>
#include <tuple>

#include "core/mesh/close_gaps.h"
#include "core/mesh/mesh_edit.h"

namespace pliant {
namespace {

/// One side of one triangle, by its ends in ascending order, for matching by sorting.
struct SortedSide {
  VertexId low;
  VertexId high;
  TriangleId triangle;
  std::size_t side = 0;

  [[nodiscard]] auto Key() const { return std::tuple(low, high, triangle, side); }
  [[nodiscard]] bool SameEdge(const SortedSide& other) const {
    return low == other.low && high == other.high;
  }
};

std::vector<SortedSide> SortSides(std::span<const NewTriangle> triangles) {
  std::vector<SortedSide> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& corners = triangles[t].vertices;
    for (std::size_t side = 0; side < 3; ++side) {
      const auto [low, high] = std::minmax(corners[(side + 1) % 3], corners[(side + 2) % 3]);
      sides.push_back({low, high, TriangleId::FromIndex(t), side});
    }
  }
  std::sort(sides.begin(), sides.end(),
            [](const SortedSide& a, const SortedSide& b) { return a.Key() < b.Key(); });
  return sides;
}

template <class IdType>
void Renumber(IdType& id, const std::vector<std::int32_t>& numbers) {
  if (id.valid()) id = IdType(numbers[id.index()]);
}

}  // namespace

void MeshEdit::Build(std::span<const Vec2> positions, std::span<const NewTriangle> triangles,
                     std::span<const NewEdge> edges, std::span<const SegmentRecord> segments) {
  PLIANT_CHECK(mesh_.vertices_.empty() && mesh_.triangles_.empty());
  mesh_.vertices_.resize(positions.size());
  mesh_.hints_.assign(positions.size(), -1);
  mesh_.triangles_.resize(triangles.size());
  mesh_.edges_.resize(edges.size());
  mesh_.segments_.assign(segments.begin(), segments.end());
  mesh_.vertex_allocator_.Reset(static_cast<std::int32_t>(positions.size()));
  mesh_.triangle_allocator_.Reset(static_cast<std::int32_t>(triangles.size()));
  mesh_.edge_allocator_.Reset(static_cast<std::int32_t>(edges.size()));

  for (std::size_t v = 0; v < positions.size(); ++v) {
    mesh_.vertices_[v].position = positions[v];
    mesh_.vertices_[v].live = true;
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    mesh_.triangles_[t].vertices = triangles[t].vertices;
    mesh_.triangles_[t].region = triangles[t].region;
    mesh_.triangles_[t].live = true;
    PointVerticesAt(TriangleId::FromIndex(t));
  }
  const std::vector<SortedSide> sides = SortSides(triangles);
  for (std::size_t i = 0; i + 1 < sides.size(); ++i) {
    const SortedSide& a = sides[i];
    const SortedSide& b = sides[i + 1];
    if (!a.SameEdge(b)) continue;
    mesh_.triangles_[a.triangle.index()].neighbors[a.side] = b.triangle;
    mesh_.triangles_[b.triangle.index()].neighbors[b.side] = a.triangle;
  }
  for (std::size_t e = 0; e < edges.size(); ++e) {
    EdgeRecord& record = mesh_.edges_[e];
    record.vertices = edges[e].vertices;
    record.parameters = edges[e].parameters;
    record.tag = edges[e].tag;
    record.segment = edges[e].segment;
    record.live = true;
    LinkEdge(EdgeId::FromIndex(e));
  }
  for (const SortedSide& side : sides) {
    const EdgeId edge = mesh_.FindEdge(side.low, side.high);
    if (!edge.valid()) continue;
    TriangleRecord& triangle = mesh_.triangles_[side.triangle.index()];
    triangle.constrained = static_cast<std::uint8_t>(triangle.constrained | (1U << side.side));
    mesh_.edges_[edge.index()].triangle = side.triangle;
  }
  MarkPinched();
}

void MeshEdit::MarkPinched() {
  std::vector<std::int32_t> triangle_counts(mesh_.vertices_.size(), 0);
  for (const TriangleRecord& triangle : mesh_.triangles_) {
    for (const VertexId vertex : triangle.vertices) ++triangle_counts[vertex.index()];
  }
  for (std::size_t v = 0; v < mesh_.vertices_.size(); ++v) {
    const VertexId vertex = VertexId::FromIndex(v);
    const TriangleId start = mesh_.FanStart(vertex, mesh_.vertices_[v].triangle);
    std::int32_t fan_count = 0;
    TriangleId current = start;
    do {
      ++fan_count;
      const int corner = mesh_.CornerOf(current, vertex);
      current = mesh_.triangle(current).neighbors[static_cast<std::size_t>(NextCorner(corner))];
    } while (current.valid() && current != start);
    mesh_.vertices_[v].pinched = fan_count != triangle_counts[v];
  }
}

std::vector<VertexId> MeshEdit::Compact() {
  InlineExecutor alone;
  return Compact(alone);
}

std::vector<VertexId> MeshEdit::Compact(Executor& executor) {
  PLIANT_CHECK(!logging());
  const std::vector<std::int32_t> vertices = DenseNumbers(mesh_.vertices_, executor);
  const std::vector<std::int32_t> triangles = DenseNumbers(mesh_.triangles_, executor);
  const std::vector<std::int32_t> edges = DenseNumbers(mesh_.edges_, executor);
  CloseGaps(mesh_.vertices_, vertices, executor);
  CloseGaps(mesh_.hints_, vertices, executor);
  CloseGaps(mesh_.triangles_, triangles, executor);
  CloseGaps(mesh_.edges_, edges, executor);
  Chunks(std::ssize(mesh_.vertices_)).ForEach(executor, [&](std::int32_t v) {
    VertexRecord& record = mesh_.vertices_[static_cast<std::size_t>(v)];
    Renumber(record.triangle, triangles);
    Renumber(record.edge, edges);
  });
  Chunks(std::ssize(mesh_.triangles_)).ForEach(executor, [&](std::int32_t t) {
    TriangleRecord& record = mesh_.triangles_[static_cast<std::size_t>(t)];
    for (VertexId& vertex : record.vertices) Renumber(vertex, vertices);
    for (TriangleId& neighbor : record.neighbors) Renumber(neighbor, triangles);
  });
  for (EdgeRecord& record : mesh_.edges_) {
    for (VertexId& vertex : record.vertices) Renumber(vertex, vertices);
    for (EdgeId& next : record.next) Renumber(next, edges);
    Renumber(record.triangle, triangles);
  }
  for (SegmentRecord& segment : mesh_.segments_) {
    Renumber(segment.a, vertices);
    Renumber(segment.b, vertices);
  }
  mesh_.vertex_allocator_.Reset(static_cast<std::int32_t>(mesh_.vertices_.size()));
  mesh_.triangle_allocator_.Reset(static_cast<std::int32_t>(mesh_.triangles_.size()));
  mesh_.edge_allocator_.Reset(static_cast<std::int32_t>(mesh_.edges_.size()));
  std::vector<VertexId> new_ids;
  new_ids.reserve(vertices.size());
  for (const std::int32_t number : vertices) new_ids.emplace_back(number);
  return new_ids;
}

}  // namespace pliant
