#include "core/delaunay/recover_segments.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace pliant {
namespace {

/// A vertex counts as on the line through a run's ends if it is no further off than this share of
/// the run's length and position: the rounding of coordinates that were computed on a line.
constexpr double kStraightTolerance = 1e-12;

/// A run of edges from one fixed vertex to the next: edges and the vertices between them.
struct Run {
  std::vector<std::size_t> edges;
  std::vector<VertexId> vertices;  ///< One more than edges.
};

class SegmentRecovery {
 public:
  SegmentRecovery(std::span<const TaggedEdge> edges, MeshPlan& plan)
      : edges_(edges), plan_(plan), at_vertex_(plan.positions.size()) {
    for (std::size_t e = 0; e < edges.size(); ++e) {
      for (const VertexId vertex : edges[e].vertices) at_vertex_[vertex.index()].push_back(e);
    }
  }

  void Recover() {
    plan_.edges.resize(edges_.size());
    std::vector<bool> done(edges_.size(), false);
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      if (done[e]) continue;
      const Run run = RunThrough(e);
      for (const std::size_t member : run.edges) done[member] = true;
      EmitStraight(run, 0, run.edges.size());
    }
    for (std::size_t v = 0; v < at_vertex_.size(); ++v) {
      if (at_vertex_[v].empty()) continue;
      if (!inner_[v]) plan_.fixed.push_back(VertexId::FromIndex(v));
    }
  }

 private:
  /// True if the run may go on through the vertex: its only two edges continue each other.
  [[nodiscard]] bool Passes(VertexId vertex) const {
    const auto& at = at_vertex_[vertex.index()];
    if (at.size() != 2) return false;
    const TaggedEdge& a = edges_[at[0]];
    const TaggedEdge& b = edges_[at[1]];
    if (a.tag != b.tag || a.boundary != b.boundary) return false;
    // The direction of a boundary says where the domain lies; that of a constraint says nothing.
    const bool opposed = a.vertices[1] == b.vertices[1] || a.vertices[0] == b.vertices[0];
    if (a.boundary && opposed) return false;
    const Vec2 p = plan_.positions[vertex.index()];
    const Vec2 u = p - plan_.positions[OtherEnd(at[0], vertex).index()];
    const Vec2 w = plan_.positions[OtherEnd(at[1], vertex).index()] - p;
    return Dot(u, w) > 0 && std::fabs(Cross(u, w)) <= kLooseAngle * Dot(u, w);
  }

  [[nodiscard]] VertexId OtherEnd(std::size_t e, VertexId vertex) const {
    const auto& ends = edges_[e].vertices;
    return ends[0] == vertex ? ends[1] : ends[0];
  }

  [[nodiscard]] std::size_t OtherEdge(VertexId vertex, std::size_t e) const {
    const auto& at = at_vertex_[vertex.index()];
    return at[0] == e ? at[1] : at[0];
  }

  /// The run through an edge in its direction, as far as it passes both ways.
  [[nodiscard]] Run RunThrough(std::size_t e) const {
    std::size_t first = e;
    VertexId start = edges_[e].vertices[0];
    while (Passes(start)) {
      const std::size_t before = OtherEdge(start, first);
      if (before == e) break;  // No straight run is closed, but rounding may not know.
      first = before;
      start = OtherEnd(first, start);
    }
    Run run;
    run.vertices.push_back(start);
    for (std::size_t current = first;;) {
      run.edges.push_back(current);
      const VertexId end = OtherEnd(current, run.vertices.back());
      run.vertices.push_back(end);
      if (!Passes(end) || end == start) return run;
      current = OtherEdge(end, current);
    }
  }

  /// Edges [begin, end) of a run as one segment if they are straight, else cut where they are
  /// furthest off.
  void EmitStraight(const Run& run, std::size_t begin, std::size_t end) {
    std::vector<std::array<std::size_t, 2>> parts{{begin, end}};
    while (!parts.empty()) {
      const auto [from, to] = parts.back();
      parts.pop_back();
      const std::size_t cut = FurthestOff(run, from, to);
      if (cut == to) {
        Emit(run, from, to);
      } else {
        parts.push_back({cut, to});
        parts.push_back({from, cut});
      }
    }
  }

  [[nodiscard]] double Parameter(Vec2 a, Vec2 b, Vec2 p) const {
    return Dot(p - a, b - a) / Dot(b - a, b - a);
  }

  /// The inner vertex of the part that keeps it from being one segment; `to` if there is none.
  [[nodiscard]] std::size_t FurthestOff(const Run& run, std::size_t from, std::size_t to) const {
    const Vec2 a = plan_.positions[run.vertices[from].index()];
    const Vec2 b = plan_.positions[run.vertices[to].index()];
    const double tolerance = kStraightTolerance * (Length(b - a) + Length(a));
    double worst = tolerance;
    std::size_t cut = to;
    double t_before = 0;
    for (std::size_t k = from + 1; k < to; ++k) {
      const Vec2 p = plan_.positions[run.vertices[k].index()];
      const double t = Parameter(a, b, p);
      const double off = Length(p - (a + t * (b - a)));
      const bool in_order = t > t_before && t < 1;
      t_before = t;
      if (off > worst || !in_order) {
        worst = off > worst ? off : worst;
        cut = k;
      }
    }
    return cut;
  }

  void Emit(const Run& run, std::size_t from, std::size_t to) {
    const auto segment = static_cast<std::int32_t>(plan_.segments.size());
    plan_.segments.push_back({run.vertices[from], run.vertices[to]});
    const Vec2 a = plan_.positions[run.vertices[from].index()];
    const Vec2 b = plan_.positions[run.vertices[to].index()];
    double t = 0;
    for (std::size_t k = from; k < to; ++k) {
      const VertexId end = run.vertices[k + 1];
      const double t_end = k + 1 == to ? 1 : Parameter(a, b, plan_.positions[end.index()]);
      const TaggedEdge& edge = edges_[run.edges[k]];
      plan_.edges[run.edges[k]] = {{run.vertices[k], end}, {t, t_end}, edge.tag, segment};
      if (k + 1 < to) inner_[end.index()] = true;
      t = t_end;
    }
  }

  /// Angle up to which two edges are tried as one run at all; FurthestOff decides.
  static constexpr double kLooseAngle = 1e-6;

  std::span<const TaggedEdge> edges_;
  MeshPlan& plan_;
  std::vector<std::vector<std::size_t>> at_vertex_;
  std::vector<bool> inner_ = std::vector<bool>(plan_.positions.size(), false);
};

}  // namespace

void RecoverSegments(std::span<const TaggedEdge> edges, MeshPlan& plan) {
  SegmentRecovery(edges, plan).Recover();
}

}  // namespace pliant
