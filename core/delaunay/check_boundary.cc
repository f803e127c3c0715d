#include "core/delaunay/check_boundary.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "core/delaunay/triangulate.h"

namespace pliant {
namespace {

/// A side of a triangle by its ends; sorted, the two triangles at an edge come together.
struct MeshSide {
  VertexId low;
  VertexId high;
  std::size_t triangle = 0;
  bool ascending = false;  ///< Runs from low to high with the triangle on its left.

  [[nodiscard]] auto Ends() const { return std::tuple(low, high); }
  [[nodiscard]] auto Key() const { return std::tuple(low, high, triangle); }
};

MeshSide MakeSide(VertexId from, VertexId to, std::size_t triangle) {
  return {std::min(from, to), std::max(from, to), triangle, from < to};
}

std::vector<MeshSide> SortedSides(std::span<const NewTriangle> triangles) {
  std::vector<MeshSide> sides;
  sides.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& v = triangles[t].vertices;
    for (std::size_t k = 0; k < 3; ++k) sides.push_back(MakeSide(v[k], v[(k + 1) % 3], t));
  }
  std::sort(sides.begin(), sides.end(),
            [](const MeshSide& a, const MeshSide& b) { return a.Key() < b.Key(); });
  return sides;
}

std::string EdgeText(VertexId a, VertexId b) {
  std::ostringstream text;
  text << '(' << a << ", " << b << ')';
  return text.str();
}

Status CheckManifold(std::span<const MeshSide> sides) {
  std::int64_t worst = INT64_MAX;
  const MeshSide* bad = nullptr;
  for (std::size_t i = 1; i < sides.size(); ++i) {
    if (sides[i].Ends() != sides[i - 1].Ends()) continue;
    const bool third = i >= 2 && sides[i].Ends() == sides[i - 2].Ends();
    if (!third && sides[i].ascending != sides[i - 1].ascending) continue;
    if (static_cast<std::int64_t>(sides[i].triangle) < worst) {
      worst = static_cast<std::int64_t>(sides[i].triangle);
      bad = &sides[i];
    }
  }
  if (bad == nullptr) return {};
  return Error{ErrorCode::kNonManifoldEdge,
               "triangle " + std::to_string(worst) + " claims side " +
                   EdgeText(bad->low, bad->high) +
                   " that other triangles already have; each edge may have one triangle on each "
                   "side",
               "mesh.triangles", worst};
}

/// First of the sides with these ends; sides.end() if there is none.
auto FindSide(std::span<const MeshSide> sides, VertexId a, VertexId b) {
  const MeshSide wanted = MakeSide(a, b, 0);
  const auto it =
      std::lower_bound(sides.begin(), sides.end(), wanted,
                       [](const MeshSide& x, const MeshSide& y) { return x.Ends() < y.Ends(); });
  return it != sides.end() && it->Ends() == wanted.Ends() ? it : sides.end();
}

bool HasTwin(std::span<const MeshSide> sides, std::size_t i) {
  return i + 1 < sides.size() && sides[i + 1].Ends() == sides[i].Ends();
}

/// The boundary as a domain of its own, with the mesh's number of each of its points.
struct Outline {
  Domain domain;
  std::vector<std::int32_t> original;

