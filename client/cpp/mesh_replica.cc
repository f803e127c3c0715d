#include "client/cpp/mesh_replica.h"

#include <algorithm>
#include <string>

namespace pliant::client {
namespace {

/// Slots beyond this can only come from a damaged diff: a mesh of 100,000,000 vertices, the most
/// that a session may have, has about twice as many triangles.
constexpr std::int32_t kSlotsMax = 1 << 29;

Error Mismatch(std::string field, std::string message, std::int64_t index = -1) {
  return {.code = ErrorCode::kReplicaMismatch,
          .message = std::move(message) + "; ask for a snapshot",
          .field = std::move(field),
          .index = index};
}

std::string Text(std::int64_t value) { return std::to_string(value); }
std::string Text(Revision revision) { return Text(static_cast<std::int64_t>(revision)); }

std::string Hex(std::uint64_t value) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text = "0x";
  for (int shift = 60; shift >= 0; shift -= 4) text += kDigits[(value >> shift) & 15U];
  return text;
}

/// A list of slots must ascend, within bounds; then it names none twice and can be searched.
template <class Id>
Status CheckAscending(const std::vector<Id>& ids, const std::string& field) {
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const bool ascends = i == 0 || ids[i - 1] < ids[i];
    if (!ids[i].valid() || ids[i].value() >= kSlotsMax || !ascends) {
      return Mismatch(field,
                      "slot " + Text(ids[i].value()) + " is out of range or not in ascending order",
                      static_cast<std::int64_t>(i));
    }
  }
  return {};
}

struct ListNames {
  const char* removed;
  const char* listed;
};

/// What holds for each kind of element alike. `row_count` is the length of every other column.
template <class Slots, class Id>
Status CheckKind(const Slots& slots, const std::vector<Id>& removed, const std::vector<Id>& listed,
                 const ListNames& names) {
  PLIANT_RETURN_IF_ERROR(CheckAscending(removed, names.removed));
  PLIANT_RETURN_IF_ERROR(CheckAscending(listed, names.listed));
  auto next = listed.begin();  // Both lists ascend.
  for (std::size_t i = 0; i < removed.size(); ++i) {
    while (next != listed.end() && *next < removed[i]) ++next;
    const bool is_listed = next != listed.end() && *next == removed[i];
    if (!slots.IsLive(removed[i].value()) || is_listed) {
      return Mismatch(
          names.removed,
          "slot " + Text(removed[i].value()) + " is removed, but it is free here or listed as well",
          static_cast<std::int64_t>(i));
    }
  }
  return {};
}

Status CheckLength(std::size_t length, std::size_t expected, const char* field) {
  if (length == expected) return {};
  return Mismatch(field, std::string(field) + " has " + Text(static_cast<std::int64_t>(length)) +
                             " rows, its ids " + Text(static_cast<std::int64_t>(expected)));
}

}  // namespace

template <class Row>
void MeshReplica::Slots<Row>::Write(std::size_t slot, const Row& row, std::int32_t tag) {
  if (slot >= live.size()) {
    rows.resize(slot + 1);
    tags.resize(slot + 1);
    live.resize(slot + 1);
  }
  rows[slot] = row;
  tags[slot] = tag;
  live[slot] = 1;
}

Status MeshReplica::Apply(const MeshDiff& diff) {
  if (diff.base_revision != revision_) {
    return Mismatch("base_revision", "the diff starts at revision " + Text(diff.base_revision) +
                                         ", the replica is at " + Text(revision_));
  }
  if (diff.revision < diff.base_revision) {
    return Mismatch("revision", "the diff leads back to revision " + Text(diff.revision));
  }
  PLIANT_RETURN_IF_ERROR(CheckLists(diff));
  MarkLiveAfter(diff);
  Status status = CheckSound(diff);
  // Last: it takes memory for the slots that the diff names.
  if (status.ok()) status = CountUses(diff);
  if (!status.ok()) {
    UnmarkLiveAfter(diff);
    return status;
  }
  Write(diff);
  summary_ = diff.summary;
  revision_ = diff.revision;
  return {};
}

