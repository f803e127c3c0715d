// How a session stages an update, and what it answers meanwhile; see session.h.
#include <algorithm>
#include <string>
#include <thread>
#include <utility>
#include <variant>

#include "server/revision_text.h"
#include "server/session.h"

namespace pliant::server {

/// What the engine asks while it stages: whether to give the update up. Whoever works for the
/// session asks it every few milliseconds, so that this is also where the session looks up from a
/// long update and answers an advance that is due.
///
/// *Threads*: asked() from any; only the one that made this looks up.
class Session::StagingWatch final : public StopSignal {
 public:
  explicit StagingWatch(Session& session) : session_(session) {}
  [[nodiscard]] bool asked() const override {
    if (std::this_thread::get_id() == worker_) session_.LookBehind();
    return session_.stop_work_.asked();
  }

 private:
  Session& session_;
  const std::thread::id worker_ = std::this_thread::get_id();
};

void Session::StageUpdate(const std::shared_ptr<Editor>& editor, const UpdateCommand& command) {
  const std::int64_t id = command.update_id;
  {
    const std::lock_guard lock(mutex_);
    staging_update_id_ = id;
    const bool is_cancelled = IsCancelled(id);
    stop_work_.Set(is_cancelled || editor_ != editor || close_error_ || drain_error_);
  }
  staging_ = Staging{.command = &command, .command_id = id};
  const StagingWatch watch(*this);
  const Status status = engine_->StageCommand(command, &watch);
  if (std::exchange(staging_, std::nullopt)->is_put_off) {
    EndPutOff(id, status);
    return;
  }
  bool is_awaited = false;
  {
    const std::lock_guard lock(mutex_);
    staging_update_id_ = 0;
    stop_work_.Set(false);
    // Then its editor has named it; perhaps others after it, so that the last name proves nothing.
    is_awaited = editor_ == editor && !close_error_ && !drain_error_;
  }
  if (!status.ok() && status.error().code == ErrorCode::kCancelled) {
    // Nobody waits for an answer any more: as if it had never come. Who resumes sends it again. It
    // is not done either: a stream whose commands are all done would end as if they were answered.
    if (!is_awaited) return;
    engine_->Taint();
  }
  if (!status.ok()) {
    Reject(editor, id, status.error(), StageEffect::kTainted);
    return;
  }
  SessionEvent accepted = MakeEvent(id);
  accepted.body = AcceptedEvent{.staged_count = engine_->staged_count()};
  const bool is_discard = std::holds_alternative<DiscardUpdate>(command.body);
  Answer(editor, std::move(accepted), is_discard ? StageEffect::kEmptied : StageEffect::kStaged,
         is_discard ? Bytes{} : command.form);
}

// Stages the next update of those that were answered before. Nobody can name it any more.
void Session::StagePutOff() {
  const UpdateCommand command = std::move(put_off_.front());
  put_off_.pop_front();
  {
    const std::lock_guard lock(mutex_);
    stop_work_.Set(close_error_ || drain_error_);
  }
  staging_ = Staging{.command = &command, .command_id = command.update_id, .is_put_off = true};
  const StagingWatch watch(*this);
  const Status status = engine_->StageCommand(command, &watch);
  staging_.reset();
  EndPutOff(command.update_id, status);
}

// Who sent it has been told that it is accepted. If it is not, those after it are dropped with it,
// and the next advance is refused.
void Session::EndPutOff(std::int64_t update_id, const Status& status) {
  {
    const std::lock_guard lock(mutex_);
    stop_work_.Set(false);
    // The journal has it. Without one it is lost with the session.
    if (close_error_ || drain_error_) return;
  }
  if (status.ok()) return;
  put_off_.clear();
  engine_->TaintLate(update_id, status.error());
  // Loading a session comes to the other refusals by itself.
  if (status.error().code == ErrorCode::kCancelled) RecordAnswer(nullptr, StageEffect::kTainted);
}

// Looks up while an update is staged: what has come meanwhile?
void Session::LookBehind() {
  if (stop_work_.asked()) return;
  if (staging_->is_put_off && journal_ != nullptr) journal_->ReleaseDone();
  // A step of which something was refused is to be told so, and the stage be emptied.
  if (engine_->tainted() || !IsStaging(*staging_->command)) return;
  const std::shared_ptr<Editor> editor = CurrentEditor();
  if (editor == nullptr || (!staging_->is_put_off && editor != current_editor_)) return;
  const Behind behind = SeeBehind(*editor);
  if (behind.is_discarded && staging_->is_put_off) {
    const std::lock_guard lock(mutex_);
    stop_work_.Set(true);
  } else if (behind.has_due_advance && (put_off_.empty() || behind.update_count == 0)) {
    // So what is put off once has waited in the inbox, which bounds it.
    AnswerDue(editor, behind);
  }
}

Session::Behind Session::SeeBehind(const Editor& editor) {
  Behind behind;
  std::int64_t last_id = std::max(results_.last_update_id(), staging_->command_id);
  editor.LookAhead([&](const SessionCommand& next) {
    const auto* command = std::get_if<UpdateCommand>(&next);
    if (command == nullptr || command->update_id <= last_id) return false;
    if (!results_.CheckNew(command->update_id).ok()) return false;
    last_id = command->update_id;
    bool is_cancelled = false;
    {
      const std::lock_guard lock(mutex_);
      is_cancelled = cancelled_.contains(last_id);
    }
    if (const auto* advance = std::get_if<AdvanceSpec>(&command->body)) {
      behind.has_due_advance = is_cancelled || IsDue(*advance);
      return false;
    }
    if (std::holds_alternative<DiscardUpdate>(command->body)) {
      behind.is_discarded = behind.update_count == 0;
      return false;
    }
    ++behind.update_count;
    return IsStaging(*command) && !std::holds_alternative<BadUpdate>(command->body) &&
           !is_cancelled;
  });
  return behind;
}

bool Session::IsDue(const AdvanceSpec& advance) const {
  const Clock::Time now = environment_.clock->Now();
  return advance.time_max && now >= BeginOf(advance, now) + *advance.time_max;
}

// Its client has waited as long as it wished to. Answers come in order, so what was sent before it
// is answered first.
void Session::AnswerDue(const std::shared_ptr<Editor>& editor, const Behind& behind) {
  if (!staging_->is_put_off) {
    {
      const std::lock_guard lock(mutex_);
      if (stop_work_.asked()) return;
      staging_update_id_ = 0;  // It is too late to name it, or to leave it.
    }
    staging_->is_put_off = true;
    AnswerPutOff(editor, *staging_->command);
  }
  std::optional<SessionCommand> next = editor->NextCommand();
  for (std::int32_t i = 0; next && i < behind.update_count; ++i) {
    AnswerPutOff(editor, put_off_.emplace_back(std::get<UpdateCommand>(*std::move(next))));
    next = editor->NextCommand();
  }
  // Nothing: its client is gone. What it sent is on its way to the stage all the same.
  if (next) AnswerUncommitted(editor, std::get<UpdateCommand>(*next));
  current_editor_ = nullptr;
  current_update_id_ = 0;
  Submit();
}

void Session::AnswerPutOff(const std::shared_ptr<Editor>& editor, const UpdateCommand& command) {
  current_editor_ = editor;
  current_update_id_ = command.update_id;
  update_ = command.fingerprint;
  SessionEvent accepted = MakeEvent(command.update_id);
  const auto waiting_count = static_cast<std::int32_t>(put_off_.size());
  accepted.body = AcceptedEvent{.staged_count = engine_->staged_count() + 1 + waiting_count};
  Answer(editor, std::move(accepted), StageEffect::kPutOff, command.form);
}

void Session::AnswerUncommitted(const std::shared_ptr<Editor>& editor,
                                const UpdateCommand& command) {
  current_editor_ = editor;
  current_update_id_ = command.update_id;
  update_ = command.fingerprint;
  const Clock::Time now = environment_.clock->Now();
  const Clock::Time begin = BeginOf(std::get<AdvanceSpec>(command.body), now);
  last_advance_end_ = now;
  Progress progress;
  progress.stop_reason = StopReason::kVisitBudget;
  progress.active_count = active_count_;
  SessionEvent advanced = MakeEvent(command.update_id);
  advanced.body =
      AdvancedEvent{.base_revision = revision_,
                    .summary = summary_.value_or(MeshSummary{}),
                    .progress = progress,
                    .end = AdvanceEnd::kStaging,
                    .durable_revision = DurableRevision(),
                    .elapsed = std::chrono::duration_cast<std::chrono::microseconds>(now - begin)};
  environment_.log->Info("due", {{"session", session_id_},
                                 {"update", std::to_string(command.update_id)},
                                 {"revision", RevisionText(revision_)}});
  Answer(editor, std::move(advanced), StageEffect::kNone);
}

}  // namespace pliant::server
