// MeshEdit, the part that ends a revision: folds the change log into a diff or undoes it.

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/base/same_bits.h"
#include "core/mesh/mesh_edit.h"

namespace pliant {
namespace {

/// Room for all that may come: of memory that nobody writes to, a large block costs nothing.
template <class... Columns>
void Reserve(std::size_t count, Columns&... columns) {
  (columns.reserve(count), ...);
}

/// Replicas copy bits, so that -0.0 and 0.0 differ here.
}  // namespace

MeshDiff MeshEdit::Commit(Revision revision) {
  InlineExecutor alone;
  return Commit(revision, alone);
}

MeshDiff MeshEdit::Commit(Revision revision, Executor& executor) {
  if (!logging()) return FirstCommit(revision, executor);
  MeshDiff diff;
  diff.base_revision = committed_;
  diff.revision = revision;
  folded_summary_ = summary_;
  FoldVertices(diff);
  FoldTriangles(diff);
  FoldEdges(diff);
  mesh_.vertex_allocator_.ReleaseParked();
  mesh_.triangle_allocator_.ReleaseParked();
  mesh_.edge_allocator_.ReleaseParked();
  summary_.vertex_count = mesh_.vertex_count();
  summary_.triangle_count = mesh_.triangle_count();
  summary_.edge_count = mesh_.edge_count();
  diff.summary = summary_;
  std::swap(log_, folded_);
  StartLog(revision);
  has_folded_ = true;
  return diff;
}

MeshDiff MeshEdit::FirstCommit(Revision revision, Executor& executor) {
  const auto commit_all = [&](auto& records) {
    Chunks(std::ssize(records)).ForEach(executor, [&](std::int32_t i) {
      auto& record = records[static_cast<std::size_t>(i)];
      record.committed = record.live;
    });
  };
  Chunks(std::ssize(mesh_.vertices_)).ForEach(executor, [&](std::int32_t i) {
    VertexRecord& record = mesh_.vertices_[static_cast<std::size_t>(i)];
    record.committed = record.live;
    // While the first mesh was built everyone was awake and has heard of every move.
    record.visit.drift_x = record.visit.drift_y = 0;
  });
  commit_all(mesh_.triangles_);
  commit_all(mesh_.edges_);
  MeshDiff diff = SnapshotOf(mesh_, revision, executor);
  summary_ = diff.summary;
  StartLog(revision);
  return diff;
}

void MeshEdit::StartLog(Revision revision) {
  log_.vertices.Clear();
  log_.triangles.Clear();
  log_.edges.Clear();
  log_.segments.clear();
  log_.vertex_slots = mesh_.vertex_slots();
  log_.triangle_slots = mesh_.triangle_slots();
  log_.edge_slots = mesh_.edge_slots();
  log_.segment_slots = static_cast<std::int32_t>(mesh_.segments_.size());
  committed_ = revision;
  has_folded_ = false;
}

void MeshEdit::FoldVertices(MeshDiff& diff) {
  log_.vertices.Sort();
  Reserve(log_.vertices.size(), diff.vertex_ids, diff.vertex_positions, diff.metric_vertex_ids,
          diff.metrics);
  for (const auto& [id, old] : log_.vertices) {
    VertexRecord& now = mesh_.vertices_[id.index()];
    now.touched = false;
    now.committed = now.live;
    const bool moved = !old.live || !now.live || !SameBits(old.position, now.position);
    if (old.live && moved) summary_.state_hash -= VertexHash(id, old.position);
    if (now.live && moved) {
      summary_.state_hash += VertexHash(id, now.position);
      diff.vertex_ids.push_back(id);
      diff.vertex_positions.push_back(now.position);
      if (!old.live) diff.created_vertices.push_back(id);
    }
    if (old.live && !now.live) diff.removed_vertices.push_back(id);
    if (now.live && (!old.live || !SameBits(old.metric, now.metric))) {
      diff.metric_vertex_ids.push_back(id);
      diff.metrics.push_back(now.metric);
    }
  }
}

void MeshEdit::FoldTriangles(MeshDiff& diff) {
  log_.triangles.Sort();
  Reserve(log_.triangles.size(), diff.triangle_ids, diff.triangle_vertices, diff.triangle_regions);
  for (const auto& [id, old] : log_.triangles) {
    TriangleRecord& now = mesh_.triangles_[id.index()];
    now.touched = false;
    now.committed = now.live;
    const auto before = CanonicalTriangle(old.vertices);
    const auto after = CanonicalTriangle(now.vertices);
    if (old.live && now.live && before == after && old.region == now.region) continue;
    if (old.live) summary_.state_hash -= TriangleHash(id, before, old.region);
    if (now.live) {
      summary_.state_hash += TriangleHash(id, after, now.region);
      diff.triangle_ids.push_back(id);
      diff.triangle_vertices.push_back(after);
      diff.triangle_regions.push_back(now.region);
      if (!old.live) diff.created_triangles.push_back(id);
    } else if (old.live) {
      diff.removed_triangles.push_back(id);
    }
  }
}

void MeshEdit::FoldEdges(MeshDiff& diff) {
  log_.edges.Sort();
  for (const auto& [id, old] : log_.edges) {
    EdgeRecord& now = mesh_.edges_[id.index()];
    now.touched = false;
    now.committed = now.live;
    if (old.live && now.live && old.vertices == now.vertices && old.tag == now.tag) continue;
    if (old.live) summary_.state_hash -= EdgeHash(id, old.vertices, old.tag);
    if (now.live) {
      summary_.state_hash += EdgeHash(id, now.vertices, now.tag);
      diff.edge_ids.push_back(id);
      diff.edge_vertices.push_back(now.vertices);
      diff.edge_tags.push_back(now.tag);
      if (!old.live) diff.created_edges.push_back(id);
    } else if (old.live) {
      diff.removed_edges.push_back(id);
    }
  }
}

void MeshEdit::Rollback() {
  PLIANT_CHECK(logging());
  const auto restore = [](auto& log, auto& records, SlotAllocator& allocator, std::int32_t slots) {
    log.WriteTo(records, [&](const auto& entry, const auto& now) {
      if (now.live && !entry.second.live) allocator.Free(entry.first.value());
    });
    allocator.Rollback(slots);
    records.resize(static_cast<std::size_t>(slots));
    log.Clear();
  };
  restore(log_.vertices, mesh_.vertices_, mesh_.vertex_allocator_, log_.vertex_slots);
  mesh_.hints_.resize(mesh_.vertices_.size());
  restore(log_.triangles, mesh_.triangles_, mesh_.triangle_allocator_, log_.triangle_slots);
  restore(log_.edges, mesh_.edges_, mesh_.edge_allocator_, log_.edge_slots);
  RestoreSegments();
}

}  // namespace pliant
