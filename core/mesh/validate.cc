#include "core/mesh/validate.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <sstream>

#include "core/geometry/predicates.h"

namespace pliant {
namespace {

constexpr std::size_t kFaultsMax = 20;

/// How far a vertex may lie off its segment, as a share of the segment's extent: the rounding of
/// a + t (b - a), and of imported boundaries that are straight only up to rounding.
constexpr double kOffSegmentMax = 1e-11;

class Validator {
 public:
  explicit Validator(const Mesh& mesh) : mesh_(mesh) {}

  std::vector<std::string> Run() {
    CheckVertices();
    for (std::int32_t t = 0; t < mesh_.triangle_slots(); ++t) CheckTriangle(TriangleId(t));
    for (std::int32_t e = 0; e < mesh_.edge_slots(); ++e) CheckEdge(EdgeId(e));
    CheckCounts();
    if (faults_.empty()) CheckFans();
    if (faults_.empty()) CheckSegments();
    return std::move(faults_);
  }

 private:
  template <class... Parts>
  void Fault(const Parts&... parts) {
    if (faults_.size() >= kFaultsMax) return;
    std::ostringstream text;
    text.precision(17);
    (text << ... << parts);
    faults_.push_back(text.str());
  }

  [[nodiscard]] bool LiveTriangle(TriangleId id) const {
    return id.valid() && id.value() < mesh_.triangle_slots() && mesh_.triangle(id).live;
  }
  [[nodiscard]] bool LiveEdge(EdgeId id) const {
    return id.valid() && id.value() < mesh_.edge_slots() && mesh_.edge(id).live;
  }

  void CheckVertices() {
    for (std::int32_t i = 0; i < mesh_.vertex_slots(); ++i) {
      const VertexRecord& vertex = mesh_.vertex(VertexId(i));
      if (!vertex.live) continue;
      ++vertex_count_;
      if (!IsFinite(vertex.position)) Fault("vertex ", i, " is not finite");
      if (!IsPositiveDefinite(vertex.metric)) Fault("metric of vertex ", i, " is not SPD");
      if (vertex.pinched && !vertex.fixed) Fault("vertex ", i, " is pinched but not fixed");
      if (!LiveTriangle(vertex.triangle)) {
        Fault("vertex ", i, " names dead triangle ", vertex.triangle);
        continue;
      }
      const auto& corners = mesh_.triangle(vertex.triangle).vertices;
      if (std::count(corners.begin(), corners.end(), VertexId(i)) != 1) {
        Fault("vertex ", i, " is no corner of its triangle ", vertex.triangle);
      }
      CheckEdgeList(VertexId(i));
    }
  }

  void CheckEdgeList(VertexId id) {
    std::int32_t steps = 0;
    for (EdgeId e = mesh_.vertex(id).edge; e.valid(); ++steps) {
      if (!LiveEdge(e) || steps > mesh_.edge_slots()) {
        Fault("edge list of vertex ", id, " is broken at edge ", e);
        lists_intact_ = false;
        return;
      }
      const auto& ends = mesh_.edge(e).vertices;
      if (ends[0] != id && ends[1] != id) {
        Fault("edge ", e, " in the list of vertex ", id, " does not have it");
        lists_intact_ = false;
        return;
      }
      ++listed_ends_;
      e = mesh_.edge(e).next[ends[0] == id ? 0 : 1];
    }
  }

  void CheckTriangle(TriangleId id) {
    const TriangleRecord& triangle = mesh_.triangle(id);
    if (!triangle.live) return;
    ++triangle_count_;
    const auto& v = triangle.vertices;
    for (const VertexId vertex : v) {
      if (!mesh_.IsLive(vertex)) {
        Fault("triangle ", id, " has dead vertex ", vertex);
        return;
      }
    }
    if (Orient2d(mesh_.position(v[0]), mesh_.position(v[1]), mesh_.position(v[2])) <= 0) {
      Fault("triangle ", id, " (", v[0], " ", v[1], " ", v[2], ") is not counter-clockwise");
    }
    for (int side = 0; side < 3; ++side) CheckSide(id, side);
  }

