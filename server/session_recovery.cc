// What a session does when a bug is met inside it, and how it ends; see session.h.
#include <exception>
#include <string>
#include <utility>

#include "server/revision_text.h"
#include "server/session.h"

namespace pliant::server {

// A check failed inside the engine, or memory ran out. The session goes back to its last commit if
// its mesh is provably valid there, else it ends; either way the client is told.
void Session::HandleBug(const std::string& what) {
  const std::string reference =
      session_id_ + "-" + RevisionText(revision_) + "-" +
      std::to_string(environment_.clock->WallNow().time_since_epoch().count());
  environment_.log->Error("bug",
                          {{"session", session_id_}, {"reference", reference}, {"what", what}});
  std::shared_ptr<Editor> editor = current_editor_;
  std::int64_t update_id = current_update_id_;
  if (advance_) {
    editor = advance_->editor;
    update_id = advance_->update_id;
  }
  advance_.reset();
  const bool was_put_off = staging_ && staging_->is_put_off;
  const std::int64_t staging_id = staging_ ? staging_->command_id : 0;
  staging_.reset();
  put_off_.clear();
  current_editor_ = nullptr;
  current_update_id_ = 0;
  const SessionCall call = std::exchange(current_call_, nullptr);
  {
    const std::lock_guard lock(mutex_);
    running_update_id_ = 0;
    staging_update_id_ = 0;
    stop_work_.Set(false);
  }
  const bool recovered = Recover();
  // Whatever was staged is gone, also where the bug was in no numbered update.
  if (update_id == 0) RecordAnswer(nullptr, StageEffect::kEmptied);
  const Error error{
      ErrorCode::kInternal,
      "a bug of the server was met; the session " +
          (recovered || journal_ != nullptr ? "is back at revision " + RevisionText(revision_)
                                            : std::string("has ended")) +
          "; please report it with reference " + reference,
      reference};
  // Its editor was told that it is accepted: the next advance must not go without it.
  if (was_put_off && recovered) {
    engine_->TaintLate(staging_id, error);
    RecordAnswer(nullptr, StageEffect::kTainted);
  }
  // Before anybody is told: who then looks for the session does not find it any more.
  if (!recovered && journal_ == nullptr) environment_.on_broken(session_id_);
  if (call) call(error);
  EndCall(error);
  if (editor != nullptr && update_id > results_.last_update_id()) {
    Reject(editor, update_id, error, StageEffect::kEmptied);
  } else if (editor != nullptr && update_id == 0) {
    // It was opening: it has no answer to wait for, so it is told by the end of its stream.
    Detach(editor.get());
    editor->Close(error);
  }
  if (!recovered && journal_ != nullptr) {
    // What is stored is whole: the session goes on from there, as after a crash.
    memory_lost_ = true;
    return;
  }
  if (!recovered) {
    Close(error);
    return;
  }
  PublishInfo();
}

bool Session::Recover() {
  if (!engine_) return false;
  try {
    const Status status = engine_->Discard();
    return status.ok() && engine_->revision() == revision_ && engine_->engine().Validate().empty();
  } catch (const std::exception& exception) {
    environment_.log->Error("recovery_failed",
                            {{"session", session_id_}, {"what", exception.what()}});
    return false;
  }
}

void Session::TearDown(const Error& error) {
  torn_down_ = true;
  if (journal_ != nullptr) journal_->Drop(error);
  advance_.reset();
  put_off_.clear();
  EndCall(error);
  engine_.reset();
  history_ = DiffHistory(0);
  undo_.Clear();
  ReportUsage();
  PublishRest();
  DeleteStored();  // Whoever is told of it may use at once what the session gave back.
  std::shared_ptr<Editor> editor;
  std::optional<StartRequest> start;
  {
    const std::lock_guard lock(mutex_);
    editor = std::exchange(editor_, nullptr);
    start = std::exchange(start_, std::nullopt);
    if (!close_error_) close_error_ = error;
  }
  if (start) start->done(error);
  if (editor != nullptr) editor->Close(error);
  followers_.CloseAll(error);
  for (;;) {
    std::optional<SessionCall> call;
    {
      const std::lock_guard lock(mutex_);
      call = calls_.Pop();
    }
    if (!call) return;
    (*call)(error);
  }
}

}  // namespace pliant::server
