// Remesher, the part that makes revisions, goes back to them, and writes and reads them.

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/freed_memory.h"
#include "core/mesh/committed_snapshot.h"
#include "core/pliant/remesher_impl.h"
#include "core/transfer/check_fields.h"

namespace pliant {
namespace {

/// The first build of so many vertices leaves megabytes that it no longer needs.
constexpr std::int32_t kLargeBuild = 1 << 16;

/// From so many changed vertices on an update that was stopped puts limits off.
constexpr std::size_t kPutOffFrom = StopPoll::kPeriod;

Error NoRevision() {
  return {ErrorCode::kRevisionNotFound, "the session has no revision yet; commit one first",
          "revision"};
}

/// Vertices whose records a delta writes, or whose raw tensors; ascending.
std::vector<VertexId> VerticesOf(const RevisionDelta& delta) {
  std::vector<VertexId> vertices;
  std::ranges::set_union(delta.raw.vertices, delta.mesh.vertices.ids, std::back_inserter(vertices));
  return vertices;
}

/// The corners that the triangles of a delta have now.
void AddCorners(const MeshDelta& delta, const Mesh& mesh, std::vector<VertexId>& vertices) {
  for (const TriangleId id : delta.triangles.ids) {
    if (id.value() >= mesh.triangle_slots() || !mesh.triangle(id).live) continue;
    const auto& corners = mesh.triangle(id).vertices;
    vertices.insert(vertices.end(), corners.begin(), corners.end());
  }
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
  PLIANT_CHECK(followed_.status().ok());
  if (revision_ == Revision::kNone && numbering_ == Numbering::kClosesGaps) {
    loop_.Renumber(edit_.Compact(helpers_.executor()));
  }
  if (PutsLimitsOff()) followed_.PutLimitsOff();
  SettleMetric();
  was_stopped_ = false;
  previous_revision_ = revision_;
  revision_ = Revision(static_cast<std::int64_t>(revision_) + 1);
  MeshDiff diff = edit_.Commit(revision_, helpers_.executor());
  undo_raw_ = followed_.AfterCommit();
  loop_.ResetCounts();
  previous_ = std::move(committed_);
  committed_ = {followed_.state(), loop_.Save(), nullptr};
  domain_replaced_ = false;
  rewoken_.clear();
  if (previous_revision_ == Revision::kNone && mesh_.vertex_count() >= kLargeBuild) {
    ReturnFreedMemory();
  }
  return diff;
}

/// Who stopped an update waits for its commit, and limits on a mesh that is another one take longer
/// than that may.
bool Remesher::Impl::PutsLimitsOff() const {
  const std::size_t changed = revision_ == Revision::kNone
                                  ? static_cast<std::size_t>(mesh_.vertex_count())
                                  : edit_.log().vertices.ids().size();
  return was_stopped_ && followed_.may_put_limits_off() && !followed_.limits_due() &&
         changed >= kPutOffFrom;
}

/// The limits on the mesh that is about to be committed. Nobody wakes for them any more.
void Remesher::Impl::SettleMetric() {
  const Result<WantedTensors> wanted = followed_.Settle();
  PLIANT_CHECK(wanted.ok());
  for (std::size_t i = 0; i < wanted->vertices.size(); ++i) {
    if (!followed_.Differs(mesh_.metric(wanted->vertices[i]), wanted->tensors[i])) continue;
    edit_.SetMetric(wanted->vertices[i], wanted->tensors[i]);
  }
}

Status Remesher::Impl::SetFields(const FieldUpdate& update) {
  if (revision_ == Revision::kNone) {
    return Error{ErrorCode::kRevisionNotFound,
                 "there is no revision yet whose elements could have values; advance first",
                 "fields"};
  }
  if (domain_replaced_ && update.transfer == TransferKind::kConservative) {
    return Error{ErrorCode::kUnimplemented,
                 "a field cannot become conservative while the domain is being replaced: advance "
                 "first, or let it be linear or bounded",
                 "fields"};
  }
  return fields_.Stage(mesh_, update);
}

void Remesher::Impl::Rollback() {
  PLIANT_CHECK(revision_ != Revision::kNone);
  edit_.Rollback();
  fields_.Discard();
  carriers_.clear();
  followed_.Rollback(committed_.followed);
  GoOnAsCommitted();
}

void Remesher::Impl::GoOnAsCommitted() {
  loop_.Restore(committed_.loop);
  options_ = committed_.loop.options;
  followed_.SetTolerance(options_.metric_tolerance);
  frozen_.reset();
  rewoken_.clear();
  domain_replaced_ = false;
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
                       .raw = std::move(undo_raw_),
                       .loop = previous_.loop,
                       .fields = previous_.fields,
                       .base_fields = committed_.fields};
}

RevisionDelta Remesher::Impl::InverseOf(const RevisionDelta& delta) const {
  // Raw tensors are others where there are functions beside them, or were.
  const FollowedMetric::State& now = committed_.followed;
  const bool all = delta.raw.all || delta.metric.limits != now.limits ||
                   !MetricFunctions::AreSame(delta.metric.functions.get(), now.functions.get());
  const MeshLimits& limits = followed_.limits();
  return {.base = delta.revision,
          .revision = revision_,
          .mesh = edit_.InverseOf(delta.mesh),
          .metric = committed_.followed,
          .base_metric = delta.metric,
          .raw = all ? limits.All() : limits.At(VerticesOf(delta)),
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
  std::vector<VertexId> touched = VerticesOf(delta);
  AddCorners(delta.mesh, mesh_, touched);
  MeshDiff diff = edit_.Apply(delta.mesh, revision);
  AddCorners(delta.mesh, mesh_, touched);
  previous_revision_ = std::exchange(revision_, revision);
  previous_ = std::exchange(committed_, {delta.metric, delta.loop, delta.fields});
  undo_raw_ = followed_.GoTo(committed_.followed, delta.raw, touched);
  GoOnAsCommitted();
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
  return WriteSnapshot({.box = box_,
                        .revision = revision_,
                        .summary = edit_.summary(),
                        .mesh = mesh_,
                        .metric = committed_.followed,
                        .raw = followed_.limits().All(),
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