/// That what the diff leads to is whole, and the server's.
Status MeshReplica::CheckSound(const MeshDiff& diff) const {
  PLIANT_RETURN_IF_ERROR(CheckReferences(diff));
  const MeshSummary after = SummaryAfter(diff);
  const MeshSummary& wanted = diff.summary;
  if (after.vertex_count != wanted.vertex_count || after.triangle_count != wanted.triangle_count ||
      after.edge_count != wanted.edge_count) {
    const auto counts = [](const MeshSummary& s) {
      return Text(s.vertex_count) + " vertices, " + Text(s.triangle_count) + " triangles and " +
             Text(s.edge_count) + " edges";
    };
    return Mismatch("counts", "at revision " + Text(diff.revision) + " the server has " +
                                  counts(wanted) + ", the replica would have " + counts(after));
  }
  if (after.state_hash != wanted.state_hash) {
    return Mismatch("state_hash", "at revision " + Text(diff.revision) +
                                      " the server's mesh has the hash " + Hex(wanted.state_hash) +
                                      ", the replica would have " + Hex(after.state_hash));
  }
  return {};
}

/// Searching the lists for every corner of every triangle cost more than all other checks.
void MeshReplica::MarkLiveAfter(const MeshDiff& diff) {
  for (const VertexId id : diff.removed_vertices) live_after_[id.index()] = 0;
  if (diff.vertex_ids.empty()) return;
  // A damaged diff may name a slot far out: no memory for that before it is known to be right.
  const std::size_t slots = std::min(diff.vertex_ids.back().index() + 1,
                                     4 * (live_after_.size() + diff.vertex_ids.size()));
  if (slots > live_after_.size()) live_after_.resize(slots);
  for (const VertexId id : diff.vertex_ids) {
    if (id.index() < live_after_.size()) live_after_[id.index()] = 1;
  }
}

void MeshReplica::UnmarkLiveAfter(const MeshDiff& diff) {
  for (const auto* ids : {&diff.removed_vertices, &diff.vertex_ids}) {
    for (const VertexId id : *ids) {
      if (id.index() < live_after_.size()) live_after_[id.index()] = IsLive(id) ? 1 : 0;
    }
  }
}

Status MeshReplica::Reset(const MeshDiff& snapshot) {
  MeshReplica fresh;
  PLIANT_RETURN_IF_ERROR(fresh.Apply(snapshot));
  *this = std::move(fresh);
  return {};
}

Status MeshReplica::CheckLists(const MeshDiff& diff) const {
  PLIANT_RETURN_IF_ERROR(CheckKind(vertices_, diff.removed_vertices, diff.vertex_ids,
                                   {"removed_vertices", "vertex_ids"}));
  PLIANT_RETURN_IF_ERROR(CheckKind(triangles_, diff.removed_triangles, diff.triangle_ids,
                                   {"removed_triangles", "triangle_ids"}));
  PLIANT_RETURN_IF_ERROR(
      CheckKind(edges_, diff.removed_edges, diff.edge_ids, {"removed_edges", "edge_ids"}));
  PLIANT_RETURN_IF_ERROR(CheckAscending(diff.metric_vertex_ids, "metric.vertex_ids"));

  const std::size_t triangles = diff.triangle_ids.size();
  const std::size_t edges = diff.edge_ids.size();
  PLIANT_RETURN_IF_ERROR(
      CheckLength(diff.vertex_positions.size(), diff.vertex_ids.size(), "vertex_positions"));
  PLIANT_RETURN_IF_ERROR(
      CheckLength(diff.triangle_vertices.size(), triangles, "triangle_vertices"));
  PLIANT_RETURN_IF_ERROR(CheckLength(diff.triangle_regions.size(), triangles, "triangle_tags"));
  PLIANT_RETURN_IF_ERROR(CheckLength(diff.edge_vertices.size(), edges, "edge_vertices"));
  PLIANT_RETURN_IF_ERROR(CheckLength(diff.edge_tags.size(), edges, "edge_tags"));
  return CheckLength(diff.metrics.size(), diff.metric_vertex_ids.size(), "metric.tensors");
}

/// The hash would notice a wrong corner as well, but only if the server is right.
Status MeshReplica::CheckReferences(const MeshDiff& diff) const {
  const auto lives = [&](VertexId id) {
    if (!id.valid()) return false;
    if (id.index() < live_after_.size()) return live_after_[id.index()] != 0;
    return std::binary_search(diff.vertex_ids.begin(), diff.vertex_ids.end(), id);
  };
  const auto check = [&](const auto& rows, const char* field) -> Status {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      for (const VertexId id : rows[i]) {
        if (!lives(id)) {
          return Mismatch(field, "vertex slot " + Text(id.value()) + " is free",
                          static_cast<std::int64_t>(i));
        }
      }
    }
    return {};
  };
  PLIANT_RETURN_IF_ERROR(check(diff.triangle_vertices, "triangle_vertices"));
  PLIANT_RETURN_IF_ERROR(check(diff.edge_vertices, "edge_vertices"));
  for (std::size_t i = 0; i < diff.metric_vertex_ids.size(); ++i) {
    if (!lives(diff.metric_vertex_ids[i])) {
      return Mismatch("metric.vertex_ids",
                      "vertex slot " + Text(diff.metric_vertex_ids[i].value()) + " is free",
                      static_cast<std::int64_t>(i));
    }
  }
  return {};
}

