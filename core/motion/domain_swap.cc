#include "core/motion/domain_swap.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <string>
#include <tuple>

#include "core/base/as_index.h"
#include "core/base/sort_unique.h"
#include "core/delaunay/triangulate.h"
#include "core/geometry/box_tree.h"
#include "core/geometry/segments.h"
#include "core/mesh/segment_edges.h"

namespace pliant {
namespace {

using Kind = WallSide::Kind;

WallSide SideOf(const SideState& state) {
  return state ? WallSide{Kind::kRegion, *state} : WallSide{Kind::kOutside, 0};
}

/// The triangles left and right of a constrained edge, seen along it.
std::array<TriangleId, 2> TrianglesBeside(const Mesh& mesh, EdgeId id) {
  const EdgeRecord& edge = mesh.edge(id);
  const TriangleRecord& at = mesh.triangle(edge.triangle);
  for (std::size_t side = 0; side < 3; ++side) {
    const VertexId from = at.vertices[(side + 1) % 3];
    const VertexId to = at.vertices[(side + 2) % 3];
    if (from == edge.vertices[0] && to == edge.vertices[1]) {
      return {edge.triangle, at.neighbors[side]};
    }
    if (from == edge.vertices[1] && to == edge.vertices[0]) {
      return {at.neighbors[side], edge.triangle};
    }
  }
  PLIANT_CHECK(false, "edge", id, "triangle", edge.triangle);
  return {};
}

}  // namespace

Result<MeshChange::Outcome> DomainSwap::Apply(MeshEdit& edit) {
  const Mesh& mesh = edit.mesh();
  PLIANT_ASSIGN_OR_RETURN(inside_, TriangulateDomain(domain_));
  PLIANT_RETURN_IF_ERROR(GoOn());
  match_ = MatchDomain(mesh, domain_, inside_);
  PLIANT_RETURN_IF_ERROR(GoOn());
  ListPieces(mesh);
  cavity_ = GatherCavity(mesh, request_);
  PLIANT_RETURN_IF_ERROR(GoOn());
  PLIANT_RETURN_IF_ERROR(SettlePoints(edit));
  DrawWalls(mesh);
  PLIANT_RETURN_IF_ERROR(GoOn());
  const FillRequest fill = RequestFill(mesh);
  PLIANT_RETURN_IF_ERROR(GoOn());
  std::optional<Filling> filling = FillWalls(mesh, fill);
  if (!filling) return Unclear();
  PLIANT_RETURN_IF_ERROR(GoOn());
  PLIANT_RETURN_IF_ERROR(FloodBehind(mesh, *filling));
  PLIANT_RETURN_IF_ERROR(GoOn());
  ReplaceEdges(edit);
  KeepAlike(mesh, filling->triangles);
  PLIANT_RETURN_IF_ERROR(GoOn());
  PLIANT_RETURN_IF_ERROR(ReplaceTriangles(edit, filling->triangles));
  report_.vertex_of_point = match_.vertex_of_point;
  report_.kept_segment_count =
      std::ssize(match_.segments) - std::count_if(match_.segments.begin(), match_.segments.end(),
                                                  [](const NewSegment& s) { return s.old < 0; });
  report_.triangle_count = std::ssize(filling->triangles);
  return Finish(mesh, filling->triangles);
}

/// Whoever undoes a change that was refused undoes this one too, whatever it has come to.
Status DomainSwap::GoOn() const {
  if (stop_ != nullptr && stop_->asked()) return Stopped();
  return {};
}

/// Points of the domain that new segments join, directly or by way of others, have one group.
std::vector<std::int32_t> DomainSwap::GroupsOfPoints() const {
  std::vector<std::int32_t> group(domain_.points.size());
  std::iota(group.begin(), group.end(), 0);
  const auto root = [&](std::int32_t i) {
    while (group[AsIndex(i)] != i) {
      group[AsIndex(i)] = group[AsIndex(group[AsIndex(i)])];
      i = group[AsIndex(i)];
    }
    return i;
  };
  for (std::size_t i = 0; i < match_.segments.size(); ++i) {
    if (match_.segments[i].old >= 0) continue;
    group[AsIndex(root(domain_.segments[i].a))] = root(domain_.segments[i].b);
  }
  for (std::size_t i = 0; i < group.size(); ++i) group[i] = root(static_cast<std::int32_t>(i));
  return group;
}

void DomainSwap::ListPieces(const Mesh& mesh) {
  for (const EdgeId edge : match_.dropped) {
    for (const VertexId end : mesh.edge(edge).vertices) request_.stars.push_back(end);
  }
  const std::vector<std::int32_t> group = GroupsOfPoints();
  request_.anchored.assign(domain_.points.size(), false);
  std::set<std::pair<std::int32_t, std::size_t>> reused;
  for (const auto& [edge, at] : match_.reused) reused.emplace(at.segment, at.place);
  for (std::size_t i = 0; i < match_.segments.size(); ++i) {
    const std::vector<ChainVertex>& chain = match_.segments[i].chain;
    const Segment& segment = domain_.segments[i];
    for (std::size_t k = 0; k + 1 < chain.size(); ++k) {
      if (reused.contains({static_cast<std::int32_t>(i), k})) continue;
      DomainPiece piece{domain_.points[AsIndex(segment.a)], domain_.points[AsIndex(segment.b)],
                        group[AsIndex(segment.a)]};
      if (k > 0) piece.a = mesh.position(chain[k].vertex);
      if (k + 2 < chain.size()) piece.b = mesh.position(chain[k + 1].vertex);
      for (const VertexId end : {chain[k].vertex, chain[k + 1].vertex}) {
        if (!end.valid()) continue;
        request_.stars.push_back(end);
        request_.anchored[AsIndex(piece.group)] = true;
      }
      request_.pieces.push_back(piece);
      segment_of_piece_.push_back(i);
    }
  }
  std::vector<bool> loose(domain_.points.size(), true);
  for (const Segment& segment : domain_.segments) {
    loose[AsIndex(segment.a)] = loose[AsIndex(segment.b)] = false;
  }
  for (std::size_t i = 0; i < loose.size(); ++i) {
    if (!loose[i] || match_.vertex_of_point[i].valid()) continue;
    request_.pieces.push_back({domain_.points[i], domain_.points[i], group[i]});
  }
  SortUnique(request_.stars);
}

/// True if no constrained edge at a vertex stays.
bool DomainSwap::LosesAllEdges(const Mesh& mesh, VertexId vertex) const {
  bool loses = true;
  ForEachEdgeAt(mesh, vertex,
                [&](EdgeId edge) { loses = loses && !match_.SidesOf(mesh, edge).has_value(); });
  return loses;
}

std::vector<VertexId> DomainSwap::CornersOfCavity(const Mesh& mesh) const {
  std::vector<VertexId> corners;
  for (const TriangleId id : cavity_.triangles) {
    const auto& v = mesh.triangle(id).vertices;
    corners.insert(corners.end(), v.begin(), v.end());
  }
  SortUnique(corners);
  return corners;
}

/// Finds or makes the vertices of points that no given vertex stands for.
Status DomainSwap::SettlePoints(MeshEdit& edit) {
  const Mesh& mesh = edit.mesh();
  std::vector<std::tuple<double, double, VertexId>> corners;
  for (const VertexId vertex : CornersOfCavity(mesh)) {
    corners.emplace_back(mesh.position(vertex).x, mesh.position(vertex).y, vertex);
  }
  std::sort(corners.begin(), corners.end());
  std::vector<VertexId>& vertices = match_.vertex_of_point;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (vertices[i].valid()) continue;
    const Vec2 p = domain_.points[i];
    const auto at =
        std::lower_bound(corners.begin(), corners.end(), std::tuple(p.x, p.y, VertexId()));
    if (at == corners.end() || std::get<0>(*at) != p.x || std::get<1>(*at) != p.y) continue;
    if (!LosesAllEdges(mesh, std::get<2>(*at))) return Unclear();
    vertices[i] = std::get<2>(*at);
  }
  on_chains_.insert(vertices.begin(), vertices.end());
  for (const NewSegment& segment : match_.segments) {
    for (const ChainVertex& at : segment.chain) on_chains_.insert(at.vertex);
  }
  on_chains_.erase(VertexId());
  SplitChains(mesh);
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    if (!vertices[i].valid()) {
      vertices[i] = edit.AddVertex(domain_.points[i]);
      created_.push_back(vertices[i]);
      on_chains_.insert(vertices[i]);
    }
    // The bits that were sent, also of a zero.
    edit.PlaceVertex(vertices[i], domain_.points[i]);
  }
  for (std::size_t i = 0; i < match_.segments.size(); ++i) {
    std::vector<ChainVertex>& chain = match_.segments[i].chain;
    if (chain.empty()) continue;
    chain.front().vertex = vertices[AsIndex(domain_.segments[i].a)];
    chain.back().vertex = vertices[AsIndex(domain_.segments[i].b)];
  }
  return {};
}