  /// The mesh's point nearest to what an error about the outline names.
  [[nodiscard]] std::int32_t PointOf(const Error& error) const {
    const auto at = static_cast<std::size_t>(std::max<std::int64_t>(error.index, 0));
    const bool segment = error.field == "domain.segments";
    return original[segment ? static_cast<std::size_t>(domain.segments[at].a) : at];
  }
};

Outline OutlineOf(std::span<const Vec2> points, std::span<const TaggedEdge> edges) {
  Outline outline;
  std::vector<std::int32_t> number(points.size(), -1);
  const auto add = [&](VertexId vertex) {
    std::int32_t& n = number[vertex.index()];
    if (n < 0) {
      n = static_cast<std::int32_t>(outline.original.size());
      outline.domain.points.push_back(points[vertex.index()]);
      outline.original.push_back(vertex.value());
    }
    return n;
  };
  for (const TaggedEdge& edge : edges) {
    if (!edge.boundary) continue;
    const std::int32_t a = add(edge.vertices[0]);
    const std::int32_t b = add(edge.vertices[1]);
    outline.domain.segments.push_back({a, b, 0});
  }
  return outline;
}

/// How the winding number of the domain's segments changes on the way out of a triangle.
int WindingStep(const Domain& domain, const DomainTriangulation::Triangle& triangle,
                std::size_t side) {
  const std::int32_t s = triangle.segments[side];
  if (s < 0) return 0;
  const bool left =
      triangle.points[(side + 1) % 3] == domain.segments[static_cast<std::size_t>(s)].a;
  return left ? -1 : 1;
}

/// Winding number of the domain's segments around each of its triangles.
std::vector<int> WindingNumbers(const Domain& domain, const DomainTriangulation& cdt) {
  constexpr int kUnknown = INT32_MIN;
  const auto& triangles = cdt.triangles;
  std::vector<int> winding(triangles.size(), kUnknown);
  std::vector<std::size_t> stack;
  for (std::size_t seed = 0; seed < triangles.size(); ++seed) {
    for (std::size_t side = 0; side < 3; ++side) {
      if (winding[seed] != kUnknown || triangles[seed].neighbors[side] >= 0) continue;
      winding[seed] = -WindingStep(domain, triangles[seed], side);
      stack.push_back(seed);
    }
    while (!stack.empty()) {
      const std::size_t t = stack.back();
      stack.pop_back();
      for (std::size_t side = 0; side < 3; ++side) {
        if (triangles[t].neighbors[side] < 0) continue;
        const auto next = static_cast<std::size_t>(triangles[t].neighbors[side]);
        if (winding[next] != kUnknown) continue;
        winding[next] = winding[t] + WindingStep(domain, triangles[t], side);
        stack.push_back(next);
      }
    }
  }
  return winding;
}

Error NotConforming(const std::string& why, std::int32_t point) {
  return {ErrorCode::kNotConforming,
          "the triangles do not fit together: " + why + ", near mesh.points[" +
              std::to_string(point) + "]",
          "mesh.points", point};
}

}  // namespace

Result<std::vector<TaggedEdge>> CollectEdges(const MeshData& mesh,
                                             std::span<const NewTriangle> triangles) {
  const std::vector<MeshSide> sides = SortedSides(triangles);
  PLIANT_RETURN_IF_ERROR(CheckManifold(sides));
  std::vector<TaggedEdge> edges;
  std::vector<bool> taken(sides.size(), false);
  const std::span<const MeshSide> view(sides);
  for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
    const VertexId a(mesh.edges[e][0]);
    const VertexId b(mesh.edges[e][1]);
    const auto index = static_cast<std::int64_t>(e);
    const auto side = FindSide(view, a, b);
    if (side == view.end()) {
      return Error{
          ErrorCode::kEdgeNotInMesh,
          "mesh.edges[" + std::to_string(e) + "] " + EdgeText(a, b) + " is no side of any triangle",
          "mesh.edges", index};
    }
    const auto at = static_cast<std::size_t>(side - view.begin());
    if (taken[at]) {
      return Error{ErrorCode::kDuplicateSegment,
                   "mesh.edges[" + std::to_string(e) + "] " + EdgeText(a, b) +
                       " is given twice; give every edge once",
                   "mesh.edges", index};
    }
    taken[at] = true;
    const bool boundary = !HasTwin(view, at);
    const std::int32_t tag = mesh.edge_tags.empty() ? 0 : mesh.edge_tags[e];
    // Keep the caller's direction, unless the only triangle lies to its right.
    const bool keep = !boundary || (a < b) == side->ascending;
    edges.push_back({keep ? std::array{a, b} : std::array{b, a}, tag, boundary});
  }
  for (std::size_t i = 0; i < sides.size(); ++i) {
    const bool first = i == 0 || sides[i - 1].Ends() != sides[i].Ends();
    if (!first || taken[i]) continue;
    const bool boundary = !HasTwin(view, i);
    if (!boundary &&
        triangles[sides[i].triangle].region == triangles[sides[i + 1].triangle].region) {
      continue;
    }
    const auto [low, high] = sides[i].Ends();
    edges.push_back(
        {sides[i].ascending ? std::array{low, high} : std::array{high, low}, 0, boundary});
  }
  return edges;
}

Status CheckBoundary(std::span<const Vec2> points, std::span<const TaggedEdge> edges) {
  const Outline outline = OutlineOf(points, edges);
  const Result<DomainTriangulation> cdt = TriangulateDomain(outline.domain);
  if (!cdt.ok()) {
    return NotConforming(
        "boundary edges cross, overlap or touch (does a vertex hang on an edge, "
        "or is it given twice?)",
        outline.PointOf(cdt.error()));
  }
  const std::vector<int> winding = WindingNumbers(outline.domain, *cdt);
  for (std::size_t t = 0; t < winding.size(); ++t) {
    if (winding[t] == 0 || winding[t] == 1) continue;
    const auto local = static_cast<std::size_t>(cdt->triangles[t].points[0]);
    return NotConforming("triangles overlap inside the boundary", outline.original[local]);
  }
  return {};
}

}  // namespace pliant
