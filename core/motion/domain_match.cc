#include "core/motion/domain_match.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <tuple>
#include <utility>

#include "core/base/sort_unique.h"
#include "core/geometry/box_tree.h"
#include "core/mesh/segment_edges.h"

namespace pliant {
namespace {

/// A vertex of a segment that goes counts as on a new one if it is no further off than this share
/// of the coordinates: the rounding of points that were computed on a line.
constexpr double kOnSegment = 1e-12;

class Matcher {
 public:
  Matcher(const Mesh& mesh, const Domain& domain, const DomainTriangulation& inside)
      : mesh_(mesh), domain_(domain), inside_(inside) {}

  DomainMatch Run() {
    match_.segments.resize(domain_.segments.size());
    FindSides();
    FindGiven();
    MatchPoints();
    MatchSegments();
    // Vertices inside segments that go may be points of the new domain, too.
    for (const std::int32_t old : match_.gone) {
      if (LineAt(old).is_line()) {
        ForEachInside(mesh_, old, [&](VertexId vertex, double) { known_.push_back(vertex); });
      }
    }
    MatchPoints();
    BeginChains();
    AddRiders();
    SortEdges();
    return std::move(match_);
  }

 private:
  [[nodiscard]] const SegmentRecord& LineAt(std::int32_t segment) const {
    return mesh_.segments()[static_cast<std::size_t>(segment)];
  }
  [[nodiscard]] Vec2 Point(std::int32_t i) const {
    return domain_.points[static_cast<std::size_t>(i)];
  }

  void FindSides() {
    for (const DomainTriangulation::Triangle& triangle : inside_.triangles) {
      for (std::size_t side = 0; side < 3; ++side) {
        if (triangle.segments[side] < 0) continue;
        const auto i = static_cast<std::size_t>(triangle.segments[side]);
        // A counter-clockwise triangle lies on the left of its sides.
        const bool along = triangle.points[(side + 1) % 3] == domain_.segments[i].a;
        EdgeSides& sides = match_.segments[i].sides;
        (along ? sides.left : sides.right) = triangle.region;
      }
    }
  }

  void FindGiven() {
    for (const SegmentRecord& segment : mesh_.segments()) {
      for (const VertexId end : {segment.a, segment.b}) {
        if (end.valid()) known_.push_back(end);
      }
    }
    SortUnique(known_);
    given_ = known_;
  }

  void MatchPoints() {
    match_.vertex_of_point.assign(domain_.points.size(), VertexId());
    const auto precedes = [](Vec2 a, Vec2 b) { return std::tie(a.x, a.y) < std::tie(b.x, b.y); };
    std::vector<VertexId> sorted = known_;
    std::sort(sorted.begin(), sorted.end(), [&](VertexId a, VertexId b) {
      return precedes(mesh_.position(a), mesh_.position(b));
    });
    for (std::size_t i = 0; i < domain_.points.size(); ++i) {
      const Vec2 p = domain_.points[i];
      const auto at = std::lower_bound(
          sorted.begin(), sorted.end(), p,
          [&](VertexId vertex, Vec2 point) { return precedes(mesh_.position(vertex), point); });
      if (at != sorted.end() && mesh_.position(*at) == p) match_.vertex_of_point[i] = *at;
    }
  }

  void MatchSegments() {
    std::vector<std::tuple<VertexId, VertexId, std::int32_t>> lines;
    const auto count = static_cast<std::int32_t>(mesh_.segments().size());
    for (std::int32_t s = 0; s < count; ++s) {
      const auto [low, high] = std::minmax(LineAt(s).a, LineAt(s).b);
      if (LineAt(s).is_line()) lines.emplace_back(low, high, s);
    }
    std::sort(lines.begin(), lines.end());
    match_.new_of_old.assign(mesh_.segments().size(), -1);
    for (std::size_t i = 0; i < domain_.segments.size(); ++i) {
      const VertexId a = VertexOf(domain_.segments[i].a);
      const VertexId b = VertexOf(domain_.segments[i].b);
      if (!a.valid() || !b.valid()) continue;
      const auto [low, high] = std::minmax(a, b);
      const auto at = std::lower_bound(lines.begin(), lines.end(), std::tuple(low, high, -1));
      if (at == lines.end() || std::get<0>(*at) != low || std::get<1>(*at) != high) continue;
      const std::int32_t old = std::get<2>(*at);
      match_.segments[i].old = old;
      match_.segments[i].reversed = LineAt(old).a != a;
      match_.new_of_old[static_cast<std::size_t>(old)] = static_cast<std::int32_t>(i);
    }
    for (std::int32_t s = 0; s < count; ++s) {
      if (LineAt(s).a.valid() && !Stays(s)) match_.gone.push_back(s);
    }
  }

  [[nodiscard]] bool Stays(std::int32_t old) const {
    return match_.new_of_old[static_cast<std::size_t>(old)] >= 0;
  }

  [[nodiscard]] VertexId VertexOf(std::int32_t point) const {
    return match_.vertex_of_point[static_cast<std::size_t>(point)];
  }

  void BeginChains() {
    std::vector<VertexId> points = match_.vertex_of_point;
    std::sort(points.begin(), points.end());
    points_ = std::move(points);
    for (const VertexId vertex : given_) {
      if (!IsPoint(vertex)) match_.no_longer_given.push_back(vertex);
    }
    for (std::size_t i = 0; i < domain_.segments.size(); ++i) {
      if (match_.segments[i].old >= 0) continue;
      const Segment& segment = domain_.segments[i];
      match_.segments[i].chain = {{VertexOf(segment.a), 0}, {VertexOf(segment.b), 1}};
    }
  }

