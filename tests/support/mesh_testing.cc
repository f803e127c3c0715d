#include "tests/support/mesh_testing.h"

#include <algorithm>
#include <sstream>

#include "core/base/check.h"
#include "core/delaunay/import_mesh.h"
#include "core/geometry/predicates.h"
#include "core/mesh/validate.h"
#include "core/pliant/remove.h"

namespace pliant::testing {
namespace {

std::unique_ptr<EditedMesh> Built(const Result<MeshPlan>& plan) {
  PLIANT_CHECK(plan.ok(), "error", plan.error().message);
  auto made = std::make_unique<EditedMesh>();
  BuildFromPlan(*plan, made->edit);
  return made;
}

bool Same(const VertexRecord& a, const VertexRecord& b) {
  return SameBits(a.position, b.position) && SameBits(a.metric, b.metric) &&
         a.triangle == b.triangle && a.edge == b.edge && a.visit == b.visit && a.live == b.live &&
         a.fixed == b.fixed && a.pinched == b.pinched && a.touched == b.touched &&
         a.committed == b.committed;
}

bool Same(const TriangleRecord& a, const TriangleRecord& b) {
  return a.vertices == b.vertices && a.neighbors == b.neighbors && a.region == b.region &&
         a.constrained == b.constrained && a.live == b.live && a.touched == b.touched &&
         a.committed == b.committed;
}

bool Same(const EdgeRecord& a, const EdgeRecord& b) {
  return a.vertices == b.vertices && SameBits(a.parameters[0], b.parameters[0]) &&
         SameBits(a.parameters[1], b.parameters[1]) && a.next == b.next &&
         a.triangle == b.triangle && a.tag == b.tag && a.segment == b.segment && a.live == b.live &&
         a.touched == b.touched && a.committed == b.committed;
}

template <class... Parts>
std::string Text(const Parts&... parts) {
  std::ostringstream text;
  (text << ... << parts);
  return text.str();
}

template <class IdType>
bool Ascending(const std::vector<IdType>& ids) {
  return std::adjacent_find(ids.begin(), ids.end(), std::greater_equal<>()) == ids.end();
}

template <class IdType>
bool Disjoint(const std::vector<IdType>& a, const std::vector<IdType>& b) {
  std::vector<IdType> common;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
  return common.empty();
}

/// Erases ids that must be there. @return the first that is not.
template <class Map, class IdType>
IdType EraseAll(Map& map, const std::vector<IdType>& ids) {
  for (const IdType id : ids) {
    if (map.erase(id) == 0) return id;
  }
  return IdType();
}

}  // namespace

std::unique_ptr<EditedMesh> ImportedMesh(const MeshData& data) { return Built(PlanImport(data)); }
std::unique_ptr<EditedMesh> DomainMesh(const Domain& domain) { return Built(PlanDomain(domain)); }

MeshData GridData(std::int32_t nx, std::int32_t ny) {
  MeshData data;
  for (std::int32_t y = 0; y <= ny; ++y) {
    for (std::int32_t x = 0; x <= nx; ++x) data.points.push_back({1.0 * x, 1.0 * y});
  }
  for (std::int32_t y = 0; y < ny; ++y) {
    for (std::int32_t x = 0; x < nx; ++x) {
      const std::int32_t a = y * (nx + 1) + x;
      const std::int32_t d = a + nx + 1;
      data.triangles.push_back({a, a + 1, d + 1});
      data.triangles.push_back({a, d + 1, d});
    }
  }
  return data;
}

std::string Faults(const Mesh& mesh) {
  std::string text;
  for (const std::string& fault : Validate(mesh)) text += fault + '\n';
  return text;
}

std::string DifferenceOf(const Mesh& a, const Mesh& b) {
  if (a.vertex_slots() != b.vertex_slots() || a.triangle_slots() != b.triangle_slots() ||
      a.edge_slots() != b.edge_slots()) {
    return "slot counts differ";
  }
  if (a.vertex_count() != b.vertex_count() || a.triangle_count() != b.triangle_count() ||
      a.edge_count() != b.edge_count()) {
    return "live counts differ";
  }
  for (std::int32_t i = 0; i < a.vertex_slots(); ++i) {
    if (!Same(a.vertex(VertexId(i)), b.vertex(VertexId(i)))) return Text("vertex ", i, " differs");
  }
  for (std::int32_t i = 0; i < a.triangle_slots(); ++i) {
    if (!Same(a.triangle(TriangleId(i)), b.triangle(TriangleId(i)))) {
      return Text("triangle ", i, " differs");
    }
  }
  for (std::int32_t i = 0; i < a.edge_slots(); ++i) {
    if (!Same(a.edge(EdgeId(i)), b.edge(EdgeId(i)))) return Text("edge ", i, " differs");
  }
  return {};
}

std::string Replica::Apply(const MeshDiff& diff) {
  if (diff.base_revision != revision_) return "the diff has another base";
  revision_ = diff.revision;
  if (!Ascending(diff.removed_vertices) || !Ascending(diff.removed_triangles) ||
      !Ascending(diff.removed_edges) || !Ascending(diff.vertex_ids) ||
      !Ascending(diff.triangle_ids) || !Ascending(diff.edge_ids) ||
      !Ascending(diff.metric_vertex_ids)) {
    return "a column of ids is not ascending";
  }
  if (!Disjoint(diff.removed_vertices, diff.vertex_ids) ||
      !Disjoint(diff.removed_triangles, diff.triangle_ids) ||
      !Disjoint(diff.removed_edges, diff.edge_ids)) {
    return "an id is both removed and written";
  }
  if (const VertexId id = EraseAll(vertices_, diff.removed_vertices); id.valid()) {
    return Text("vertex ", id, " is removed and was not there");
  }
  for (const VertexId id : diff.removed_vertices) metrics_.erase(id);
  if (const TriangleId id = EraseAll(triangles_, diff.removed_triangles); id.valid()) {
    return Text("triangle ", id, " is removed and was not there");
  }
  if (const EdgeId id = EraseAll(edges_, diff.removed_edges); id.valid()) {
    return Text("edge ", id, " is removed and was not there");
  }
  for (std::size_t i = 0; i < diff.vertex_ids.size(); ++i) {
    const auto [it, made] = vertices_.try_emplace(diff.vertex_ids[i], diff.vertex_positions[i]);
    if (!made && SameBits(it->second, diff.vertex_positions[i])) {
      return Text("vertex ", diff.vertex_ids[i], " ended as it began");
    }
    it->second = diff.vertex_positions[i];
  }
  for (std::size_t i = 0; i < diff.triangle_ids.size(); ++i) {
    const Triangle now{diff.triangle_vertices[i], diff.triangle_regions[i]};
    if (now.vertices[0] > now.vertices[1] || now.vertices[0] > now.vertices[2]) {
      return Text("triangle ", diff.triangle_ids[i], " is not canonical");
    }
    const auto [it, made] = triangles_.try_emplace(diff.triangle_ids[i], now);
    if (!made && it->second == now) {
      return Text("triangle ", diff.triangle_ids[i], " ended as it began");
    }
    it->second = now;
  }
  for (std::size_t i = 0; i < diff.edge_ids.size(); ++i) {
    const Edge now{diff.edge_vertices[i], diff.edge_tags[i]};
    const auto [it, made] = edges_.try_emplace(diff.edge_ids[i], now);
    if (!made && it->second == now) return Text("edge ", diff.edge_ids[i], " ended as it began");
    it->second = now;
  }
  for (std::size_t i = 0; i < diff.metric_vertex_ids.size(); ++i) {
    const auto [it, made] = metrics_.try_emplace(diff.metric_vertex_ids[i], diff.metrics[i]);
    if (!made && SameBits(it->second, diff.metrics[i])) {
      return Text("metric of vertex ", diff.metric_vertex_ids[i], " ended as it began");
    }
    it->second = diff.metrics[i];
  }
  if (!(Summary() == diff.summary)) return "counts or hash differ from the diff's summary";
  return {};
}

std::string Replica::DifferenceTo(const Mesh& mesh) const {
  const auto vertex_count = static_cast<std::size_t>(mesh.vertex_count());
  if (vertices_.size() != vertex_count || metrics_.size() != vertex_count ||
      triangles_.size() != static_cast<std::size_t>(mesh.triangle_count()) ||
      edges_.size() != static_cast<std::size_t>(mesh.edge_count())) {
    return "counts differ";
  }
  for (const auto& [id, position] : vertices_) {
    if (!mesh.IsLive(id) || !SameBits(position, mesh.position(id))) return Text("vertex ", id);
    if (!SameBits(metrics_.at(id), mesh.metric(id))) return Text("metric of vertex ", id);
  }
  for (const auto& [id, triangle] : triangles_) {
    const TriangleRecord& record = mesh.triangle(id);
    const Triangle now{CanonicalTriangle(record.vertices), record.region};
    if (!record.live || !(triangle == now)) return Text("triangle ", id);
  }
  for (const auto& [id, edge] : edges_) {
    const EdgeRecord& record = mesh.edge(id);
    if (!record.live || !(edge == Edge{record.vertices, record.tag})) return Text("edge ", id);
  }
  return {};
}

MeshSummary Replica::Summary() const {
  MeshSummary summary{static_cast<std::int32_t>(vertices_.size()),
                      static_cast<std::int32_t>(triangles_.size()),
                      static_cast<std::int32_t>(edges_.size()), 0};
  for (const auto& [id, position] : vertices_) summary.state_hash += VertexHash(id, position);
  for (const auto& [id, triangle] : triangles_) {
    summary.state_hash += TriangleHash(id, triangle.vertices, triangle.region);
  }
  for (const auto& [id, edge] : edges_) {
    summary.state_hash += EdgeHash(id, edge.vertices, edge.tag);
  }
  return summary;
}

std::vector<TriangleId> LiveTriangles(const Mesh& mesh) {
  std::vector<TriangleId> ids;
  for (std::int32_t t = 0; t < mesh.triangle_slots(); ++t) {
    if (mesh.triangle(TriangleId(t)).live) ids.emplace_back(t);
  }
  return ids;
}

std::map<std::int32_t, double> RegionAreas(const Mesh& mesh) {
  std::map<std::int32_t, double> areas;
  for (const TriangleId id : LiveTriangles(mesh)) {
    const auto& [a, b, c] = mesh.triangle(id).vertices;
    const Vec2 p = mesh.position(a);
    areas[mesh.triangle(id).region] += 0.5 * Cross(mesh.position(b) - p, mesh.position(c) - p);
  }
  return areas;
}

std::map<std::int32_t, double> TagLengths(const Mesh& mesh) {
  std::map<std::int32_t, double> lengths;
  for (std::int32_t e = 0; e < mesh.edge_slots(); ++e) {
    const EdgeRecord& edge = mesh.edge(EdgeId(e));
    if (!edge.live) continue;
    lengths[edge.tag] += Length(mesh.position(edge.vertices[1]) - mesh.position(edge.vertices[0]));
  }
  return lengths;
}

}  // namespace pliant::testing
