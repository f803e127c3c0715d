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
  const std::vector<bool> logged = LoggedSegments();
  for (const auto& entry : inner.segments) {
    if (!logged[static_cast<std::size_t>(entry.first)]) log_.segments.push_back(entry);
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

std::vector<bool> MeshEdit::LoggedSegments() const {
  std::vector<bool> logged(mesh_.segments_.size(), !logging());
  const auto old_count = static_cast<std::size_t>(log_.segment_slots);
  for (std::size_t i = old_count; i < logged.size(); ++i) logged[i] = true;
  for (const auto& [index, old] : log_.segments) logged[static_cast<std::size_t>(index)] = true;
  return logged;
}

void MeshEdit::LogSegment(std::int32_t index, std::vector<bool>& logged) {
  const auto at = static_cast<std::size_t>(index);
  if (at >= logged.size() || logged[at]) return;
  logged[at] = true;
  log_.segments.emplace_back(index, mesh_.segments_[at]);
}

void MeshEdit::PlaceVertex(VertexId vertex, Vec2 position) {
  TouchVertex(vertex).position = position;
}

void MeshEdit::SetParameter(VertexId vertex, double t) {
  const auto [before, after] = mesh_.SegmentEdges(vertex);
  TouchEdge(before).parameters[1] = t;
  TouchEdge(after).parameters[0] = t;
}

void MeshEdit::CutSegments(std::span<const VertexId> vertices) {
  if (vertices.empty()) return;
  std::vector<bool> logged = LoggedSegments();
  std::size_t free = 0;
  for (const VertexId vertex : vertices) {
    while (free < mesh_.segments_.size() && mesh_.segments_[free].a.valid()) ++free;
    if (free == mesh_.segments_.size()) mesh_.segments_.emplace_back();
    LogSegment(static_cast<std::int32_t>(free), logged);
    LogSegment(mesh_.edge(mesh_.SegmentEdges(vertex)[0]).segment, logged);
    CutSegment(vertex, static_cast<std::int32_t>(free));
  }
}

/// Lets the segment of a vertex end there and go on in the free place `rest`.
void MeshEdit::CutSegment(VertexId vertex, std::int32_t rest) {
  const auto [before, after] = mesh_.SegmentEdges(vertex);
  const std::int32_t whole = mesh_.edge(before).segment;
  const double t = mesh_.edge(before).parameters[1];
  SegmentRecord& record = mesh_.segments_[static_cast<std::size_t>(whole)];
  const VertexId end = record.b;
  record.b = vertex;
  mesh_.segments_[static_cast<std::size_t>(rest)] = {vertex, end};
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
