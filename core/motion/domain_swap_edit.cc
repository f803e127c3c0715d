// DomainSwap, the part that changes the mesh.

#include <algorithm>
#include <array>
#include <string>

#include "core/base/as_index.h"
#include "core/mesh/id_bits.h"
#include "core/mesh/mesh_diff.h"
#include "core/mesh/segment_edges.h"
#include "core/motion/domain_swap.h"

namespace pliant {
namespace {

using Kind = WallSide::Kind;

void Append(const std::array<VertexId, 3>& corners, std::vector<VertexId>& to) {
  to.insert(to.end(), corners.begin(), corners.end());
}

}  // namespace

Status DomainSwap::FloodBehind(const Mesh& mesh, const Filling& filling) {
  std::size_t place = 0;
  for (const auto& [ends, drawn] : walls_) {
    const EdgeSides& states = filling.cavities[place++];
    const bool left = drawn.wall.left.kind == Kind::kCavity;
    const bool right = drawn.wall.right.kind == Kind::kCavity;
    if (left || right) behind_.emplace_back(drawn.covered, left ? states.left : states.right);
  }
  for (const auto& [triangle, wanted] : behind_) {
    PLIANT_RETURN_IF_ERROR(Flood(mesh, triangle, wanted));
  }
  return ListGoing(mesh);
}

/// The cavity, then what is flooded and will be outside, by slot.
Status DomainSwap::ListGoing(const Mesh& mesh) {
  StopPoll stopped(stop_);
  IdBits<TriangleId> outside(mesh.triangle_slots());
  for (std::size_t i = 0; i < flooded_as_.size(); ++i) {
    if (stopped()) return Stopped();
    if (!flooded_as_[i]) outside.Add(flooded_.triangles[i]);
  }
  going_ = cavity_.triangles;
  const std::vector<TriangleId> ascending = outside.Ascending();
  going_.insert(going_.end(), ascending.begin(), ascending.end());
  return {};
}

/// Notes what becomes of a triangle. @return true if that is new. Error: it is something else too
Result<bool> DomainSwap::Mark(TriangleId id, const SideState& wanted) {
  if (flooded_.Add(id)) {
    flooded_as_.push_back(wanted);
    return true;
  }
  const std::int32_t place = flooded_.places.Find(id.value());
  if (flooded_as_[AsIndex(place)] != wanted) return Unclear();
  return false;
}

/// Notes what becomes of a triangle and of all that can be reached from it without crossing an edge
/// that stays, or the cavity. Triangles that are what they should be are left alone.
Status DomainSwap::Flood(const Mesh& mesh, TriangleId start, const SideState& wanted) {
  if (wanted && mesh.triangle(start).region == *wanted) return {};
  PLIANT_ASSIGN_OR_RETURN(const bool is_new, Mark(start, wanted));
  if (!is_new) return {};
  std::vector<TriangleId> stack{start};
  StopPoll stopped(stop_);
  while (!stack.empty()) {
    if (stopped()) return Stopped();
    const TriangleRecord& triangle = mesh.triangle(stack.back());
    stack.pop_back();
    for (std::size_t side = 0; side < 3; ++side) {
      const TriangleId beyond = triangle.neighbors[side];
      if (!beyond.valid() || cavity_.Has(beyond)) continue;
      if (triangle.IsConstrained(side)) {
        const EdgeId edge =
            mesh.FindEdge(triangle.vertices[(side + 1) % 3], triangle.vertices[(side + 2) % 3]);
        if (match_.SidesOf(mesh, edge)) continue;
      }
      PLIANT_ASSIGN_OR_RETURN(const bool is_first, Mark(beyond, wanted));
      if (is_first) stack.push_back(beyond);
    }
  }
  return {};
}

/// Takes triangles that would come again as they were off both lists, so that they keep their
/// slots. Not those at edges that come or at edges of the boundary that go: their sides change.
void DomainSwap::KeepAlike(const Mesh& mesh, std::vector<NewTriangle>& triangles) {
  const auto changes = [&](const std::array<VertexId, 3>& v) {
    for (std::size_t side = 0; side < 3; ++side) {
      const VertexId a = v[(side + 1) % 3];
      const VertexId b = v[(side + 2) % 3];
      if (on_chains_.contains(a) && on_chains_.contains(b) && mesh.FindEdge(a, b).valid()) {
        return true;
      }
    }
    return false;
  };
  std::map<std::array<VertexId, 3>, TriangleId> old;
  for (const TriangleId id : cavity_.triangles) {
    const TriangleRecord& triangle = mesh.triangle(id);
    bool closed = true;
    for (std::size_t side = 0; side < 3; ++side) {
      const bool constrained = triangle.IsConstrained(side);
      closed = closed && (triangle.neighbors[side].valid() || constrained);
    }
    if (closed && !changes(triangle.vertices)) old[CanonicalTriangle(triangle.vertices)] = id;
  }
  std::set<TriangleId> stay;
  std::erase_if(triangles, [&](const NewTriangle& triangle) {
    const auto found = old.find(CanonicalTriangle(triangle.vertices));
    if (found == old.end() || mesh.triangle(found->second).region != triangle.region) return false;
    stay.insert(found->second);
    return true;
  });
  std::erase_if(going_, [&](TriangleId id) { return stay.contains(id); });
}

void DomainSwap::ReplaceEdges(MeshEdit& edit) {
  const Mesh& mesh = edit.mesh();
  for (const EdgeId edge : match_.dropped) edit.RemoveEdge(edge);
  std::vector<SegmentRecord> added;
  std::vector<bool> loose(domain_.points.size(), true);
  for (std::size_t i = 0; i < domain_.segments.size(); ++i) {
    const Segment& segment = domain_.segments[i];
    loose[AsIndex(segment.a)] = loose[AsIndex(segment.b)] = false;
    if (match_.segments[i].old >= 0) continue;
    added.push_back(
        {match_.vertex_of_point[AsIndex(segment.a)], match_.vertex_of_point[AsIndex(segment.b)]});
  }
  for (std::size_t i = 0; i < loose.size(); ++i) {
    if (loose[i]) added.push_back({match_.vertex_of_point[i], VertexId()});
  }
  const std::vector<std::int32_t> places = edit.ReplaceSegments(match_.gone, added);
  auto place = places.begin();
  for (std::size_t i = 0; i < domain_.segments.size(); ++i) {
    const std::int32_t tag = domain_.segments[i].tag;
    const NewSegment& segment = match_.segments[i];
    if (segment.old >= 0) {
      ForEachPiece(mesh, segment.old, [&](EdgeId id) {
        const EdgeRecord& edge = mesh.edge(id);
        if (edge.tag == tag) return;
        edit.SetEdge(id, {edge.vertices, edge.parameters, tag, edge.segment});
      });
      continue;
    }
    for (std::size_t k = 0; k + 1 < segment.chain.size(); ++k) {
      const ChainVertex& a = segment.chain[k];
      const ChainVertex& b = segment.chain[k + 1];
      const NewEdge now{{a.vertex, b.vertex}, {a.t, b.t}, tag, *place};
      const EdgeId known = mesh.FindEdge(a.vertex, b.vertex);
      known.valid() ? edit.SetEdge(known, now) : (void)edit.AddEdge(now);
    }
    ++place;
  }
  for (const VertexId vertex : match_.no_longer_given) edit.Unfix(vertex);
  for (const VertexId vertex : match_.vertex_of_point) edit.Fix(vertex);
}

Status DomainSwap::ReplaceTriangles(MeshEdit& edit, std::vector<NewTriangle> triangles) {
  const Mesh& mesh = edit.mesh();
  StopPoll stopped(stop_);
  for (std::size_t i = 0; i < flooded_as_.size(); ++i) {
    if (stopped()) return Stopped();
    if (flooded_as_[i]) edit.SetRegion(flooded_.triangles[i], *flooded_as_[i]);
  }
  IdBits<VertexId> corners(mesh.vertex_slots());
  for (const TriangleId id : going_) {
    if (stopped()) return Stopped();
    for (const VertexId vertex : mesh.triangle(id).vertices) corners.Add(vertex);
  }
  if (!edit.ReplaceRegion(going_, triangles, stop_)) return Stopped();
  return RemoveVertices(edit, corners.Ascending());
}

Status DomainSwap::RemoveVertices(MeshEdit& edit, std::span<const VertexId> corners) {
  const Mesh& mesh = edit.mesh();
  const auto is_used = [&](VertexId vertex) {
    const TriangleId named = mesh.vertex(vertex).triangle;
    if (!named.valid() || !mesh.triangle(named).live) return false;
    const auto& v = mesh.triangle(named).vertices;
    return std::find(v.begin(), v.end(), vertex) != v.end();
  };
  for (const VertexId vertex : match_.vertex_of_point) {
    if (!is_used(vertex)) return Unclear();
  }
  StopPoll stopped(stop_);
  for (const VertexId vertex : corners) {
    if (stopped()) return Stopped();
    if (is_used(vertex)) continue;
    if (mesh.vertex(vertex).edge.valid()) return Unclear();
    edit.RemoveVertex(vertex);
    ++report_.removed_vertex_count;
  }
  return {};
}

MeshChange::Outcome DomainSwap::Finish(const Mesh& mesh,
                                       std::span<const NewTriangle> triangles) const {
  Outcome outcome;
  outcome.created = created_;
  for (const NewTriangle& triangle : triangles) Append(triangle.vertices, outcome.disturbed);
  for (const VertexId vertex : match_.no_longer_given) {
    if (mesh.IsLive(vertex)) outcome.disturbed.push_back(vertex);
  }
  std::sort(outcome.disturbed.begin(), outcome.disturbed.end());
  outcome.disturbed.erase(std::unique(outcome.disturbed.begin(), outcome.disturbed.end()),
                          outcome.disturbed.end());
  return outcome;
}

}  // namespace pliant
