// How a session runs an advance, from its command to the commit; see session.h.
#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/check.h"
#include "server/kept_bytes.h"
#include "server/revision_text.h"
#include "server/session.h"

namespace pliant::server {
namespace {

/// A cancel, or the end of an advance's time.
class AdvanceStop final : public StopSignal {
 public:
  AdvanceStop(const StopFlag& cancel, const Clock& clock, std::optional<Clock::Time> deadline)
      : cancel_(cancel), clock_(clock), deadline_(deadline) {}
  [[nodiscard]] bool asked() const override {
    return cancel_.asked() || (deadline_ && clock_.Now() >= *deadline_);
  }

 private:
  const StopFlag& cancel_;
  const Clock& clock_;
  const std::optional<Clock::Time> deadline_;
};

}  // namespace

void Session::BeginAdvance(const std::shared_ptr<Editor>& editor, std::int64_t update_id,
                           const AdvanceSpec& spec) {
  if (engine_->tainted()) {
    const Error refused = engine_->late_refusal().value_or(
        Error{ErrorCode::kUpdateRejected,
              "an update since the last advance was refused, so nothing was "
              "committed and the stage is empty now: send the step again",
              {}});
    const Status status = engine_->Discard();
    Reject(editor, update_id, status.ok() ? refused : status.error(), StageEffect::kEmptied);
    return;
  }
  if (const Status status = CheckCompute(); !status.ok()) {
    Reject(editor, update_id, status.error(), StageEffect::kNone);
    return;
  }
  const Clock::Time now = environment_.clock->Now();
  advance_ = RunningAdvance{.editor = editor,
                            .update_id = update_id,
                            .spec = spec,
                            .begin = BeginOf(spec, now),
                            .base_revision = revision_,
                            .progress = {},
                            .committed_counts = {},
                            .motion_fraction = engine_->motion_fraction(),
                            .softened_count = 0,
                            .last_progress = now,
                            .last_commit = now};
  const std::lock_guard lock(mutex_);
  running_update_id_ = update_id;
  stop_work_.Set(IsCancelled(update_id) || close_error_ || drain_error_);
  info_.running = true;
}

// Its time runs from when it came, not from when what was sent with it is staged: for its client
// both are one step, which has one deadline. The advance before it has a time of its own.
Clock::Time Session::BeginOf(const AdvanceSpec& advance, Clock::Time now) const {
  return std::clamp(advance.arrival.value_or(now), last_advance_end_, now);
}

// Works on the advance until it ends (true) or the slice does (false).
bool Session::ContinueAdvance(Clock::Time slice_end) {
  RunningAdvance& advance = *advance_;
  const Clock& clock = *environment_.clock;
  // The first step is made whatever the time: an advance without it would lead nowhere.
  std::optional<Clock::Time> deadline;
  for (;;) {
    if (advance.spec.time_max && VisitsOf(advance) > 0) {
      deadline = advance.begin + *advance.spec.time_max;
    }
    const AdvanceStop stop(stop_work_, clock, deadline);
    const std::int64_t visits_left = advance.spec.visits_max - VisitsOf(advance);
    const std::int64_t visits = environment_.visits_per_step * engine_->engine().step_threads();
    const Clock::Time step_begin = clock.Now();
    const Result<Progress> result =
        engine_->Step({.visits_max = std::min(visits_left, visits), .stop = &stop});
    const Clock::Time now = clock.Now();
    advance.compute += now - step_begin;
    Charge(now - step_begin);
    const Status room = result.ok() ? CheckRoom(Usage()) : Status(result.error());
    if (!room.ok()) {
      FailAdvance(room.error());
      return true;
    }
    advance.progress = *result;
    advance.softened_count = std::max(advance.softened_count, engine_->engine().softened_count());
    if (advance.progress.stop_reason == StopReason::kCancelled && !stop_work_.asked()) {
      advance.progress.stop_reason = StopReason::kVisitBudget;  // It was the deadline, see below.
    }
    if (advance.progress.stop_reason == StopReason::kCancelled) {
      const std::lock_guard lock(mutex_);
      if (close_error_) return true;  // Nobody is left to commit for.
    }
    if (advance.progress.stop_reason != StopReason::kVisitBudget ||
        VisitsOf(advance) >= advance.spec.visits_max) {
      FinishAdvance(AdvanceEnd::kEngine);
      return true;
    }
    if (advance.spec.time_max && now - advance.begin >= *advance.spec.time_max) {
      FinishAdvance(AdvanceEnd::kTimeBudget);
      return true;
    }
    TellProgress(now);
    CommitOnTheWay(now);
    if (now >= slice_end || (journal_ != nullptr && journal_->waits())) return false;
  }
}

std::int64_t Session::VisitsOf(const RunningAdvance& advance) const {
  return advance.committed_counts.visits + advance.progress.counts.visits;
}

void Session::TellProgress(Clock::Time now) {
  RunningAdvance& advance = *advance_;
  if (!advance.spec.progress_interval ||
      now - advance.last_progress < *advance.spec.progress_interval) {
    return;
  }
  advance.last_progress = now;
  SessionEvent event = MakeEvent(advance.update_id);
  ProgressEvent progress{
      .progress = advance.progress,
      .vertex_count = engine_->engine().vertex_count(),
      .elapsed = std::chrono::duration_cast<std::chrono::milliseconds>(now - advance.begin)};
  progress.progress.counts.visits = VisitsOf(advance);
  event.body = progress;
  Tell(advance.editor, std::move(event));
}

// Commits an unfinished mesh if that was asked for and somebody can take it: a reader who does not
// keep up gets fewer revisions, not more memory.
void Session::CommitOnTheWay(Clock::Time now) {
  RunningAdvance& advance = *advance_;
  if (!advance.spec.commit_interval || now - advance.last_commit < *advance.spec.commit_interval ||
      !advance.editor->HasRoom() || engine_->engine().building()) {
    return;
  }
  advance.last_commit = now;
  const std::shared_ptr<const MeshDiff> diff = Commit(advance);
  advance.committed_counts = advance.committed_counts + advance.progress.counts;
  advance.progress.counts = {};
  if (mirror_ != Mirror::kFull) return;
  SessionEvent event = MakeEvent(advance.update_id);
  event.body = DiffEvent{.diff = diff, .applied_update_id = applied_update_id_};
  Tell(advance.editor, std::move(event));
}

// The mesh as it is becomes a revision, for everybody who asks or listens.
std::shared_ptr<const MeshDiff> Session::Commit(const RunningAdvance& advance) {
  const bool with_rows = editor_wants_transfer_ || followers_.AnyWantsTransfer();
  auto diff = std::make_shared<const MeshDiff>(with_rows ? engine_->CommitAndTransfer()
                                                         : engine_->Commit());
  std::optional<UndoStep> undo = engine_->TakeUndo();
  const std::int64_t undo_active_count =
      std::exchange(active_count_, advance.progress.active_count);
  if (journal_ != nullptr) {
    std::optional<RevisionDelta> forth;
    if (undo) forth = engine_->engine().InverseOf(undo->delta);
    RecordCommit(*diff, forth ? &*forth : nullptr, advance.update_id);
  }
  if (undo) {
    undo->active_count = undo_active_count;
    undo_.Add(*std::move(undo));
  } else {
    undo_.Clear();
  }
  Publish(diff, advance.update_id);
  return diff;
}

// A revision is there: for the history, for who asks, and for who listens.
void Session::Publish(const std::shared_ptr<const MeshDiff>& diff, std::int64_t update_id) {
  const std::int64_t vertex_count = diff->summary.vertex_count;
  const std::size_t bytes_max = environment_.history_bytes_max;
  history_.SetBytesMax(HistoryBytesMax(vertex_count, bytes_max, history_bytes_asked_));
  undo_.SetBytesMax(UndoBytesMax(vertex_count, history_bytes_asked_));
  history_.Add(diff);
  ReportUsage();
  followers_wait_ = true;
  revision_ = diff->revision;
  applied_update_id_ = update_id;
  summary_ = diff->summary;
  if (journal_ == nullptr) commit_time_ = environment_.clock->WallNow();
  PublishInfo();
}

void Session::FinishAdvance(AdvanceEnd end) {
  RunningAdvance advance = *std::move(advance_);
  current_editor_ = advance.editor;
  current_update_id_ = advance.update_id;
  advance_.reset();
  const Clock::Time commit_begin = environment_.clock->Now();
  const TroubleSearch search = engine_->engine().WhereTroublesMayBe();
  const std::shared_ptr<const MeshDiff> diff = Commit(advance);
  advance.compute += environment_.clock->Now() - commit_begin;
  {
    const std::lock_guard lock(mutex_);
    running_update_id_ = 0;
    stop_work_.Set(false);
    if (drain_error_ && advance.progress.stop_reason == StopReason::kCancelled) {
      end = AdvanceEnd::kServerClosing;
    }
  }
  if (mirror_ == Mirror::kFull) {
    SessionEvent event = MakeEvent(advance.update_id);
    event.body = DiffEvent{.diff = diff, .applied_update_id = applied_update_id_};
    Tell(advance.editor, std::move(event));
  }
  // While the client takes over the diff.
  const Clock::Time search_begin = environment_.clock->Now();
  std::vector<Trouble> troubles;
  if (advance.progress.active_count == 0) troubles = engine_->engine().FindTroubles(search);
  const Clock::Time now = environment_.clock->Now();
  advance.compute += now - search_begin;
  advance.progress.counts = advance.committed_counts + advance.progress.counts;
  SessionEvent advanced = MakeEvent(advance.update_id);
  advanced.body = AdvancedEvent{
      .base_revision = advance.base_revision,
      .summary = diff->summary,
      .progress = advance.progress,
      .troubles = std::move(troubles),
      .end = end,
      .motion_fraction = advance.motion_fraction,
      .softened_count = advance.softened_count,
      .durable_revision = DurableRevision(),
      .compute = std::chrono::duration_cast<std::chrono::microseconds>(advance.compute),
      .elapsed = std::chrono::duration_cast<std::chrono::microseconds>(now - advance.begin)};
  last_advance_end_ = now;
  environment_.log->Info("commit", {{"session", session_id_},
                                    {"update", std::to_string(advance.update_id)},
                                    {"revision", RevisionText(revision_)},
                                    {"vertices", std::to_string(diff->summary.vertex_count)},
                                    {"visits", std::to_string(advance.progress.counts.visits)},
                                    {"active", std::to_string(active_count_)}});
  Answer(advance.editor, std::move(advanced), StageEffect::kNone);
  current_editor_ = nullptr;
  current_update_id_ = 0;
  PublishInfo();
}

void Session::FailAdvance(const Error& error) {
  const RunningAdvance advance = *std::move(advance_);
  advance_.reset();
  {
    const std::lock_guard lock(mutex_);
    running_update_id_ = 0;
    stop_work_.Set(false);
  }
  last_advance_end_ = environment_.clock->Now();
  const Status status = engine_->Discard();
  PLIANT_CHECK(status.ok(), "discard", status.ok() ? "" : status.error().message);
  Reject(advance.editor, advance.update_id, error, StageEffect::kEmptied);
  PublishInfo();
}

}  // namespace pliant::server
