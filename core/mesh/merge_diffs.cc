#include "core/mesh/merge_diffs.h"

#include <algorithm>
#include <span>
#include <vector>

#include "core/base/check.h"
#include "core/mesh/merge_fields.h"

namespace pliant {
namespace {

/// The lists of one kind of element in a diff.
template <class Id>
struct Lists {
  const std::vector<Id>& removed;
  const std::vector<Id>& written;
  const std::vector<Id>& created;
};

/// Where a merged row comes from.
template <class Id>
struct Row {
  Id id;
  bool from_second = false;
  std::size_t index = 0;
};

/// A list in ascending order that is read from its front while the ids of several are walked.
template <class Id>
class Reader {
 public:
  explicit Reader(const std::vector<Id>& ids) : ids_(ids) {}
  [[nodiscard]] bool done() const { return next_ == ids_.size(); }
  [[nodiscard]] Id front() const { return ids_[next_]; }
  /// Whether `id` is in the list, and its place. Ids are asked for in ascending order.
  bool Take(Id id) {
    if (done() || front() != id) return false;
    index_ = next_++;
    return true;
  }
  [[nodiscard]] std::size_t index() const { return index_; }

 private:
  const std::vector<Id>& ids_;
  std::size_t next_ = 0;
  std::size_t index_ = 0;
};

/// What happens to every slot that either diff names.
template <class Id>
class Fold {
 public:
  Fold(const Lists<Id>& first, const Lists<Id>& second)
      : removed1_(first.removed),
        written1_(first.written),
        created1_(first.created),
        removed2_(second.removed),
        written2_(second.written),
        created2_(second.created) {
    rows.reserve(first.written.size() + second.written.size());
    while (FindNext()) FoldSlot();
  }

  std::vector<Id> removed;
  std::vector<Id> created;
  std::vector<Row<Id>> rows;

 private:
  bool FindNext() {
    bool found = false;
    for (const Reader<Id>* reader : {&removed1_, &written1_, &removed2_, &written2_}) {
      if (reader->done() || (found && !(reader->front() < id_))) continue;
      id_ = reader->front();
      found = true;
    }
    return found;
  }

  void FoldSlot() {
    const bool removed1 = removed1_.Take(id_);
    const bool written1 = written1_.Take(id_);
    const bool created1 = created1_.Take(id_);
    const bool removed2 = removed2_.Take(id_);
    const bool written2 = written2_.Take(id_);
    const bool created2 = created2_.Take(id_);
    // Live before both: it was there for the first, or the first says nothing and the second finds
    // it.
    const bool was_live = removed1 || written1 ? !created1 : !created2;
    if (removed2 || (removed1 && !written2)) {
      if (was_live) removed.push_back(id_);
      return;
    }
    rows.push_back({id_, written2, written2 ? written2_.index() : written1_.index()});
    if (!was_live) created.push_back(id_);
  }