MeshSummary MeshReplica::SummaryAfter(const MeshDiff& diff) const {
  MeshSummary after = summary_;
  const auto take = [&](const auto& slots, auto id, std::int32_t& count, const auto& hash) {
    if (!slots.IsLive(id.value())) return;
    --count;
    after.state_hash -= hash(id);
  };
  const auto vertex_hash = [&](VertexId id) { return VertexHash(id, vertices_.rows[id.index()]); };
  const auto triangle_hash = [&](TriangleId id) {
    return TriangleHash(id, triangles_.rows[id.index()], triangles_.tags[id.index()]);
  };
  const auto edge_hash = [&](EdgeId id) {
    return EdgeHash(id, edges_.rows[id.index()], edges_.tags[id.index()]);
  };
  for (const auto* ids : {&diff.removed_vertices, &diff.vertex_ids}) {
    for (const VertexId id : *ids) take(vertices_, id, after.vertex_count, vertex_hash);
  }
  for (const auto* ids : {&diff.removed_triangles, &diff.triangle_ids}) {
    for (const TriangleId id : *ids) take(triangles_, id, after.triangle_count, triangle_hash);
  }
  for (const auto* ids : {&diff.removed_edges, &diff.edge_ids}) {
    for (const EdgeId id : *ids) take(edges_, id, after.edge_count, edge_hash);
  }
  after.vertex_count += static_cast<std::int32_t>(diff.vertex_ids.size());
  after.triangle_count += static_cast<std::int32_t>(diff.triangle_ids.size());
  after.edge_count += static_cast<std::int32_t>(diff.edge_ids.size());
  for (std::size_t i = 0; i < diff.vertex_ids.size(); ++i) {
    after.state_hash += VertexHash(diff.vertex_ids[i], diff.vertex_positions[i]);
  }
  for (std::size_t i = 0; i < diff.triangle_ids.size(); ++i) {
    after.state_hash +=
        TriangleHash(diff.triangle_ids[i], diff.triangle_vertices[i], diff.triangle_regions[i]);
  }
  for (std::size_t i = 0; i < diff.edge_ids.size(); ++i) {
    after.state_hash += EdgeHash(diff.edge_ids[i], diff.edge_vertices[i], diff.edge_tags[i]);
  }
  return after;
}

/// Takes over how often each vertex is used, unless one that is removed is used still: then no hash
/// would tell, for the server may have summed up the same.
Status MeshReplica::CountUses(const MeshDiff& diff) {
  AddUses(diff, 1);
  for (std::size_t i = 0; i < diff.removed_vertices.size(); ++i) {
    const VertexId id = diff.removed_vertices[i];
    if (uses_[id.index()] == 0) continue;
    AddUses(diff, -1);
    return Mismatch("removed_vertices",
                    "vertex slot " + Text(id.value()) +
                        " is removed, but triangles or edges that stay have it as a corner",
                    static_cast<std::int64_t>(i));
  }
  return {};
}

/// @param sign  1, or -1 to take that back.
void MeshReplica::AddUses(const MeshDiff& diff, std::int32_t sign) {
  if (!diff.vertex_ids.empty() && diff.vertex_ids.back().index() >= uses_.size()) {
    uses_.resize(diff.vertex_ids.back().index() + 1);
  }
  const auto add = [&](const auto& row, std::int32_t count) {
    for (const VertexId id : row) uses_[id.index()] += count;
  };
  const auto take_old = [&](const auto& slots, const auto& ids) {
    for (const auto id : ids) {
      if (slots.IsLive(id.value())) add(slots.rows[id.index()], -sign);
    }
  };
  take_old(triangles_, diff.removed_triangles);
  take_old(triangles_, diff.triangle_ids);
  take_old(edges_, diff.removed_edges);
  take_old(edges_, diff.edge_ids);
  for (const auto& row : diff.triangle_vertices) add(row, sign);
  for (const auto& row : diff.edge_vertices) add(row, sign);
}