  void CheckSide(TriangleId id, int side) {
    const TriangleRecord& triangle = mesh_.triangle(id);
    const auto s = static_cast<std::size_t>(side);
    const VertexId a = triangle.vertices[static_cast<std::size_t>(NextCorner(side))];
    const VertexId b = triangle.vertices[static_cast<std::size_t>(PreviousCorner(side))];
    const bool constrained = triangle.IsConstrained(side);
    if (lists_intact_ && constrained != mesh_.FindEdge(a, b).valid()) {
      Fault("side ", side, " of triangle ", id, constrained ? " has no edge" : " hides an edge");
    }
    const TriangleId beyond = triangle.neighbors[s];
    if (!beyond.valid()) {
      if (!constrained) Fault("side ", side, " of triangle ", id, " has no neighbour, no edge");
      return;
    }
    if (!LiveTriangle(beyond)) {
      Fault("triangle ", id, " has dead neighbour ", beyond);
      return;
    }
    const TriangleRecord& other = mesh_.triangle(beyond);
    bool found = false;
    for (int k = 0; k < 3; ++k) {
      found |= other.neighbors[static_cast<std::size_t>(k)] == id &&
               other.vertices[static_cast<std::size_t>(NextCorner(k))] == b &&
               other.vertices[static_cast<std::size_t>(PreviousCorner(k))] == a;
    }
    if (!found) Fault("triangles ", id, " and ", beyond, " are not neighbours both ways");
  }

  void CheckEdge(EdgeId id) {
    const EdgeRecord& edge = mesh_.edge(id);
    if (!edge.live) return;
    ++edge_count_;
    if (!mesh_.IsLive(edge.vertices[0]) || !mesh_.IsLive(edge.vertices[1])) {
      Fault("edge ", id, " has a dead vertex");
      return;
    }
    if (!LiveTriangle(edge.triangle)) {
      Fault("edge ", id, " names dead triangle ", edge.triangle);
      return;
    }
    const auto& corners = mesh_.triangle(edge.triangle).vertices;
    for (const VertexId end : edge.vertices) {
      if (std::find(corners.begin(), corners.end(), end) == corners.end()) {
        Fault("edge ", id, " is no side of its triangle ", edge.triangle);
      }
    }
  }

  void CheckCounts() {
    if (vertex_count_ != mesh_.vertex_count()) Fault("vertex count is wrong");
    if (triangle_count_ != mesh_.triangle_count()) Fault("triangle count is wrong");
    if (edge_count_ != mesh_.edge_count()) Fault("edge count is wrong");
    if (listed_ends_ != 2 * std::int64_t{edge_count_}) Fault("edges are missing in vertex lists");
  }

  /// All triangles at a vertex form one fan, so that the star seen from it is all there is.
  void CheckFans() {
    std::vector<std::int32_t> counts(static_cast<std::size_t>(mesh_.vertex_slots()), 0);
    for (std::int32_t t = 0; t < mesh_.triangle_slots(); ++t) {
      const TriangleRecord& triangle = mesh_.triangle(TriangleId(t));
      if (!triangle.live) continue;
      for (const VertexId vertex : triangle.vertices) ++counts[vertex.index()];
    }
    for (std::int32_t i = 0; i < mesh_.vertex_slots(); ++i) {
      const VertexRecord& vertex = mesh_.vertex(VertexId(i));
      if (!vertex.live || vertex.pinched) continue;
      const TriangleId start = mesh_.FanStart(VertexId(i), vertex.triangle);
      std::int32_t count = 0;
      TriangleId current = start;
      do {
        ++count;
        const int corner = mesh_.CornerOf(current, VertexId(i));
        current = mesh_.triangle(current).neighbors[static_cast<std::size_t>(NextCorner(corner))];
      } while (current.valid() && current != start);
      if (count != counts[static_cast<std::size_t>(i)]) {
        Fault("vertex ", i, " has ", counts[static_cast<std::size_t>(i)],
              " triangles but a fan of ", count);
      }
    }
  }

