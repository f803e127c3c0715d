// MeshEdit, the part that halves many edges at once: only before the first commit.

#include <array>
#include <cstddef>
#include <utility>
#include <vector>

#include "core/mesh/mesh_edit.h"

namespace pliant {
namespace {

/// What a triangle becomes: up to four, counter-clockwise.
struct Children {
  std::array<std::array<VertexId, 3>, 4> triangles;
  int count = 0;

  void Add(VertexId a, VertexId b, VertexId c) {
    triangles[static_cast<std::size_t>(count++)] = {a, b, c};
  }
};

/// Squared length of the diagonal between two vertices in the mean metric of a triangle's corners;
/// new vertices have none yet.
double SquaredDiagonal(const Mesh& mesh, const TriangleRecord& parent, VertexId from, VertexId to) {
  const auto& v = parent.vertices;
  const Metric sum = mesh.metric(v[0]) + mesh.metric(v[1]) + mesh.metric(v[2]);
  return SquaredLength(sum, mesh.position(to) - mesh.position(from));
}

/// Template for a parent with middles on some sides (middles[i] on the side opposite corner i).
Children ChildrenOf(const Mesh& mesh, const TriangleRecord& parent,
                    const std::array<VertexId, 3>& middles) {
  const auto& v = parent.vertices;
  const int split_count = static_cast<int>(middles[0].valid()) +
                          static_cast<int>(middles[1].valid()) +
                          static_cast<int>(middles[2].valid());
  Children children;
  if (split_count == 0) {
    children.Add(v[0], v[1], v[2]);
    return children;
  }
  if (split_count == 3) {
    children.Add(v[0], middles[2], middles[1]);
    children.Add(middles[2], v[1], middles[0]);
    children.Add(middles[1], middles[0], v[2]);
    children.Add(middles[0], middles[1], middles[2]);
    return children;
  }
  // The odd side out: the only split one, or the only whole one.
  std::size_t i = 0;
  while (middles[i].valid() != (split_count == 1)) ++i;
  const std::size_t j = (i + 1) % 3;
  const std::size_t k = (i + 2) % 3;
  if (split_count == 1) {
    children.Add(v[i], v[j], middles[i]);
    children.Add(v[i], middles[i], v[k]);
    return children;
  }
  children.Add(v[i], middles[k], middles[j]);
  if (SquaredDiagonal(mesh, parent, middles[k], v[k]) <=
      SquaredDiagonal(mesh, parent, v[j], middles[j])) {
    children.Add(middles[k], v[j], v[k]);
    children.Add(middles[k], v[k], middles[j]);
  } else {
    children.Add(middles[k], v[j], middles[j]);
    children.Add(v[j], v[k], middles[j]);
  }
  return children;
}

/// A side of a child.
struct ChildSide {
  TriangleId triangle;
  std::size_t side = 0;
};

/// The children's sides along a parent's side: the one at its first end (counter-clockwise), and
/// the one at its second end if it is split.
using Pieces = std::array<std::array<ChildSide, 2>, 3>;

/// The parent's side along which the child's side from -> to lies; 3 for a side between children.
std::size_t ParentSide(const TriangleRecord& parent, const std::array<VertexId, 3>& middles,
                       VertexId from, VertexId to) {
  for (std::size_t s = 0; s < 3; ++s) {
    const VertexId a = parent.vertices[(s + 1) % 3];
    const VertexId b = parent.vertices[(s + 2) % 3];
    const VertexId m = middles[s];
    if (from == a && (to == b || to == m)) return s;
    if (m.valid() && from == m && to == b) return s;
  }
  return 3;
}

/// The child in records[first..] that has the side to -> from.
TriangleId ChildBehind(const std::vector<TriangleRecord>& records, std::size_t first, VertexId from,
                       VertexId to) {
  for (std::size_t c = first; c < records.size(); ++c) {
    const auto& v = records[c].vertices;
    for (std::size_t k = 0; k < 3; ++k) {
      if (v[(k + 1) % 3] == to && v[(k + 2) % 3] == from) return TriangleId::FromIndex(c);
    }
  }
  return TriangleId();
}

/// Appends a parent's children, linked among each other. @return their sides along the parent's
Pieces AppendChildren(const TriangleRecord& parent, const std::array<VertexId, 3>& middles,
                      const Children& children, std::vector<TriangleRecord>& records) {
  Pieces pieces;
  const std::size_t first = records.size();
  for (int c = 0; c < children.count; ++c) {
    TriangleRecord& child = records.emplace_back();
    child.vertices = children.triangles[static_cast<std::size_t>(c)];
    child.region = parent.region;
    child.live = true;
  }
  for (std::size_t c = first; c < records.size(); ++c) {
    TriangleRecord& child = records[c];
    for (std::size_t side = 0; side < 3; ++side) {
      const VertexId from = child.vertices[(side + 1) % 3];
      const VertexId to = child.vertices[(side + 2) % 3];
      const std::size_t s = ParentSide(parent, middles, from, to);
      if (s == 3) {
        child.neighbors[side] = ChildBehind(records, first, from, to);
        continue;
      }
      pieces[s][from == parent.vertices[(s + 1) % 3] ? 0 : 1] = {TriangleId::FromIndex(c), side};
      if (((parent.constrained >> s) & 1) != 0) {
        child.constrained = static_cast<std::uint8_t>(child.constrained | (1U << side));
      }
    }
  }
  return pieces;
}

/// Links children across the sides of their parents.
void LinkAcross(const std::vector<TriangleRecord>& parents,
                const std::vector<std::array<VertexId, 3>>& middles,
                const std::vector<Pieces>& pieces, std::vector<TriangleRecord>& records) {
  for (std::size_t t = 0; t < parents.size(); ++t) {
    for (std::size_t s = 0; s < 3; ++s) {
      const TriangleId beyond = parents[t].neighbors[s];
      if (!beyond.valid()) continue;
      const auto& back = parents[beyond.index()].neighbors;
      std::size_t r = 0;
      while (back[r] != TriangleId::FromIndex(t)) ++r;
      const std::size_t last = middles[t][s].valid() ? 1 : 0;
      for (std::size_t half = 0; half <= last; ++half) {
        const ChildSide own = pieces[t][s][half];
        records[own.triangle.index()].neighbors[own.side] =
            pieces[beyond.index()][r][last - half].triangle;
      }
    }
  }
}

}  // namespace

void MeshEdit::Refine(std::span<const EdgeSplit> splits) {
  PLIANT_CHECK(!logging());
  std::vector<std::array<VertexId, 3>> middles(mesh_.triangles_.size());
  for (const EdgeSplit& split : splits) {
    const VertexId m = TakeVertex();
    mesh_.vertices_[m.index()].position = split.position;
    const TriangleRecord& triangle = mesh_.triangle(split.side.triangle);
    const auto corner = static_cast<std::size_t>(split.side.corner);
    middles[split.side.triangle.index()][corner] = m;
    if (const TriangleId beyond = triangle.neighbors[corner]; beyond.valid()) {
      const int back = mesh_.SideTowards(beyond, split.side.triangle);
      middles[beyond.index()][static_cast<std::size_t>(back)] = m;
    }
    if (((triangle.constrained >> split.side.corner) & 1) != 0) {
      SplitConstrainedEdge(
          mesh_.FindEdge(triangle.vertices[(corner + 1) % 3], triangle.vertices[(corner + 2) % 3]),
          m, split.t);
    }
  }

  std::vector<TriangleRecord> parents;
  parents.swap(mesh_.triangles_);
  mesh_.triangles_.reserve(4 * parents.size());
  std::vector<Pieces> pieces;
  pieces.reserve(parents.size());
  for (std::size_t t = 0; t < parents.size(); ++t) {
    pieces.push_back(AppendChildren(parents[t], middles[t],
                                    ChildrenOf(mesh_, parents[t], middles[t]), mesh_.triangles_));
  }
  LinkAcross(parents, middles, pieces, mesh_.triangles_);
  mesh_.triangle_allocator_.Reset(static_cast<std::int32_t>(mesh_.triangles_.size()));
  for (std::size_t t = 0; t < mesh_.triangles_.size(); ++t) {
    PointVerticesAt(TriangleId::FromIndex(t));
    if (mesh_.triangles_[t].constrained != 0) PointEdgesAt(TriangleId::FromIndex(t));
  }
}

}  // namespace pliant
