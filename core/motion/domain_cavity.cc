#include "core/motion/domain_cavity.h"

#include <array>
#include <cmath>
#include <limits>

#include "core/geometry/box_tree.h"
#include "core/geometry/predicates.h"
#include "core/geometry/segments.h"
#include "core/geometry/triangle_point.h"
#include "core/mesh/star.h"

namespace pliant {
namespace {

using Corners = std::array<Vec2, 3>;

/// True if they have a point in common, ends included. @pre a != b
bool Touch(const DomainPiece& piece, Vec2 a, Vec2 b) {
  const auto on = [](Vec2 from, Vec2 to, Vec2 p) {
    return p == from || p == to || IsInsideSegment(from, to, p);
  };
  if (on(a, b, piece.a) || on(a, b, piece.b)) return true;
  if (piece.a == piece.b) return false;
  return on(piece.a, piece.b, a) || on(piece.a, piece.b, b) ||
         CrossOrOverlap(piece.a, piece.b, a, b);
}

bool Touch(const DomainPiece& piece, const Corners& corners) {
  if (Contains(corners, piece.a) || Contains(corners, piece.b)) return true;
  for (std::size_t i = 0; i < 3; ++i) {
    if (Touch(piece, corners[i], corners[(i + 1) % 3])) return true;
  }
  return false;
}

/// Finds triangles along pieces by going from neighbour to neighbour.
class Gatherer {
 public:
  Gatherer(const Mesh& mesh, std::span<const DomainPiece> pieces) : mesh_(mesh), pieces_(pieces) {
    std::vector<BoundingBox> boxes;
    for (const DomainPiece& piece : pieces) boxes.push_back(BoxOf(std::array{piece.a, piece.b}));
    tree_ = BoxTree(boxes);
  }

  /// Takes a triangle, whatever it touches.
  void Take(TriangleId id) {
    if (mesh_.triangle(id).frozen) {
      found_.met_frozen = true;
    } else if (found_.Add(id)) {
      stack_.push_back(id);
    }
  }

  void TakeStar(VertexId vertex) {
    for (const TriangleId fan : FansOf(mesh_, vertex)) {
      star_.Gather(mesh_, vertex, fan);
      for (const TriangleId id : star_.triangles()) Take(id);
    }
  }

  /// Takes triangles at a vertex that touch a piece.
  void TryStar(VertexId vertex) {
    for (const TriangleId fan : FansOf(mesh_, vertex)) {
      star_.Gather(mesh_, vertex, fan);
      for (const TriangleId id : star_.triangles()) Try(id);
    }
  }

  /// Takes triangles at constrained edges that touch a piece, and notes the pieces' groups.
  void TakeAtEdges(std::vector<bool>& anchored) {
    for (std::int32_t e = 0; e < mesh_.edge_slots(); ++e) {
      const EdgeRecord& edge = mesh_.edge(EdgeId(e));
      if (!edge.live) continue;
      const std::array ends{mesh_.position(edge.vertices[0]), mesh_.position(edge.vertices[1])};
      bool touches = false;
      tree_.ForEachMeeting(BoxOf(ends), [&](std::int32_t k) {
        const DomainPiece& piece = pieces_[static_cast<std::size_t>(k)];
        if (!Touch(piece, ends[0], ends[1])) return true;
        touches = true;
        anchored[static_cast<std::size_t>(piece.group)] = true;
        return true;
      });
      if (!touches) continue;
      Take(edge.triangle);
      for (const TriangleId neighbor : mesh_.triangle(edge.triangle).neighbors) {
        if (neighbor.valid()) Try(neighbor);
      }
    }
  }

  /// Goes on from what was taken.
  void Spread() {
    while (!stack_.empty()) {
      const TriangleId id = stack_.back();
      stack_.pop_back();
      for (const TriangleId neighbor : mesh_.triangle(id).neighbors) {
        if (neighbor.valid()) Try(neighbor);
      }
    }
  }

  TriangleSet Finish() { return std::move(found_); }

 private:
  void Try(TriangleId id) {
    if (found_.Has(id)) return;
    const auto& v = mesh_.triangle(id).vertices;
    const Corners corners{mesh_.position(v[0]), mesh_.position(v[1]), mesh_.position(v[2])};
    bool touches = false;
    tree_.ForEachMeeting(BoxOf(corners), [&](std::int32_t k) {
      touches = Touch(pieces_[static_cast<std::size_t>(k)], corners);
      return !touches;
    });
    if (touches) Take(id);
  }

  const Mesh& mesh_;
  std::span<const DomainPiece> pieces_;
  BoxTree tree_;
  TriangleSet found_;
  std::vector<TriangleId> stack_;
  Star star_;
};

/// The vertex on a constrained edge that is nearest to a point.
VertexId NearestOnEdges(const Mesh& mesh, Vec2 p) {
  VertexId nearest;
  double least = std::numeric_limits<double>::infinity();
  for (std::int32_t e = 0; e < mesh.edge_slots(); ++e) {
    const EdgeRecord& edge = mesh.edge(EdgeId(e));
    if (!edge.live) continue;
    const Vec2 way = mesh.position(edge.vertices[0]) - p;
    if (nearest.valid() && !(Dot(way, way) < least)) continue;
    nearest = edge.vertices[0];
    least = Dot(way, way);
  }
  return nearest;
}

/// The triangles around a point: none if it lies outside. Every way into the mesh leads across a
/// constrained edge, so that what the straight way to the point touches can all be found from them.
std::vector<TriangleId> TrianglesAt(const Mesh& mesh, Vec2 p) {
  const VertexId from = NearestOnEdges(mesh, p);
  const std::array way{DomainPiece{mesh.position(from), p}};
  Gatherer gatherer(mesh, way);
  gatherer.TryStar(from);
  std::vector<bool> anchored(1);
  gatherer.TakeAtEdges(anchored);
  gatherer.Spread();
  std::vector<TriangleId> around;
  for (const TriangleId id : gatherer.Finish().triangles) {
    const auto& v = mesh.triangle(id).vertices;
    if (Contains({mesh.position(v[0]), mesh.position(v[1]), mesh.position(v[2])}, p)) {
      around.push_back(id);
    }
  }
  return around;
}

}  // namespace

TriangleSet GatherCavity(const Mesh& mesh, const CavityRequest& request) {
  Gatherer gatherer(mesh, request.pieces);
  for (const VertexId vertex : request.stars) gatherer.TakeStar(vertex);
  std::vector<bool> anchored = request.anchored;
  if (!request.pieces.empty()) gatherer.TakeAtEdges(anchored);
  for (const DomainPiece& piece : request.pieces) {
    if (anchored[static_cast<std::size_t>(piece.group)]) continue;
    anchored[static_cast<std::size_t>(piece.group)] = true;
    for (const TriangleId id : TrianglesAt(mesh, piece.a)) gatherer.Take(id);
  }
  gatherer.Spread();
  return gatherer.Finish();
}

}  // namespace pliant
