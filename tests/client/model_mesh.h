#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <iterator>
#include <map>
#include <random>
#include <utility>

#include "client/cpp/mesh_replica.h"
#include "core/mesh/mesh_diff.h"

namespace pliant::client {

/// A mesh as the simplest thing that can hold one: maps from slot to contents. Not a triangulation:
/// a replica does not care, and so every combination of changes can be drawn at random.
struct ModelMesh {
  std::map<VertexId, Vec2> vertices;
  std::map<TriangleId, std::pair<std::array<VertexId, 3>, std::int32_t>> triangles;
  std::map<EdgeId, std::pair<std::array<VertexId, 2>, std::int32_t>> edges;
  Revision revision = Revision::kNone;

  [[nodiscard]] MeshSummary Summary() const {
    MeshSummary summary{.vertex_count = static_cast<std::int32_t>(vertices.size()),
                        .triangle_count = static_cast<std::int32_t>(triangles.size()),
                        .edge_count = static_cast<std::int32_t>(edges.size())};
    for (const auto& [id, row] : vertices) summary.state_hash += VertexHash(id, row);
    for (const auto& [id, row] : triangles) {
      summary.state_hash += TriangleHash(id, row.first, row.second);
    }
    for (const auto& [id, row] : edges) summary.state_hash += EdgeHash(id, row.first, row.second);
    return summary;
  }
};

/// What leads from one model to another, found by comparing everything.
inline MeshDiff DiffOf(const ModelMesh& from, const ModelMesh& to) {
  MeshDiff diff;
  diff.base_revision = from.revision;
  diff.revision = to.revision;
  const auto removed = [](const auto& old_rows, const auto& new_rows, auto& ids) {
    for (const auto& [id, row] : old_rows) {
      if (!new_rows.contains(id)) ids.push_back(id);
    }
  };
  const auto is_new = [](const auto& old_rows, auto id, const auto& row) {
    const auto old = old_rows.find(id);
    return old == old_rows.end() || old->second != row;
  };
  removed(from.vertices, to.vertices, diff.removed_vertices);
  removed(from.triangles, to.triangles, diff.removed_triangles);
  removed(from.edges, to.edges, diff.removed_edges);
  for (const auto& [id, row] : to.vertices) {
    if (!is_new(from.vertices, id, row)) continue;
    diff.vertex_ids.push_back(id);
    diff.vertex_positions.push_back(row);
    diff.metric_vertex_ids.push_back(id);
    diff.metrics.push_back(Metric::Isotropic(1 + row.x * row.x));
  }
  for (const auto& [id, row] : to.triangles) {
    if (!is_new(from.triangles, id, row)) continue;
    diff.triangle_ids.push_back(id);
    diff.triangle_vertices.push_back(row.first);
    diff.triangle_regions.push_back(row.second);
  }
  for (const auto& [id, row] : to.edges) {
    if (!is_new(from.edges, id, row)) continue;
    diff.edge_ids.push_back(id);
    diff.edge_vertices.push_back(row.first);
    diff.edge_tags.push_back(row.second);
  }
  diff.summary = to.Summary();
  return diff;
}

/// Another revision of a model: vertices come, move and go, and what used those that went goes too.
class ModelChanger {
 public:
  explicit ModelChanger(std::uint64_t seed) : rng_(seed) {}

  [[nodiscard]] ModelMesh Next(ModelMesh mesh, int change_count) {
    for (int i = 0; i < change_count; ++i) ChangeVertices(mesh);
    std::erase_if(mesh.triangles, [&](const auto& t) { return !AllLive(mesh, t.second.first); });
    std::erase_if(mesh.edges, [&](const auto& e) { return !AllLive(mesh, e.second.first); });
    for (int i = 0; i < 2 * change_count && !mesh.vertices.empty(); ++i) {
      mesh.triangles[TriangleId(Number(60))] = {{Any(mesh), Any(mesh), Any(mesh)}, Number(3)};
      mesh.edges[EdgeId(Number(20))] = {{Any(mesh), Any(mesh)}, Number(3)};
      if (Number(2) == 0) mesh.triangles.erase(TriangleId(Number(60)));
      if (Number(2) == 0) mesh.edges.erase(EdgeId(Number(20)));
    }
    mesh.revision = Revision{static_cast<std::int64_t>(mesh.revision) + 1};
    return mesh;
  }

 private:
  template <class Rows>
  static bool AllLive(const ModelMesh& mesh, const Rows& ids) {
    for (const VertexId id : ids) {
      if (!mesh.vertices.contains(id)) return false;
    }
    return true;
  }
  void ChangeVertices(ModelMesh& mesh) {
    const VertexId id(Number(30));
    if (Number(3) == 0) {
      mesh.vertices.erase(id);
    } else {
      mesh.vertices[id] = {1.0 / (1 + Number(1000)), -0.5 * Number(1000)};
    }
  }
  std::int32_t Number(std::int32_t end) {
    return std::uniform_int_distribution<std::int32_t>(0, end - 1)(rng_);
  }
  VertexId Any(const ModelMesh& mesh) {
    const auto index = Number(static_cast<std::int32_t>(mesh.vertices.size()));
    return std::next(mesh.vertices.begin(), index)->first;
  }

  std::mt19937_64 rng_;
};

/// Compares everything that a replica shows with a model.
inline void ExpectSame(const MeshReplica& replica, const ModelMesh& model) {
  ASSERT_EQ(replica.revision(), model.revision);
  ASSERT_EQ(replica.summary(), model.Summary());
  const CompactMesh compact = replica.Compact();
  ASSERT_EQ(compact.vertex_ids.size(), model.vertices.size());
  ASSERT_EQ(compact.triangle_ids.size(), model.triangles.size());
  ASSERT_EQ(compact.edge_ids.size(), model.edges.size());
  for (std::size_t i = 0; i < compact.vertex_ids.size(); ++i) {
    const VertexId id = compact.vertex_ids[i];
    ASSERT_EQ(compact.mesh.points[i], model.vertices.at(id));
    ASSERT_EQ(compact.vertex_indices[id.index()], static_cast<std::int32_t>(i));
  }
  for (std::size_t i = 0; i < compact.triangle_ids.size(); ++i) {
    const auto& [corners, region] = model.triangles.at(compact.triangle_ids[i]);
    for (std::size_t c = 0; c < 3; ++c) {
      const auto point = static_cast<std::size_t>(compact.mesh.triangles[i][c]);
      ASSERT_EQ(compact.vertex_ids[point], corners[c]);
    }
    ASSERT_EQ(compact.mesh.triangle_tags[i], region);
  }
  for (std::size_t i = 0; i < compact.edge_ids.size(); ++i) {
    const auto& [ends, tag] = model.edges.at(compact.edge_ids[i]);
    for (std::size_t c = 0; c < 2; ++c) {
      const auto point = static_cast<std::size_t>(compact.mesh.edges[i][c]);
      ASSERT_EQ(compact.vertex_ids[point], ends[c]);
    }
    ASSERT_EQ(compact.mesh.edge_tags[i], tag);
  }
}

}  // namespace pliant::client
