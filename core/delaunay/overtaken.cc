#include "core/delaunay/overtaken.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/sort_unique.h"
#include "core/geometry/box_tree.h"
#include "core/geometry/domain.h"
#include "core/geometry/predicates.h"
#include "core/mesh/place_map.h"
#include "core/mesh/star.h"

namespace pliant {
namespace {

/// Many sides may be near the way of a vertex.
constexpr std::int64_t kLooksBetweenPolls = 256;

/// The way of an edge, or of a vertex.
struct Sweep {
  std::array<VertexId, 2> ends;  ///< Twice the same for a vertex.
  std::array<Vec2, 2> from;
  Vec2 by;
  bool yields = false;  ///< An end stands still and may be removed.
  BoundingBox box;

  /// True if a vertex goes through an edge, or the edge over it.
  [[nodiscard]] bool Passes(const Sweep& edge) const {
    if (ends[0] == edge.ends[0] || ends[0] == edge.ends[1]) return false;
    // As the edge sees it.
    const Vec2 p = from[0];
    const Vec2 q = p + (by - edge.by);
    const auto [a, b] = edge.from;
    return Orient2d(a, b, p) * Orient2d(a, b, q) <= 0 && Orient2d(p, q, a) * Orient2d(p, q, b) <= 0;
  }
};

Sweep SweepOf(const Mesh& mesh, const SuddenMove& move, std::array<VertexId, 2> ends) {
  Sweep sweep{.ends = ends,
              .from = {move.before(ends[0]), move.before(ends[1])},
              .by = {},
              .yields = false,
              .box = {}};
  const Vec2 to_a = mesh.position(ends[0]);
  const Vec2 to_b = mesh.position(ends[1]);
  sweep.by = 0.5 * ((to_a - sweep.from[0]) + (to_b - sweep.from[1]));
  sweep.yields = (to_a == sweep.from[0] && move.is_free(ends[0])) ||
                 (to_b == sweep.from[1] && move.is_free(ends[1]));
  sweep.box = {to_a, to_a};
  for (const Vec2 p : {to_b, sweep.from[0], sweep.from[1]}) {
    sweep.box.low = {std::min(sweep.box.low.x, p.x), std::min(sweep.box.low.y, p.y)};
    sweep.box.high = {std::max(sweep.box.high.x, p.x), std::max(sweep.box.high.y, p.y)};
  }
  return sweep;
}

void AddTrianglesAt(const Mesh& mesh, VertexId vertex, Star& star,
                    std::vector<TriangleId>& triangles) {
  for (const TriangleId fan : FansOf(mesh, vertex)) {
    star.Gather(mesh, vertex, fan);
    triangles.insert(triangles.end(), star.triangles().begin(), star.triangles().end());
  }
}

}  // namespace

std::vector<TriangleId> OvertakenCavity(const Mesh& mesh, std::vector<TriangleId> spoiled,
                                        const SuddenMove& move, Overtaking rule,
                                        const StopSignal* stop) {
  SortUnique(spoiled);
  std::vector<Sweep> sweeps;
  sweeps.reserve(2 * spoiled.size());
  std::vector<VertexId> waiting;
  for (const TriangleId id : spoiled) {
    const auto& v = mesh.triangle(id).vertices;
    waiting.insert(waiting.end(), v.begin(), v.end());
    for (std::size_t k = 0; k < 3; ++k) {
      const VertexId a = v[k];
      const VertexId b = v[(k + 1) % 3];
      // The other of two spoiled triangles has a side the other way round.
      const TriangleId beyond = mesh.triangle(id).neighbors[(k + 2) % 3];
      if (b < a && std::binary_search(spoiled.begin(), spoiled.end(), beyond)) continue;
      sweeps.push_back(SweepOf(mesh, move, {a, b}));
    }
  }
  std::vector<BoundingBox> boxes;
  boxes.reserve(sweeps.size());
  for (const Sweep& sweep : sweeps) boxes.push_back(sweep.box);
  const BoxTree tree(boxes);
  PlaceMap seen;
  Star star;
  std::vector<TriangleId> cavity = std::move(spoiled);
  std::int64_t looked_count = 0;
  while (!waiting.empty()) {
    const VertexId vertex = waiting.back();
    waiting.pop_back();
    if (!seen.Add(vertex, 0) || !move.is_free(vertex)) continue;
    if (looked_count++ % kLooksBetweenPolls == 0 && stop != nullptr && stop->asked()) break;
    const Sweep way = SweepOf(mesh, move, {vertex, vertex});
    bool passes = false;
    tree.ForEachMeeting(way.box, [&](std::int32_t index) {
      const Sweep& side = sweeps[static_cast<std::size_t>(index)];
      passes = (way.yields || !side.yields || rule == Overtaking::kAllGo) && way.Passes(side);
      return !passes;
    });
    if (!passes) continue;
    const std::size_t first = cavity.size();
    AddTrianglesAt(mesh, vertex, star, cavity);
    for (std::size_t i = first; i < cavity.size(); ++i) {
      const auto& v = mesh.triangle(cavity[i]).vertices;
      waiting.insert(waiting.end(), v.begin(), v.end());
    }
  }
  SortUnique(cavity);
  return cavity;
}

std::vector<TriangleId> WithRing(const Mesh& mesh, std::vector<TriangleId> cavity) {
  std::vector<VertexId> corners;
  for (const TriangleId id : cavity) {
    const auto& v = mesh.triangle(id).vertices;
    corners.insert(corners.end(), v.begin(), v.end());
  }
  SortUnique(corners);
  Star star;
  for (const VertexId vertex : corners) AddTrianglesAt(mesh, vertex, star, cavity);
  SortUnique(cavity);
  return cavity;
}

}  // namespace pliant