  void CheckSegments() {
    std::vector<std::vector<EdgeId>> pieces(mesh_.segments().size());
    for (std::int32_t e = 0; e < mesh_.edge_slots(); ++e) {
      const EdgeRecord& edge = mesh_.edge(EdgeId(e));
      if (!edge.live) continue;
      if (edge.segment < 0 || static_cast<std::size_t>(edge.segment) >= pieces.size()) {
        Fault("edge ", e, " names no segment");
        return;
      }
      pieces[static_cast<std::size_t>(edge.segment)].push_back(EdgeId(e));
    }
    for (std::size_t s = 0; s < pieces.size(); ++s) CheckSegment(s, pieces[s]);
  }

  void CheckSegment(std::size_t s, std::vector<EdgeId>& pieces) {
    const SegmentRecord& record = mesh_.segments()[s];
    if (!record.is_line()) {
      if (!pieces.empty()) Fault("edge ", pieces.front(), " is on segment ", s, ", no line");
      if (!record.a.valid()) return;
      const bool given = mesh_.IsLive(record.a) && mesh_.vertex(record.a).fixed;
      if (!given) Fault("segment ", s, " names vertex ", record.a, ", no given point");
      return;
    }
    std::sort(pieces.begin(), pieces.end(), [this](EdgeId a, EdgeId b) {
      return mesh_.edge(a).parameters[0] < mesh_.edge(b).parameters[0];
    });
    VertexId end = mesh_.segments()[s].a;
    double t = 0;
    for (const EdgeId id : pieces) {
      const EdgeRecord& edge = mesh_.edge(id);
      if (edge.vertices[0] != end || edge.parameters[0] != t || !(edge.parameters[1] > t)) {
        Fault("segment ", s, " is interrupted before edge ", id);
        return;
      }
      end = edge.vertices[1];
      t = edge.parameters[1];
      CheckOnSegment(s, end, t);
    }
    if (end != mesh_.segments()[s].b || t != 1) Fault("segment ", s, " is not covered to its end");
  }

  void CheckOnSegment(std::size_t s, VertexId vertex, double t) {
    const Vec2 a = mesh_.position(mesh_.segments()[s].a);
    const Vec2 b = mesh_.position(mesh_.segments()[s].b);
    const Vec2 off = mesh_.position(vertex) - mesh_.PointOnSegment(static_cast<std::int32_t>(s), t);
    const double extent = Length(b - a) + Length(a);
    if (!(Length(off) <= kOffSegmentMax * extent)) {
      Fault("vertex ", vertex, " lies ", Length(off), " off segment ", s);
    }
  }

  const Mesh& mesh_;
  std::vector<std::string> faults_;
  std::int32_t vertex_count_ = 0;
  std::int32_t triangle_count_ = 0;
  std::int32_t edge_count_ = 0;
  std::int64_t listed_ends_ = 0;
  bool lists_intact_ = true;  // Else looking for an edge might not end.
};

}  // namespace

std::vector<std::string> Validate(const Mesh& mesh) { return Validator(mesh).Run(); }

double Area(const Mesh& mesh) {
  double area = 0;
  for (std::int32_t t = 0; t < mesh.triangle_slots(); ++t) {
    const TriangleRecord& triangle = mesh.triangle(TriangleId(t));
    if (!triangle.live) continue;
    const Vec2 a = mesh.position(triangle.vertices[0]);
    area += 0.5 *
            Cross(mesh.position(triangle.vertices[1]) - a, mesh.position(triangle.vertices[2]) - a);
  }
  return area;
}

}  // namespace pliant