/// Vertices that lie exactly on a new piece become vertices of its segment.
void DomainSwap::SplitChains(const Mesh& mesh) {
  std::vector<BoundingBox> boxes;
  for (std::size_t k = 0; k < segment_of_piece_.size(); ++k) {
    const DomainPiece& piece = request_.pieces[k];
    boxes.push_back(BoxOf(std::array{piece.a, piece.b}));
  }
  const BoxTree tree(boxes);
  std::map<std::size_t, std::vector<VertexId>> inside;  // By segment.
  for (const VertexId vertex : CornersOfCavity(mesh)) {
    if (on_chains_.contains(vertex) || !LosesAllEdges(mesh, vertex)) continue;
    const Vec2 p = mesh.position(vertex);
    tree.ForEachMeeting({p, p}, [&](std::int32_t k) {
      const DomainPiece& piece = request_.pieces[AsIndex(k)];
      if (!IsInsideSegment(piece.a, piece.b, p)) return true;
      inside[segment_of_piece_[AsIndex(k)]].push_back(vertex);
      return false;
    });
  }
  for (auto& [segment, vertices] : inside) InsertInChain(mesh, segment, std::move(vertices));
  SortUnique(expelled_);
}

void DomainSwap::InsertInChain(const Mesh& mesh, std::size_t segment,
                               std::vector<VertexId> inside) {
  const Vec2 a = domain_.points[AsIndex(domain_.segments[segment].a)];
  const Vec2 b = domain_.points[AsIndex(domain_.segments[segment].b)];
  const bool ascends = std::tie(a.x, a.y) < std::tie(b.x, b.y);
  const auto precedes = [&](VertexId v, VertexId w) {
    const Vec2 p = mesh.position(ascends ? v : w);
    const Vec2 q = mesh.position(ascends ? w : v);
    return std::tie(p.x, p.y) < std::tie(q.x, q.y);
  };
  std::sort(inside.begin(), inside.end(), precedes);
  std::vector<ChainVertex> chain;
  auto next = inside.begin();
  const std::vector<ChainVertex>& old = match_.segments[segment].chain;
  for (const ChainVertex& known : old) {
    for (; next != inside.end(); ++next) {
      const double t = Dot(mesh.position(*next) - a, b - a) / Dot(b - a, b - a);
      const bool is_last = &known == &old.back();
      const bool before = is_last || (known.vertex.valid() && precedes(*next, known.vertex));
      if (chain.empty() || !before) break;
      if (t > chain.back().t && t < known.t) {
        chain.push_back({*next, t});
        on_chains_.insert(*next);
      } else {
        expelled_.push_back(*next);
      }
    }
    chain.push_back(known);
  }
  match_.segments[segment].chain = std::move(chain);
}