  [[nodiscard]] bool IsPoint(VertexId vertex) const {
    return std::binary_search(points_.begin(), points_.end(), vertex);
  }

  /// Vertices of segments that go, once each, in the order of the segments.
  [[nodiscard]] std::vector<VertexId> Candidates() const {
    std::vector<VertexId> candidates;
    const auto add = [&](VertexId vertex) {
      if (!IsPoint(vertex)) candidates.push_back(vertex);
    };
    for (const std::int32_t old : match_.gone) {
      const SegmentRecord& line = LineAt(old);
      if (!line.is_line()) continue;
      add(line.a);
      ForEachInside(mesh_, old, [&](VertexId vertex, double) { add(vertex); });
      add(line.b);
    }
    SortUnique(candidates);
    return candidates;
  }

  void AddRiders() {
    std::vector<BoundingBox> boxes;
    std::vector<std::size_t> fresh;
    for (std::size_t i = 0; i < match_.segments.size(); ++i) {
      if (match_.segments[i].old >= 0) continue;
      const Vec2 a = Point(domain_.segments[i].a);
      const Vec2 b = Point(domain_.segments[i].b);
      const double slack = SlackOf(a, b);
      const BoundingBox box = BoxOf(std::array{a, b});
      boxes.push_back({box.low - Vec2{slack, slack}, box.high + Vec2{slack, slack}});
      fresh.push_back(i);
    }
    const BoxTree tree(boxes);
    for (const VertexId vertex : Candidates()) {
      const Vec2 p = mesh_.position(vertex);
      std::size_t lowest = match_.segments.size();
      tree.ForEachMeeting({p, p}, [&](std::int32_t k) {
        const std::size_t i = fresh[static_cast<std::size_t>(k)];
        if (i < lowest && LiesOn(i, p)) lowest = i;
        return true;
      });
      if (lowest == match_.segments.size()) continue;
      match_.segments[lowest].chain.push_back({vertex, ParameterOn(lowest, p)});
    }
    for (const std::size_t i : fresh) OrderChain(match_.segments[i].chain);
  }

  static double SlackOf(Vec2 a, Vec2 b) { return kOnSegment * (Length(b - a) + Length(a)); }

  [[nodiscard]] double ParameterOn(std::size_t segment, Vec2 p) const {
    const Vec2 a = Point(domain_.segments[segment].a);
    const Vec2 along = Point(domain_.segments[segment].b) - a;
    return Dot(p - a, along) / Dot(along, along);
  }

  [[nodiscard]] bool LiesOn(std::size_t segment, Vec2 p) const {
    const Vec2 a = Point(domain_.segments[segment].a);
    const Vec2 b = Point(domain_.segments[segment].b);
    const double t = ParameterOn(segment, p);
    return t > 0 && t < 1 && Length(p - (a + t * (b - a))) <= SlackOf(a, b);
  }

  /// Sorts the vertices between the ends, and leaves out those that rounding cannot tell apart.
  static void OrderChain(std::vector<ChainVertex>& chain) {
    const auto precedes = [](const ChainVertex& a, const ChainVertex& b) { return a.t < b.t; };
    std::stable_sort(chain.begin(), chain.end(), precedes);
    const auto same = [](const ChainVertex& a, const ChainVertex& b) { return a.t == b.t; };
    chain.erase(std::unique(chain.begin(), chain.end(), same), chain.end());
  }

  void SortEdges() {
    for (std::size_t i = 0; i < match_.segments.size(); ++i) {
      const std::vector<ChainVertex>& chain = match_.segments[i].chain;
      for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
        const VertexId from = chain[k].vertex;
        const VertexId to = chain[k + 1].vertex;
        if (!from.valid() || !to.valid()) continue;
        const EdgeId edge = mesh_.FindEdge(from, to);
        if (!edge.valid() || Stays(mesh_.edge(edge).segment)) continue;
        match_.reused.emplace(edge, ReusedEdge{static_cast<std::int32_t>(i), k,
                                               mesh_.edge(edge).vertices[0] != from});
      }
    }
    for (const std::int32_t old : match_.gone) {
      if (!LineAt(old).is_line()) continue;
      ForEachPiece(mesh_, old, [&](EdgeId edge) {
        if (!match_.reused.contains(edge)) match_.dropped.push_back(edge);
      });
    }
  }

  const Mesh& mesh_;
  const Domain& domain_;
  const DomainTriangulation& inside_;
  std::vector<VertexId> known_;   // Vertices that can be points of the new domain.
  std::vector<VertexId> given_;   // Ascending.
  std::vector<VertexId> points_;  // Vertices that are points of the new domain, ascending.
  DomainMatch match_;
};

}  // namespace

std::optional<EdgeSides> DomainMatch::SidesOf(const Mesh& mesh, EdgeId edge) const {
  const auto of = [&](std::int32_t segment, bool reversed) {
    const EdgeSides& sides = segments[static_cast<std::size_t>(segment)].sides;
    return reversed ? sides.Reversed() : sides;
  };
  const std::int32_t stays = new_of_old[static_cast<std::size_t>(mesh.edge(edge).segment)];
  if (stays >= 0) return of(stays, segments[static_cast<std::size_t>(stays)].reversed);
  const auto found = reused.find(edge);
  if (found == reused.end()) return std::nullopt;
  return of(found->second.segment, found->second.reversed);
}

DomainMatch MatchDomain(const Mesh& mesh, const Domain& domain, const DomainTriangulation& inside) {
  return Matcher(mesh, domain, inside).Run();
}

}  // namespace pliant
