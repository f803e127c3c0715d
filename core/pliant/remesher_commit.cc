// Remesher, the part that makes revisions, goes back to them, and writes and reads them.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh/committed_snapshot.h"
#include "core/pliant/remesher_impl.h"
#include "core/transfer/check_fields.h"

namespace pliant {
namespace {

Error NoRevision() {
  return {ErrorCode::kRevisionNotFound, "the session has no revision yet; commit one first",
          "revision"};
}

}  // namespace

MeshDiff Remesher::Impl::CommitAndTransfer() {
  if (revision_ == Revision::kNone) return CommitMesh();
  const bool staged = fields_.staged();
  const MeshTransfer transfer(mesh_, edit_.log());
  FieldChanges fields = fields_.Commit(transfer);
  MeshDiff diff = CommitMesh();
  const bool same = diff.empty() && !staged;
  committed_.fields = same ? previous_.fields : KeepFields(fields_.fields());
  diff.transfer = transfer.rows();
  diff.fields = std::move(fields);
  return diff;
}

MeshDiff Remesher::Impl::CommitMesh() {
  LeaveNestedBuild();
  PLIANT_CHECK(carriers_.empty() || LetMetricFollow().ok());
  PLIANT_CHECK(followed_.raw()->status().ok());
  if (revision_ == Revision::kNone && numbering_ == Numbering::kClosesGaps) {
    loop_.Renumber(edit_.Compact(helpers_.executor()));
  }
  previous_revision_ = revision_;
  revision_ = Revision(static_cast<std::int64_t>(revision_) + 1);
  MeshDiff diff = edit_.Commit(revision_, helpers_.executor());
  loop_.ResetCounts();
  previous_ = std::move(committed_);
  committed_ = {followed_.state(), loop_.Save(), nullptr};
  return diff;
}

Status Remesher::Impl::SetFields(const FieldUpdate& update) {
  if (revision_ == Revision::kNone) {
    return Error{ErrorCode::kRevisionNotFound,
                 "there is no revision yet whose elements could have values; advance first",
                 "fields"};
  }
  return fields_.Stage(mesh_, update);
}

void Remesher::Impl::Rollback() {
  PLIANT_CHECK(revision_ != Revision::kNone);
  edit_.Rollback();
  fields_.Discard();
  carriers_.clear();
  followed_.Restore(committed_.followed);
  loop_.Restore(committed_.loop);
}

MeshDiff Remesher::Impl::Snapshot() const {
  PLIANT_CHECK(revision_ != Revision::kNone);
  return CommittedSnapshot(edit_, revision_);
}

std::optional<RevisionDelta> Remesher::Impl::TakeUndo() {
  std::optional<MeshDelta> mesh = edit_.TakeUndo();
  if (!mesh) return std::nullopt;
  return RevisionDelta{.base = revision_,
                       .revision = previous_revision_,
                       .mesh = *std::move(mesh),
                       .metric = previous_.followed,
                       .base_metric = committed_.followed,
                       .loop = previous_.loop,
                       .fields = previous_.fields,
                       .base_fields = committed_.fields};
}

RevisionDelta Remesher::Impl::InverseOf(const RevisionDelta& delta) const {
  return {.base = delta.revision,
          .revision = revision_,
          .mesh = edit_.InverseOf(delta.mesh),
          .metric = committed_.followed,
          .base_metric = delta.metric,
          .loop = committed_.loop,
          .fields = committed_.fields,
          .base_fields = delta.fields};
}

Result<MeshDiff> Remesher::Impl::Apply(const RevisionDelta& delta, Revision revision) {
  if (revision_ == Revision::kNone) return NoRevision();
  Rollback();
  if (!edit_.Fits(delta.mesh)) {
    return CorruptData("revision record", "does not lead from revision " +
                                              std::to_string(static_cast<std::int64_t>(revision_)));
  }
  MeshDiff diff = edit_.Apply(delta.mesh, revision);
  previous_revision_ = std::exchange(revision_, revision);
  previous_ = std::exchange(committed_, {delta.metric, delta.loop, delta.fields});
  followed_.Restore(committed_.followed);
  loop_.Restore(committed_.loop);
  RestoreFields();
  if (previous_.fields != committed_.fields) diff.fields = AllFields(previous_.fields);
  return diff;
}

Result<Bytes> Remesher::Impl::Save() const {
  if (revision_ == Revision::kNone) return NoRevision();
  if (!edit_.log().empty()) {
    return Error{ErrorCode::kProtocolOrder,
                 "the session has changed since its last commit; commit or roll back, then save"};
  }
  return WriteSnapshot({.options = options_,
                        .box = box_,
                        .revision = revision_,
                        .summary = edit_.summary(),
                        .mesh = mesh_,
                        .metric = committed_.followed,
                        .loop = committed_.loop,
                        .fields = committed_.fields});
}

Result<std::unique_ptr<Remesher::Impl>> Remesher::Impl::Load(std::span<const std::byte> bytes) {
  PLIANT_ASSIGN_OR_RETURN(SavedSession snapshot, ReadSnapshot(bytes));
  const MeshSummary summary = snapshot.summary;
  auto impl = std::make_unique<Impl>(std::move(snapshot));
  if (impl->edit_.summary() != summary) {
    return CorruptData("snapshot", "has another mesh than its state hash says");
  }
  return impl;
}

Result<RevisionDelta> Remesher::Impl::ReadDelta(std::span<const std::byte> bytes) const {
  PLIANT_ASSIGN_OR_RETURN(RevisionDelta delta,
                          pliant::ReadDelta(bytes, committed_.followed, committed_.fields));
  if (delta.base != revision_) {
    return Error{ErrorCode::kRevisionMismatch,
                 "the revision record leads from revision " +
                     std::to_string(static_cast<std::int64_t>(delta.base)) +
                     "; the session is at " + std::to_string(static_cast<std::int64_t>(revision_)),
                 "revision"};
  }
  return delta;
}

void Remesher::Impl::RestoreFields() {
  fields_.Restore(committed_.fields ? std::span(*committed_.fields) : std::span<const Field>());
}

/// Every value, and the fields that are no more: what a copy of others needs.
FieldChanges Remesher::Impl::AllFields(const SharedFields& before) const {
  std::vector<VertexId> vertices;
  for (const std::int32_t slot : CommittedSlots(mesh_, FieldLocation::kVertex)) {
    vertices.emplace_back(slot);
  }
  std::vector<TriangleId> triangles;
  for (const std::int32_t slot : CommittedSlots(mesh_, FieldLocation::kTriangle)) {
    triangles.emplace_back(slot);
  }
  FieldChanges changes{.changed = fields_.At(vertices, triangles), .dropped_names = {}};
  if (before == nullptr) return changes;
  for (const Field& field : *before) {
    if (fields_.Find(field.name) == nullptr) changes.dropped_names.push_back(field.name);
  }
  return changes;
}

}  // namespace pliant