void DomainSwap::DrawWalls(const Mesh& mesh) {
  DrawAroundCavity(mesh);
  DrawChains(mesh);
  for (const NewSegment& segment : match_.segments) {
    if (segment.old < 0) continue;
    std::vector<EdgeId> pieces;
    const SegmentRecord& line = mesh.segments()[AsIndex(segment.old)];
    const EdgeId first = EdgeFrom(mesh, segment.old, line.a);
    const EdgeSides sides = *match_.SidesOf(mesh, first);
    const auto [left, right] = TrianglesBeside(mesh, first);
    // Only where there is something to be made behind the edges are all of them needed.
    if ((sides.left && !left.valid()) || (sides.right && !right.valid())) {
      ForEachPiece(mesh, segment.old, [&](EdgeId edge) { pieces.push_back(edge); });
    }
    LookBehind(mesh, first, pieces);
  }
  for (const auto& [edge, at] : match_.reused) LookBehind(mesh, edge, std::array{edge});
}

/// Compares what lies beside an edge that stays with what the new domain has there. `alike` are the
/// edges that get walls if there is nothing yet.
void DomainSwap::LookBehind(const Mesh& mesh, EdgeId edge, std::span<const EdgeId> alike) {
  const EdgeSides sides = *match_.SidesOf(mesh, edge);
  const auto [left, right] = TrianglesBeside(mesh, edge);
  const auto look = [&](TriangleId id, const SideState& wanted) {
    if (id.valid() && !cavity_.Has(id)) behind_.emplace_back(id, wanted);
  };
  look(left, sides.left);
  look(right, sides.right);
  if ((sides.left && !left.valid()) || (sides.right && !right.valid())) {
    for (const EdgeId piece : alike) DrawKept(mesh, piece);
  }
}

