// MeshEdit, the part that goes from one committed state to another.

#include <algorithm>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/mesh/mesh_edit.h"

namespace pliant {
namespace {

/// The records of a log, which is sorted by slot and empty then.
template <class IdType, class Record>
RecordsAt<IdType, Record> RecordsOf(RecordLog<IdType, Record>& log, std::int32_t slots) {
  auto [ids, records] = log.Take();
  return {.slots = slots, .ids = std::move(ids), .records = std::move(records)};
}

template <class IdType, class Record>
RecordsAt<IdType, Record> InverseAt(const RecordsAt<IdType, Record>& at,
                                    std::span<const Record> records) {
  RecordsAt<IdType, Record> inverse;
  inverse.slots = static_cast<std::int32_t>(records.size());
  inverse.ids = at.ids;
  inverse.records.reserve(at.ids.size());
  for (const IdType id : at.ids) {
    inverse.records.push_back(id.index() < records.size() ? records[id.index()] : Record());
  }
  return inverse;
}

std::uint64_t HashOf(VertexId id, const VertexRecord& record) {
  return VertexHash(id, record.position);
}
std::uint64_t HashOf(TriangleId id, const TriangleRecord& record) {
  return TriangleHash(id, CanonicalTriangle(record.vertices), record.region);
}
std::uint64_t HashOf(EdgeId id, const EdgeRecord& record) {
  return EdgeHash(id, record.vertices, record.tag);
}

/// What records do to the sum of hashes and to the count of live elements; nothing if slots would
/// come or go that they do not name.
struct Change {
  std::uint64_t hash = 0;
  std::int32_t count = 0;
};
template <class IdType, class Record>
std::optional<Change> ChangeBy(const RecordsAt<IdType, Record>& at,
                               std::span<const Record> records) {
  const auto now = static_cast<std::int32_t>(records.size());
  const std::int32_t first = std::min(now, at.slots);
  const std::int32_t last = std::max(now, at.slots);
  std::int32_t named_count = 0;
  Change change;
  for (std::size_t i = 0; i < at.ids.size(); ++i) {
    const IdType id = at.ids[i];
    if (id.value() >= last) {  // A slot that came and went between the two states.
      if (at.records[i].live) return std::nullopt;
      continue;
    }
    if (id.value() >= first) ++named_count;
    const bool was_live = id.value() < now && records[id.index()].live;
    if (was_live) change.hash -= HashOf(id, records[id.index()]);
    if (at.records[i].live) change.hash += HashOf(id, at.records[i]);
    change.count += static_cast<int>(at.records[i].live) - static_cast<int>(was_live);
  }
  if (named_count != last - first) return std::nullopt;
  return change;
}

/// The segments of a log, which are in the order in which they were cut.
SegmentsAt SegmentsOf(std::vector<std::pair<std::int32_t, SegmentRecord>> log, std::int32_t slots) {
  std::sort(log.begin(), log.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  SegmentsAt at;
  at.slots = slots;
  for (const auto& [index, record] : log) {
    at.indices.push_back(index);
    at.records.push_back(record);
  }
  return at;
}

SegmentsAt InverseSegments(const SegmentsAt& at, std::span<const SegmentRecord> segments) {
  SegmentsAt inverse;
  inverse.slots = static_cast<std::int32_t>(segments.size());
  const auto take = [&](std::int32_t index) {
    inverse.indices.push_back(index);
    inverse.records.push_back(segments[static_cast<std::size_t>(index)]);
  };
  for (const std::int32_t index : at.indices) {
    if (index < inverse.slots) take(index);
  }
  for (std::int32_t index = at.slots; index < inverse.slots; ++index) take(index);
  return inverse;
}

/// True if every segment that comes anew is named.
bool FitsSegments(const SegmentsAt& at, std::int32_t count) {
  const auto is_new = [count](std::int32_t index) { return index >= count; };
  return std::count_if(at.indices.begin(), at.indices.end(), is_new) ==
         std::max(0, at.slots - count);
}

/// Makes the slots that a delta will fill.
template <class Records>
void Grow(std::int32_t slots, Records& records, SlotAllocator& allocator) {
  if (slots <= allocator.size()) return;
  allocator.Resize(slots);
  records.resize(static_cast<std::size_t>(slots));
}

/// Drops slots that are dead.
template <class Records>
void Shrink(std::int32_t slots, Records& records, SlotAllocator& allocator) {
  allocator.Resize(slots);
  records.resize(static_cast<std::size_t>(slots));
}

/// Writes records through `touch`, which logs what stood there.
template <class IdType, class Record, class Touch>
void Write(const RecordsAt<IdType, Record>& at, SlotAllocator& allocator, Touch touch) {
  std::vector<std::int32_t> taken;
  for (std::size_t i = 0; i < at.ids.size() && at.ids[i].value() < allocator.size(); ++i) {
    Record& record = touch(at.ids[i]);
    if (record.live && !at.records[i].live) allocator.Free(at.ids[i].value());
    if (!record.live && at.records[i].live) taken.push_back(at.ids[i].value());
    record = at.records[i];
  }
  allocator.TakeThese(taken);
}

/// @return sum of the hashes
template <class IdType, class Records>
std::uint64_t RestoreAt(Records from, Records& records, SlotAllocator& allocator) {
  records = std::move(from);
  allocator.Reset(static_cast<std::int32_t>(records.size()));
  std::uint64_t hash = 0;
  for (std::size_t i = 0; i < records.size(); ++i) {
    if (records[i].live) {
      hash += HashOf(IdType::FromIndex(i), records[i]);
    } else {
      allocator.Free(static_cast<std::int32_t>(i));
    }
  }
  return hash;
}

}  // namespace

std::optional<MeshDelta> MeshEdit::TakeUndo() {
  if (!has_folded_) return std::nullopt;
  MeshDelta undo;
  undo.vertices = RecordsOf(folded_.vertices, folded_.vertex_slots);
  undo.triangles = RecordsOf(folded_.triangles, folded_.triangle_slots);
  undo.edges = RecordsOf(folded_.edges, folded_.edge_slots);
  undo.segments = SegmentsOf(std::move(folded_.segments), folded_.segment_slots);
  undo.base = summary_;
  undo.summary = folded_summary_;
  folded_ = {};
  has_folded_ = false;
  return undo;
}

MeshDelta MeshEdit::InverseOf(const MeshDelta& delta) const {
  PLIANT_CHECK(logging() && log_.empty());
  return {InverseAt(delta.vertices, mesh_.vertex_records()),
          InverseAt(delta.triangles, mesh_.triangle_records()),
          InverseAt(delta.edges, mesh_.edge_records()),
          InverseSegments(delta.segments, mesh_.segments_),
          delta.summary,
          summary_};
}

bool MeshEdit::Fits(const MeshDelta& delta) const {
  if (delta.base != summary_) return false;
  const auto vertices = ChangeBy(delta.vertices, mesh_.vertex_records());
  const auto triangles = ChangeBy(delta.triangles, mesh_.triangle_records());
  const auto edges = ChangeBy(delta.edges, mesh_.edge_records());
  if (!vertices || !triangles || !edges) return false;
  if (!FitsSegments(delta.segments, static_cast<std::int32_t>(mesh_.segments_.size()))) {
    return false;
  }
  for (const EdgeRecord& edge : delta.edges.records) {
    if (edge.segment >= delta.segments.slots) return false;
  }
  MeshSummary after;
  after.vertex_count = summary_.vertex_count + vertices->count;
  after.triangle_count = summary_.triangle_count + triangles->count;
  after.edge_count = summary_.edge_count + edges->count;
  after.state_hash = summary_.state_hash + vertices->hash + triangles->hash + edges->hash;
  return after == delta.summary;
}

MeshDiff MeshEdit::Apply(const MeshDelta& delta, Revision revision) {
  PLIANT_CHECK(logging() && log_.empty());
  Grow(delta.vertices.slots, mesh_.vertices_, mesh_.vertex_allocator_);
  mesh_.hints_.resize(mesh_.vertices_.size(), -1);
  Grow(delta.triangles.slots, mesh_.triangles_, mesh_.triangle_allocator_);
  Grow(delta.edges.slots, mesh_.edges_, mesh_.edge_allocator_);
  Write(delta.vertices, mesh_.vertex_allocator_,
        [this](VertexId id) -> VertexRecord& { return TouchVertex(id); });
  Write(delta.triangles, mesh_.triangle_allocator_,
        [this](TriangleId id) -> TriangleRecord& { return TouchTriangle(id); });
  Write(delta.edges, mesh_.edge_allocator_,
        [this](EdgeId id) -> EdgeRecord& { return TouchEdge(id); });
  WriteSegments(delta.segments);
  MeshDiff diff = Commit(revision);
  PLIANT_CHECK(diff.summary == delta.summary);
  // Only now, because the commit looks at every slot that it had logged.
  log_.vertex_slots = delta.vertices.slots;
  log_.triangle_slots = delta.triangles.slots;
  log_.edge_slots = delta.edges.slots;
  log_.segment_slots = delta.segments.slots;
  Shrink(delta.vertices.slots, mesh_.vertices_, mesh_.vertex_allocator_);
  mesh_.hints_.resize(mesh_.vertices_.size());
  Shrink(delta.triangles.slots, mesh_.triangles_, mesh_.triangle_allocator_);
  Shrink(delta.edges.slots, mesh_.edges_, mesh_.edge_allocator_);
  return diff;
}

void MeshEdit::WriteSegments(const SegmentsAt& segments) {
  const auto count = static_cast<std::int32_t>(mesh_.segments_.size());
  const auto remember = [this](std::int32_t index) {
    log_.segments.emplace_back(index, mesh_.segments_[static_cast<std::size_t>(index)]);
  };
  for (const std::int32_t index : segments.indices) {
    if (index < count) remember(index);
  }
  for (std::int32_t index = segments.slots; index < count; ++index) remember(index);
  mesh_.segments_.resize(static_cast<std::size_t>(segments.slots));
  for (std::size_t i = 0; i < segments.indices.size(); ++i) {
    mesh_.segments_[static_cast<std::size_t>(segments.indices[i])] = segments.records[i];
  }
}

void MeshEdit::Restore(MeshState state, Revision revision) {
  PLIANT_CHECK(mesh_.vertices_.empty() && mesh_.triangles_.empty());
  std::uint64_t hash =
      RestoreAt<VertexId>(std::move(state.vertices), mesh_.vertices_, mesh_.vertex_allocator_);
  hash += RestoreAt<TriangleId>(std::move(state.triangles), mesh_.triangles_,
                                mesh_.triangle_allocator_);
  hash += RestoreAt<EdgeId>(std::move(state.edges), mesh_.edges_, mesh_.edge_allocator_);
  mesh_.segments_ = std::move(state.segments);
  mesh_.hints_.assign(mesh_.vertices_.size(), -1);
  summary_ = {mesh_.vertex_count(), mesh_.triangle_count(), mesh_.edge_count(), hash};
  StartLog(revision);
}

}  // namespace pliant
