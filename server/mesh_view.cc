#include "server/mesh_view.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/base/check.h"
#include "core/base/sort_unique.h"

namespace pliant::server {
namespace {

/// In a diff from nothing everything is new, and the lists of what was created are empty.
template <class Id>
bool IsNew(const MeshDiff& diff, const std::vector<Id>& created, Id id) {
  return diff.base_revision == Revision::kNone ||
         std::binary_search(created.begin(), created.end(), id);
}

template <class Rows, class Id>
void GrowTo(Rows& rows, const std::vector<Id>& ids) {
  if (!ids.empty() && ids.back().index() >= rows.size()) rows.resize(ids.back().index() + 1);
}

}  // namespace

MeshDiff MeshView::Reset(const MeshDiff& snapshot) {
  *this = MeshView(std::move(spec_));
  std::optional<MeshDiff> seen = Follow(snapshot);
  PLIANT_CHECK(seen.has_value() && snapshot.base_revision == Revision::kNone);
  return *std::move(seen);
}

std::optional<MeshDiff> MeshView::Follow(const MeshDiff& diff) {
  Grow(diff);
  const std::vector<Touched> touched = TouchedBy(diff);
  MeshDiff seen;
  seen.base_revision = diff.base_revision;
  seen.revision = diff.revision;
  if (!TakeTriangles(diff, seen) || !TakeVertices(diff, touched, seen)) return std::nullopt;
  const bool vertices_changed = std::any_of(
      touched.begin(), touched.end(),
      [this](const Touched& vertex) { return vertex.was_in_view != InView(vertex.id); });
  if (!spec_.only_vertices) TakeEdges(diff, vertices_changed, seen);
  TakeValues(diff, seen);
  seen.summary = summary_;
  return seen;
}

std::vector<std::int32_t> MeshView::AbsentTags() const {
  std::vector<std::int32_t> absent;
  for (std::size_t i = 0; i < tag_uses_.size(); ++i) {
    if (tag_uses_[i] == 0) absent.push_back(spec_.region_tags[i]);
  }
  return absent;
}

bool MeshView::Wants(std::int32_t region) const {
  return spec_.region_tags.empty() ||
         std::binary_search(spec_.region_tags.begin(), spec_.region_tags.end(), region);
}

std::int64_t* MeshView::UsesOf(std::int32_t region) {
  const auto& tags = spec_.region_tags;
  if (tags.empty()) return nullptr;
  return &tag_uses_[static_cast<std::size_t>(std::lower_bound(tags.begin(), tags.end(), region) -
                                             tags.begin())];
}

void MeshView::Grow(const MeshDiff& diff) {
  GrowTo(uses_, diff.vertex_ids);
  GrowTo(vertex_hashes_, diff.vertex_ids);
  GrowTo(triangles_, diff.triangle_ids);
  GrowTo(edges_, diff.edge_ids);
}

// Every vertex that may come, go or move, in ascending order, and where it is before the diff.
std::vector<MeshView::Touched> MeshView::TouchedBy(const MeshDiff& diff) const {
  std::vector<VertexId> ids;
  const auto add = [&ids](const auto& from) { ids.insert(ids.end(), from.begin(), from.end()); };
  add(diff.removed_vertices);
  add(diff.vertex_ids);
  for (const auto* triangles : {&diff.removed_triangles, &diff.triangle_ids}) {
    for (const TriangleId id : *triangles) {
      if (triangles_[id.index()].in_view) add(triangles_[id.index()].vertices);
    }
  }
  for (std::size_t i = 0; i < diff.triangle_ids.size(); ++i) {
    if (Wants(diff.triangle_regions[i])) add(diff.triangle_vertices[i]);
  }
  SortUnique(ids);
  std::vector<Touched> touched;
  touched.reserve(ids.size());
  for (const VertexId id : ids) touched.push_back({id, InView(id)});
  return touched;
}

// True if it was in view.
bool MeshView::Leave(TriangleId id) {
  TriangleRow& row = triangles_[id.index()];
  if (!row.in_view) return false;
  for (const VertexId corner : row.vertices) --uses_[corner.index()];
  row.in_view = false;
  if (std::int64_t* const uses = UsesOf(row.region)) --*uses;
  if (!spec_.only_vertices) {
    --summary_.triangle_count;
    summary_.state_hash -= TriangleHash(id, row.vertices, row.region);
  }
  return true;
}

bool MeshView::TakeTriangles(const MeshDiff& diff, MeshDiff& seen) {
  for (const TriangleId id : diff.removed_triangles) {
    if (Leave(id)) seen.removed_triangles.push_back(id);
  }
  for (std::size_t i = 0; i < diff.triangle_ids.size(); ++i) {
    const TriangleId id = diff.triangle_ids[i];
    const bool was_in_view = Leave(id);
    if (!Wants(diff.triangle_regions[i])) {
      if (was_in_view) seen.removed_triangles.push_back(id);
      continue;
    }
    if (!was_in_view && spec_.with_values && !IsNew(diff, diff.created_triangles, id)) return false;
    const TriangleRow row{diff.triangle_vertices[i], diff.triangle_regions[i], true};
    for (const VertexId corner : row.vertices) ++uses_[corner.index()];
    triangles_[id.index()] = row;
    if (std::int64_t* const uses = UsesOf(row.region)) ++*uses;
    if (spec_.only_vertices) continue;
    ++summary_.triangle_count;
    summary_.state_hash += TriangleHash(id, row.vertices, row.region);
    seen.triangle_ids.push_back(id);
    seen.triangle_vertices.push_back(row.vertices);
    seen.triangle_regions.push_back(row.region);
  }
  std::sort(seen.removed_triangles.begin(), seen.removed_triangles.end());
  if (spec_.only_vertices) seen.removed_triangles.clear();
  return true;
}

bool MeshView::TakeVertices(const MeshDiff& diff, std::span<const Touched> touched,
                            MeshDiff& seen) {
  std::size_t next = 0;  // In the list of the diff, which ascends as well.
  for (const auto& [id, was_in_view] : touched) {
    while (next < diff.vertex_ids.size() && diff.vertex_ids[next] < id) ++next;
    const bool listed = next < diff.vertex_ids.size() && diff.vertex_ids[next] == id;
    const bool in_view = InView(id);
    std::uint64_t& hash = vertex_hashes_[id.index()];
    if (was_in_view) {
      --summary_.vertex_count;
      summary_.state_hash -= hash;
      if (!in_view) seen.removed_vertices.push_back(id);
    }
    if (!in_view) continue;
    const bool has_values = !spec_.with_values || IsNew(diff, diff.created_vertices, id);
    if (!was_in_view && !(listed && has_values)) return false;
    if (listed) {
      hash = VertexHash(id, diff.vertex_positions[next]);
      seen.vertex_ids.push_back(id);
      seen.vertex_positions.push_back(diff.vertex_positions[next]);
    }
    ++summary_.vertex_count;
    summary_.state_hash += hash;
  }
  return true;
}

// All edges are known, so that one whose ends come into view can be told at any time.
void MeshView::TakeEdges(const MeshDiff& diff, bool vertices_changed, MeshDiff& seen) {
  for (const EdgeId id : diff.removed_edges) edges_[id.index()].live = false;
  for (std::size_t i = 0; i < diff.edge_ids.size(); ++i) {
    EdgeRow& row = edges_[diff.edge_ids[i].index()];
    row.vertices = diff.edge_vertices[i];
    row.tag = diff.edge_tags[i];
    row.live = true;
  }
  std::vector<EdgeId> ids;
  if (vertices_changed) {
    for (std::size_t i = 0; i < edges_.size(); ++i) ids.push_back(EdgeId::FromIndex(i));
  } else {
    std::merge(diff.removed_edges.begin(), diff.removed_edges.end(), diff.edge_ids.begin(),
               diff.edge_ids.end(), std::back_inserter(ids));
  }
  for (const EdgeId id : ids) {
    EdgeRow& row = edges_[id.index()];
    const bool was_in_view = row.in_view;
    row.in_view = row.live && InView(row.vertices[0]) && InView(row.vertices[1]);
    const std::uint64_t hash = row.in_view ? EdgeHash(id, row.vertices, row.tag) : 0;
    if (was_in_view) {
      --summary_.edge_count;
      summary_.state_hash -= row.hash;
      if (!row.in_view) seen.removed_edges.push_back(id);
    }
    if (!row.in_view) continue;
    if (!was_in_view || row.hash != hash) {
      seen.edge_ids.push_back(id);
      seen.edge_vertices.push_back(row.vertices);
      seen.edge_tags.push_back(row.tag);
    }
    ++summary_.edge_count;
    summary_.state_hash += hash;
    row.hash = hash;
  }
}

void MeshView::TakeValues(const MeshDiff& diff, MeshDiff& seen) const {
  for (std::size_t i = 0; i < diff.metric_vertex_ids.size(); ++i) {
    if (!InView(diff.metric_vertex_ids[i])) continue;
    seen.metric_vertex_ids.push_back(diff.metric_vertex_ids[i]);
    seen.metrics.push_back(diff.metrics[i]);
  }
  // A row may have sources that are out of view, so that rows are for whole meshes.
  if (spec_.region_tags.empty()) seen.transfer = diff.transfer;
  seen.fields.dropped_names = diff.fields.dropped_names;
  for (const FieldChange& field : diff.fields.changed) {
    const bool at_vertices = field.location == FieldLocation::kVertex;
    if (!at_vertices && spec_.only_vertices) continue;
    FieldChange& part = seen.fields.changed.emplace_back(
        FieldChange{field.name, field.location, field.column_count, {}});
    for (std::size_t i = 0; i < field.rows.slots.size(); ++i) {
      const auto slot = static_cast<std::size_t>(field.rows.slots[i]);
      if (!(at_vertices ? InView(VertexId::FromIndex(slot)) : triangles_[slot].in_view)) continue;
      part.rows.slots.push_back(field.rows.slots[i]);
      const auto row =
          field.rows.values.begin() + static_cast<std::ptrdiff_t>(i * field.column_count);
      part.rows.values.insert(part.rows.values.end(), row,
                              row + static_cast<std::ptrdiff_t>(field.column_count));
    }
  }
}

}  // namespace pliant::server
