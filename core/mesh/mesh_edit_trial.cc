// MeshEdit, the part that can take back less than a revision, and what motions do to segments.

#include <algorithm>
#include <utility>

#include "core/mesh/mesh_edit.h"

namespace pliant {

MeshEdit::Trial MeshEdit::BeginTrial() {
  PLIANT_CHECK(!in_trial_);
  Trial trial{std::exchange(log_, {}), mesh_.vertex_allocator_, mesh_.triangle_allocator_,
              mesh_.edge_allocator_};
  for (const auto& [id, old] : trial.outer.vertices) mesh_.vertices_[id.index()].touched = false;
  for (const auto& [id, old] : trial.outer.triangles) mesh_.triangles_[id.index()].touched = false;
  for (const auto& [id, old] : trial.outer.edges) mesh_.edges_[id.index()].touched = false;
  in_trial_ = true;
  if (trial.outer.empty()) {
    // A log that has grown to the size of a motion would grow again, page by page.
    std::swap(trial.outer.vertices, log_.vertices);
    std::swap(trial.outer.triangles, log_.triangles);
    std::swap(trial.outer.edges, log_.edges);
  }
  log_.vertex_slots = mesh_.vertex_slots();
  log_.triangle_slots = mesh_.triangle_slots();
  log_.edge_slots = mesh_.edge_slots();
  log_.segment_slots = static_cast<std::int32_t>(mesh_.segments_.size());
  return trial;
}

void MeshEdit::Keep(Trial trial) {
  PLIANT_CHECK(in_trial_);
  in_trial_ = false;
  if (trial.outer.empty() && logging()) {
    // The trial began where the revision did: its log is the revision's.
    PLIANT_CHECK(trial.outer.vertex_slots == log_.vertex_slots &&
                 trial.outer.triangle_slots == log_.triangle_slots &&
                 trial.outer.edge_slots == log_.edge_slots &&
                 trial.outer.segment_slots == log_.segment_slots);
    return;
  }
  const ChangeLog inner = std::exchange(log_, std::move(trial.outer));
  // What the outer log has is older and stays; what is new to it goes in.
  const auto merge = [&](auto& outer, const auto& added, auto& records) {
    for (const auto& [id, old] : outer) records[id.index()].touched = true;
    for (const auto& [id, old] : added) {
      auto& record = records[id.index()];
      const bool known = record.touched;
      record.touched = logging();
      if (logging() && !known) outer.Add(id, old, records.size());
    }
  };
  for (const auto& [id, old] : inner.vertices) mesh_.vertices_[id.index()].touched = false;
  for (const auto& [id, old] : inner.triangles) mesh_.triangles_[id.index()].touched = false;
  for (const auto& [id, old] : inner.edges) mesh_.edges_[id.index()].touched = false;
  merge(log_.vertices, inner.vertices, mesh_.vertices_);
  merge(log_.triangles, inner.triangles, mesh_.triangles_);
  merge(log_.edges, inner.edges, mesh_.edges_);
  if (!logging()) return;
  for (const auto& entry : inner.segments) {
    const bool known = entry.first >= log_.segment_slots ||
                       std::any_of(log_.segments.begin(), log_.segments.end(),
                                   [&](const auto& before) { return before.first == entry.first; });
    if (!known) log_.segments.push_back(entry);
  }
}

void MeshEdit::Undo(Trial trial) {
  PLIANT_CHECK(in_trial_);
  const auto restore = [](const auto& log, auto& records, std::int32_t slots) {
    log.WriteTo(records, [](const auto& /*entry*/, const auto& /*now*/) {});
    records.resize(static_cast<std::size_t>(slots));
  };
  restore(log_.vertices, mesh_.vertices_, log_.vertex_slots);
  restore(log_.triangles, mesh_.triangles_, log_.triangle_slots);
  restore(log_.edges, mesh_.edges_, log_.edge_slots);
  mesh_.hints_.resize(mesh_.vertices_.size());
  RestoreSegments();
  mesh_.vertex_allocator_ = std::move(trial.vertices);
  mesh_.triangle_allocator_ = std::move(trial.triangles);
  mesh_.edge_allocator_ = std::move(trial.edges);
  log_ = std::move(trial.outer);
  in_trial_ = false;
  for (const auto& [id, old] : log_.vertices) mesh_.vertices_[id.index()].touched = true;
  for (const auto& [id, old] : log_.triangles) mesh_.triangles_[id.index()].touched = true;
  for (const auto& [id, old] : log_.edges) mesh_.edges_[id.index()].touched = true;
}

void MeshEdit::RestoreSegments() {
  for (const auto& [index, old] : log_.segments) {
    mesh_.segments_[static_cast<std::size_t>(index)] = old;
  }
  if (logging()) mesh_.segments_.resize(static_cast<std::size_t>(log_.segment_slots));
  log_.segments.clear();
}

void MeshEdit::LogSegment(std::int32_t index) {
  if (!logging() || index >= log_.segment_slots) return;
  const bool known = std::any_of(log_.segments.begin(), log_.segments.end(),
                                 [&](const auto& entry) { return entry.first == index; });
  if (!known) log_.segments.emplace_back(index, mesh_.segments_[static_cast<std::size_t>(index)]);
}

void MeshEdit::PlaceVertex(VertexId vertex, Vec2 position) {
  TouchVertex(vertex).position = position;
}

void MeshEdit::SetParameter(VertexId vertex, double t) {
  const auto [before, after] = mesh_.SegmentEdges(vertex);
  TouchEdge(before).parameters[1] = t;
  TouchEdge(after).parameters[0] = t;
}

void MeshEdit::CutSegment(VertexId vertex) {
  const auto [before, after] = mesh_.SegmentEdges(vertex);
  const std::int32_t whole = mesh_.edge(before).segment;
  const double t = mesh_.edge(before).parameters[1];
  const auto rest = static_cast<std::int32_t>(mesh_.segments_.size());
  SegmentRecord& record = mesh_.segments_[static_cast<std::size_t>(whole)];
  LogSegment(whole);
  const VertexId end = record.b;
  record.b = vertex;
  mesh_.segments_.push_back({vertex, end});
  Fix(vertex);
  // The next edge of the segment begins where this one ends, or ends where it begins.
  const auto along = [&](EdgeId first, std::size_t side, auto visit) {
    for (EdgeId id = first; id.valid();) {
      const VertexId far = mesh_.edge(id).vertices[side];
      visit(TouchEdge(id));
      EdgeId next;
      for (EdgeId other = mesh_.vertex(far).edge; other.valid();) {
        const EdgeRecord& edge = mesh_.edge(other);
        if (other != id && edge.segment == whole && edge.vertices[1 - side] == far) next = other;
        other = edge.next[edge.vertices[0] == far ? 0 : 1];
      }
      id = next;
    }
  };
  along(after, 1, [&](EdgeRecord& edge) {
    edge.parameters[0] = edge.vertices[0] == vertex ? 0 : (edge.parameters[0] - t) / (1 - t);
    edge.parameters[1] = edge.vertices[1] == end ? 1 : (edge.parameters[1] - t) / (1 - t);
    edge.segment = rest;
  });
  along(before, 0, [&](EdgeRecord& edge) {
    edge.parameters[0] /= t;
    edge.parameters[1] = edge.vertices[1] == vertex ? 1 : edge.parameters[1] / t;
  });
}

}  // namespace pliant