/// Draws an edge that stays, with what the new domain has on its sides.
void DomainSwap::DrawKept(const Mesh& mesh, EdgeId edge) {
  const EdgeSides sides = *match_.SidesOf(mesh, edge);
  const auto [left, right] = TrianglesBeside(mesh, edge);
  const auto [a, b] = mesh.edge(edge).vertices;
  CavityWall drawn{{a, b, SideOf(sides.left), SideOf(sides.right)}, {}};
  if (left.valid() && !cavity_.Has(left)) {
    drawn.wall.left = {Kind::kCovered, 0};
    drawn.covered = left;
  }
  if (right.valid() && !cavity_.Has(right)) {
    drawn.wall.right = {Kind::kCovered, 0};
    drawn.covered = right;
  }
  walls_.emplace(std::minmax(a, b), drawn);
}

void DomainSwap::DrawAroundCavity(const Mesh& mesh) {
  for (const TriangleId id : cavity_.triangles) {
    const TriangleRecord& triangle = mesh.triangle(id);
    for (std::size_t side = 0; side < 3; ++side) {
      const VertexId a = triangle.vertices[(side + 1) % 3];
      const VertexId b = triangle.vertices[(side + 2) % 3];
      const TriangleId beyond = triangle.neighbors[side];
      if (triangle.IsConstrained(side)) {
        const EdgeId edge = mesh.FindEdge(a, b);
        if (match_.SidesOf(mesh, edge)) {
          DrawKept(mesh, edge);
          if (beyond.valid() && !cavity_.Has(beyond)) {
            LookBehind(mesh, edge, {});
          }
          continue;
        }
      }
      if (!beyond.valid() || cavity_.Has(beyond)) continue;
      walls_.emplace(std::minmax(a, b),
                     CavityWall{{a, b, {Kind::kCavity, 0}, {Kind::kCovered, 0}}, beyond});
    }
  }
}

/// Draws the new edges. One that runs along a frozen triangle has that on one side.
void DomainSwap::DrawChains(const Mesh& mesh) {
  for (const NewSegment& segment : match_.segments) {
    for (std::size_t k = 0; k + 1 < segment.chain.size(); ++k) {
      const VertexId a = segment.chain[k].vertex;
      const VertexId b = segment.chain[k + 1].vertex;
      const EdgeId edge = mesh.FindEdge(a, b);
      if (edge.valid() && match_.reused.contains(edge)) continue;
      CavityWall& drawn = walls_[std::minmax(a, b)];
      Wall wall{a, b, SideOf(segment.sides.left), SideOf(segment.sides.right)};
      if (drawn.covered.valid()) {
        const bool same = drawn.wall.from == a;
        const bool covers_left = (drawn.wall.left.kind == Kind::kCovered) == same;
        behind_.emplace_back(drawn.covered, covers_left ? segment.sides.left : segment.sides.right);
        (covers_left ? wall.left : wall.right) = {Kind::kCovered, 0};
      }
      drawn.wall = wall;
    }
  }
}

FillRequest DomainSwap::RequestFill(const Mesh& mesh) {
  FillRequest request;
  request.points = CornersOfCavity(mesh);
  std::erase_if(request.points, [&](VertexId vertex) {
    return std::binary_search(expelled_.begin(), expelled_.end(), vertex);
  });
  request.points.insert(request.points.end(), created_.begin(), created_.end());
  for (const auto& [ends, drawn] : walls_) {
    request.walls.push_back(drawn.wall);
    request.points.push_back(ends.first);
    request.points.push_back(ends.second);
  }
  SortUnique(request.points);
  request.state_at = [this, &mesh](VertexId vertex) { return StateAt(mesh, vertex); };
  return request;
}

StateAround DomainSwap::StateAt(const Mesh& mesh, VertexId vertex) {
  if (on_chains_.contains(vertex) || !LosesAllEdges(mesh, vertex)) return {};
  if (locator_ == nullptr) {
    std::vector<std::array<std::int32_t, 3>> triangles;
    for (const auto& triangle : inside_.triangles) triangles.push_back(triangle.points);
    locator_ = std::make_unique<TriangleLocator>(domain_.points, triangles);
  }
  const Location at = locator_->Locate(mesh.position(vertex), -1);
  if (!at.inside) return {.known = true, .state = {}};
  return {.known = true, .state = inside_.triangles[AsIndex(at.triangle)].region};
}

Error DomainSwap::Unclear() const {
  if (cavity_.met_frozen) {
    return {ErrorCode::kFrozen,
            "the new domain has segments where triangles are frozen: lift that constraint first, "
            "or send a domain that leaves them alone",
            "domain"};
  }
  return {ErrorCode::kCrossingSegments,
          "segments of the new domain come so close to each other, or to vertices on them, that "
          "rounding makes them cross; move them apart",
          "domain.segments"};
}

}  // namespace pliant