  Id id_;
  Reader<Id> removed1_, written1_, created1_;
  Reader<Id> removed2_, written2_, created2_;
};

template <class Id, class Value>
std::vector<Value> Gather(const std::vector<Row<Id>>& rows, const std::vector<Value>& first,
                          const std::vector<Value>& second) {
  std::vector<Value> values;
  values.reserve(rows.size());
  for (const Row<Id>& row : rows) values.push_back((row.from_second ? second : first)[row.index]);
  return values;
}

template <class Id>
std::vector<Id> IdsOf(const std::vector<Row<Id>>& rows) {
  std::vector<Id> ids;
  ids.reserve(rows.size());
  for (const Row<Id>& row : rows) ids.push_back(row.id);
  return ids;
}

/// A first commit creates whatever it writes, and does not say so again.
template <class Id>
const std::vector<Id>& CreatedIn(const MeshDiff& diff, const std::vector<Id>& written,
                                 const std::vector<Id>& created) {
  return diff.base_revision == Revision::kNone ? written : created;
}

/// Metrics go with their vertices, but for those of vertices that only changed their metric.
void MergeMetrics(const MeshDiff& first, const MeshDiff& second, MeshDiff& merged) {
  // To the rows, a vertex that the second removes is removed, whoever created it.
  const std::vector<VertexId> none;
  const Lists<VertexId> one{none, first.metric_vertex_ids, none};
  const Lists<VertexId> two{second.removed_vertices, second.metric_vertex_ids, none};
  const Fold<VertexId> fold(one, two);
  merged.metric_vertex_ids = IdsOf(fold.rows);
  merged.metrics = Gather(fold.rows, first.metrics, second.metrics);
}

template <class Value>
std::size_t BytesIn(const std::vector<Value>& column) {
  return column.size() * sizeof(Value);
}

/// Of transfer rows and fields.
std::size_t BytesOfValues(const MeshDiff& diff) {
  std::size_t bytes = 0;
  if (diff.transfer) bytes += BytesIn(diff.transfer->vertex_ids) + BytesIn(diff.transfer->rows);
  for (const FieldChange& field : diff.fields.changed) {
    bytes += sizeof(FieldChange) + BytesIn(field.rows.slots) + BytesIn(field.rows.values);
  }
  return bytes;
}

}  // namespace

MeshDiff MergeDiffs(const MeshDiff& first, const MeshDiff& second) {
  PLIANT_CHECK(second.base_revision == first.revision);
  MeshDiff merged;
  merged.base_revision = first.base_revision;
  merged.revision = second.revision;
  merged.summary = second.summary;

  Fold<VertexId> vertices({first.removed_vertices, first.vertex_ids,
                           CreatedIn(first, first.vertex_ids, first.created_vertices)},
                          {second.removed_vertices, second.vertex_ids, second.created_vertices});
  merged.removed_vertices = std::move(vertices.removed);
  merged.created_vertices = std::move(vertices.created);
  merged.vertex_ids = IdsOf(vertices.rows);
  merged.vertex_positions = Gather(vertices.rows, first.vertex_positions, second.vertex_positions);

  Fold<TriangleId> triangles(
      {first.removed_triangles, first.triangle_ids,
       CreatedIn(first, first.triangle_ids, first.created_triangles)},
      {second.removed_triangles, second.triangle_ids, second.created_triangles});
  merged.removed_triangles = std::move(triangles.removed);
  merged.created_triangles = std::move(triangles.created);
  merged.triangle_ids = IdsOf(triangles.rows);
  merged.triangle_vertices =
      Gather(triangles.rows, first.triangle_vertices, second.triangle_vertices);
  merged.triangle_regions = Gather(triangles.rows, first.triangle_regions, second.triangle_regions);

  Fold<EdgeId> edges(
      {first.removed_edges, first.edge_ids, CreatedIn(first, first.edge_ids, first.created_edges)},
      {second.removed_edges, second.edge_ids, second.created_edges});
  merged.removed_edges = std::move(edges.removed);
  merged.created_edges = std::move(edges.created);
  merged.edge_ids = IdsOf(edges.rows);
  merged.edge_vertices = Gather(edges.rows, first.edge_vertices, second.edge_vertices);
  merged.edge_tags = Gather(edges.rows, first.edge_tags, second.edge_tags);

  MergeMetrics(first, second, merged);
  merged.fields = MergeFields(first, second);
  return merged;
}

std::size_t BytesOf(const MeshDiff& diff) {
  return sizeof(MeshDiff) + BytesIn(diff.removed_vertices) + BytesIn(diff.removed_triangles) +
         BytesIn(diff.removed_edges) + BytesIn(diff.created_vertices) +
         BytesIn(diff.created_triangles) + BytesIn(diff.created_edges) + BytesIn(diff.vertex_ids) +
         BytesIn(diff.vertex_positions) + BytesIn(diff.triangle_ids) +
         BytesIn(diff.triangle_vertices) + BytesIn(diff.triangle_regions) + BytesIn(diff.edge_ids) +
         BytesIn(diff.edge_vertices) + BytesIn(diff.edge_tags) + BytesIn(diff.metric_vertex_ids) +
         BytesIn(diff.metrics) + BytesOfValues(diff);
}

}  // namespace pliant
