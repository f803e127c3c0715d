// How a session goes back to earlier revisions, keeps them, and is copied; see session.h.
#include <memory>
#include <string>
#include <utility>

#include "server/session.h"

namespace pliant::server {

// The mesh of an earlier revision becomes the next one.
Result<std::shared_ptr<const MeshDiff>> Session::GoBack(Revision to_revision,
                                                        std::int64_t update_id) {
  const auto next = Revision(static_cast<std::int64_t>(revision_) + 1);
  PLIANT_ASSIGN_OR_RETURN(const UndoStep way, undo_.WayTo(to_revision, revision_));
  PLIANT_ASSIGN_OR_RETURN(auto gone, engine_->GoTo(way, next));
  UndoStep& back = gone.second;
  back.active_count = std::exchange(active_count_, way.active_count);
  undo_.Add(std::move(back));
  auto diff = std::make_shared<const MeshDiff>(std::move(gone.first));
  RecordCommit(*diff, &way.delta, update_id);
  Publish(diff, update_id);
  return diff;
}

SessionEvent Session::RolledBackEvent(std::int64_t update_id, Revision base) const {
  SessionEvent event = MakeEvent(update_id);
  Progress progress;
  progress.active_count = active_count_;
  progress.stop_reason = active_count_ == 0 ? StopReason::kConverged : StopReason::kVisitBudget;
  event.body = AdvancedEvent{.base_revision = base,
                             .summary = summary_.value_or(MeshSummary{}),
                             .progress = progress,
                             .durable_revision = DurableRevision()};
  return event;
}

void Session::HandleRollback(const std::shared_ptr<Editor>& editor, std::int64_t update_id,
                             Revision to_revision) {
  const Revision base = revision_;
  const auto diff = GoBack(to_revision, update_id);
  if (!diff.ok()) {
    Reject(editor, update_id, diff.error(), StageEffect::kNone);
    return;
  }
  if (mirror_ == Mirror::kFull) {
    SessionEvent event = MakeEvent(update_id);
    event.body = DiffEvent{.diff = *diff, .applied_update_id = update_id};
    Tell(editor, std::move(event));
  }
  Answer(editor, RolledBackEvent(update_id, base), StageEffect::kNone);
}

Result<Session::RolledBack> Session::RollbackTo(Revision to_revision, std::int64_t update_id,
                                                const Fingerprint& update) {
  if (update_id <= results_.last_update_id()) {
    PLIANT_ASSIGN_OR_RETURN(const SessionEvent first, results_.Repeat(update_id, update));
    if (const auto* rejected = std::get_if<RejectedEvent>(&first.body)) return rejected->error;
    return RolledBack{first.revision, std::get<AdvancedEvent>(first.body).summary.state_hash};
  }
  PLIANT_RETURN_IF_ERROR(results_.CheckNew(update_id));
  // Not one that has just come: it hears first where the session is, and then all that follows.
  const std::shared_ptr<Editor> editor = CurrentEditor();
  const bool tells = editor != nullptr && editor == opened_.lock() && mirror_ == Mirror::kFull;
  if (tells && !editor->HasRoom()) {
    return Error{.code = ErrorCode::kResourceExhausted,
                 .message = "the editor of session " + session_id_ +
                            " has not read yet what it was sent; try again when it has",
                 .retry_after_ms = kCallRetryMs};
  }
  const Revision base = revision_;
  PLIANT_ASSIGN_OR_RETURN(const std::shared_ptr<const MeshDiff> diff,
                          GoBack(to_revision, update_id));
  const SessionEvent advanced = RolledBackEvent(update_id, base);
  update_ = update;
  results_.Add({advanced, update_});
  RecordAnswer(&advanced, StageEffect::kNone);
  PublishInfo();
  if (tells) {
    SessionEvent event = MakeEvent(0);
    event.body = DiffEvent{.diff = diff, .applied_update_id = update_id};
    Tell(editor, std::move(event));
  }
  return RolledBack{revision_, diff->summary.state_hash};
}

Status Session::SaveRevision(Revision revision) {
  PLIANT_RETURN_IF_ERROR(undo_.Save(revision, revision_));
  RecordSaved();
  PublishInfo();
  return {};
}

Status Session::Release(const std::vector<std::int64_t>& revisions) {
  PLIANT_RETURN_IF_ERROR(undo_.Release(revisions));
  RecordSaved();
  PublishInfo();
  return {};
}

Result<SessionMemory> Session::Fork(Revision revision) const {
  std::optional<UndoStep> way;
  if (revision != revision_) {
    PLIANT_ASSIGN_OR_RETURN(way, undo_.WayTo(revision, revision_));
  }
  PLIANT_ASSIGN_OR_RETURN(StagedEngine copy, engine_->Fork(way ? &*way : nullptr));
  SessionMemory memory(environment_.history_bytes_max);
  memory.engine.emplace(std::move(copy));
  memory.revision = revision;
  memory.active_count = way ? way->active_count : active_count_;
  memory.summary = memory.engine->engine().Snapshot().summary;
  memory.commit_time = environment_.clock->WallNow();
  memory.history_bytes_max = history_bytes_asked_;
  return memory;
}

Result<SessionMemory> Session::Copy() const {
  PLIANT_ASSIGN_OR_RETURN(SessionMemory memory, Fork(revision_));
  memory.undo = undo_;
  memory.results = results_;
  memory.applied_update_id = applied_update_id_;
  memory.commit_time = commit_time_;
  return memory;
}

}  // namespace pliant::server