void MeshReplica::Write(const MeshDiff& diff) {
  for (const VertexId id : diff.removed_vertices) {
    vertices_.live[id.index()] = 0;
    if (id.index() < metric_known_.size()) metric_known_[id.index()] = 0;
  }
  for (const TriangleId id : diff.removed_triangles) triangles_.live[id.index()] = 0;
  for (const EdgeId id : diff.removed_edges) edges_.live[id.index()] = 0;
  for (std::size_t i = 0; i < diff.vertex_ids.size(); ++i) {
    vertices_.Write(diff.vertex_ids[i].index(), diff.vertex_positions[i], 0);
  }
  if (live_after_.size() < vertices_.live.size()) live_after_ = vertices_.live;
  for (std::size_t i = 0; i < diff.triangle_ids.size(); ++i) {
    triangles_.Write(diff.triangle_ids[i].index(), diff.triangle_vertices[i],
                     diff.triangle_regions[i]);
  }
  for (std::size_t i = 0; i < diff.edge_ids.size(); ++i) {
    edges_.Write(diff.edge_ids[i].index(), diff.edge_vertices[i], diff.edge_tags[i]);
  }
  for (std::size_t i = 0; i < diff.metric_vertex_ids.size(); ++i) {
    const std::size_t slot = diff.metric_vertex_ids[i].index();
    if (slot >= metrics_.size()) {
      metrics_.resize(slot + 1);
      metric_known_.resize(slot + 1);
    }
    metrics_[slot] = diff.metrics[i];
    metric_known_[slot] = 1;
  }
}

CompactMesh MeshReplica::Compact() const {
  CompactMesh compact;
  compact.vertex_indices.assign(vertices_.live.size(), -1);
  compact.triangle_indices.assign(triangles_.live.size(), -1);
  compact.edge_indices.assign(edges_.live.size(), -1);
  MeshData& mesh = compact.mesh;
  bool all_metrics_known = true;
  for (std::size_t slot = 0; slot < vertices_.live.size(); ++slot) {
    if (vertices_.live[slot] == 0) continue;
    const VertexId id = VertexId::FromIndex(slot);
    compact.vertex_indices[slot] = static_cast<std::int32_t>(mesh.points.size());
    compact.vertex_ids.push_back(id);
    mesh.points.push_back(vertices_.rows[slot]);
    all_metrics_known = all_metrics_known && HasMetric(id);
    if (all_metrics_known) compact.metrics.push_back(metrics_[slot]);
  }
  if (!all_metrics_known) compact.metrics.clear();
  const auto index_of = [&](VertexId id) { return compact.vertex_indices[id.index()]; };
  for (std::size_t slot = 0; slot < triangles_.live.size(); ++slot) {
    if (triangles_.live[slot] == 0) continue;
    compact.triangle_indices[slot] = static_cast<std::int32_t>(mesh.triangles.size());
    compact.triangle_ids.push_back(TriangleId::FromIndex(slot));
    const auto& corners = triangles_.rows[slot];
    mesh.triangles.push_back({index_of(corners[0]), index_of(corners[1]), index_of(corners[2])});
    mesh.triangle_tags.push_back(triangles_.tags[slot]);
  }
  for (std::size_t slot = 0; slot < edges_.live.size(); ++slot) {
    if (edges_.live[slot] == 0) continue;
    compact.edge_indices[slot] = static_cast<std::int32_t>(mesh.edges.size());
    compact.edge_ids.push_back(EdgeId::FromIndex(slot));
    mesh.edges.push_back({index_of(edges_.rows[slot][0]), index_of(edges_.rows[slot][1])});
    mesh.edge_tags.push_back(edges_.tags[slot]);
  }
  return compact;
}

bool SameMesh(const MeshReplica& a, const MeshReplica& b) {
  if (a.revision() != b.revision() || a.summary() != b.summary()) return false;
  const CompactMesh left = a.Compact();
  const CompactMesh right = b.Compact();
  return left.vertex_ids == right.vertex_ids && left.triangle_ids == right.triangle_ids &&
         left.edge_ids == right.edge_ids && left.mesh.triangles == right.mesh.triangles &&
         left.mesh.triangle_tags == right.mesh.triangle_tags &&
         left.mesh.edges == right.mesh.edges && left.mesh.edge_tags == right.mesh.edge_tags &&
         std::equal(left.mesh.points.begin(), left.mesh.points.end(), right.mesh.points.begin(),
                    right.mesh.points.end(), [](Vec2 p, Vec2 q) { return SameBits(p, q); });
}

}  // namespace pliant::client
